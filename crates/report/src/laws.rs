//! Laws of a catalogue, as text and as pictures.

mod picture;
mod words;

pub use picture::picture;
pub use words::{gallery, list, shown};
