//! A law with the text that defines it.

use phisindy_phys::Law;

/// A law of a catalogue.
#[derive(Clone, Debug)]
pub struct LawFile {
    /// The name of the law in specs and results: the name of its file.
    pub id: String,
    /// The text of the file.
    pub text: String,
    /// The law as read from the text.
    pub law: Law,
}
