//! Laws of a catalogue, as text and as pictures.

mod file;
mod picture;
mod words;

pub use file::LawFile;
pub use picture::picture;
pub use words::{gallery, list, shown};
