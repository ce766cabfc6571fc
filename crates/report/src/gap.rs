//! The result of `gap`: which effects the model lacks.

mod balance;
mod discovered_force;
mod finding;
mod json;
mod outcome;
mod report;
mod terminal;
mod text;

pub(crate) use balance::{Balance, RecordForce, balance};
pub(crate) use discovered_force::remarks;
pub(crate) use finding::{Finding, counted, finding, symbol};
pub(crate) use outcome::basis;
pub use report::GapReport;
pub(crate) use text::rivals;

use crate::Look;
use crate::format::Format;

impl GapReport<'_> {
    /// The result in one of its forms, with an end of line; there is none in LaTeX, which is plain text here.
    pub fn written(&self, format: Format) -> String {
        match format {
            Format::Json => json::line(self) + "\n",
            Format::Text | Format::Latex => text::text(self),
        }
    }

    /// The result for people at a terminal.
    pub fn at_terminal(&self, look: Look) -> String {
        terminal::text(self, look)
    }

    /// `result.json`: the object on lines of its own.
    pub fn json_lines(&self) -> String {
        json::lines(self) + "\n"
    }

    /// `gap.txt`: the text, and what the terminal is told beside it: what is odd about the data, and what a
    /// careful reader should know.
    pub fn text_with_remarks(&self) -> String {
        let data = self.input.doubts.iter().map(|doubt| format!("warning: {doubt}\n"));
        let remarks: String = data.chain(self.notes().map(|note| format!("note: {note}\n"))).collect();
        text::text(self) + &remarks
    }
}
