//! The result of `run`: an identified model.

mod adapted;
mod contribution;
mod finding;
mod fixed;
mod json;
mod report;
mod resistance;
mod terminal;
mod text;

pub use report::RunReport;

pub(crate) use finding::found_words;
pub(crate) use resistance::{Resistance, resistance};
pub(crate) use terminal::warnings as terminal_warnings;

use crate::Look;
use crate::format::Format;

impl RunReport<'_> {
    /// The result for people at a terminal.
    pub fn at_terminal(&self, look: Look) -> String {
        terminal::text(self, look)
    }

    /// The result in one of its forms, with an end of line.
    pub fn written(&self, format: Format) -> String {
        match format {
            Format::Json => json::line(self) + "\n",
            Format::Latex => text::latex(self),
            Format::Text => text::plain(self),
        }
    }
}
