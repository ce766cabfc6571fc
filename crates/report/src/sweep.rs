//! The result of a sweep: many seeds of one case, in cells that differ in noise, cut-off or anything else.

mod json;
mod runs;
mod statistics;
mod text;

pub use runs::{CellRuns, Found, NamedTruth, Run, RunVerdict, SweepRuns, TermName};
pub use statistics::{Coefficient, Statistics};

use crate::format::Format;

impl SweepRuns<'_> {
    /// The result in one of its forms, with an end of line. The table is the same in LaTeX, as comments.
    pub fn written(&self, format: Format) -> String {
        match format {
            Format::Json => json::line(self) + "\n",
            of_text => of_text.lines(text::table(self)),
        }
    }
}
