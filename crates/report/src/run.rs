//! The result of `run`: an identified model.

mod adapted;
mod contribution;
mod fixed;
mod json;
mod report;
mod text;

pub use report::RunReport;

use crate::format::Format;

impl RunReport<'_> {
    /// The result in one of its forms, with an end of line.
    pub fn written(&self, format: Format) -> String {
        match format {
            Format::Json => json::line(self) + "\n",
            Format::Latex => text::latex(self),
            Format::Text => text::plain(self),
        }
    }
}
