//! What an editor is told of a spec or a law.
//!
//! ```text
//! fields (phys) --+--> schema
//!                 +--> document: what may stand at a place --> complete, hover --+
//!                      phisindy::files --> diagnose: what `phisindy check` says -+--> server --> editor
//! ```
//!
//! The table of fields is that of the reader, and the mistakes are those of `phisindy check`.

mod complete;
mod descriptions;
mod diagnose;
mod document;
mod hover;
mod position;
mod schema;
mod server;

pub use complete::{Completion, complete};
pub use descriptions::Known;
pub use document::{Declared, Document, Place, Wants};
pub use hover::hover;
pub use schema::schema;
pub use server::serve;
