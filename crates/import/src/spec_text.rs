//! The text of a draft: a spec with comments for its user.

mod literals;
mod model;
mod notation;
mod overview;
mod record;
mod tester;

use crate::draft::Draft;
pub(crate) use literals::quoted;
use notation::Notation;
pub use overview::summary;
use phisindy_phys::{Diagnostic, SourceId};
use std::fmt::Write;

/// What to type next: `gap` for a tester, whose spec has no candidates, else `run`.
pub fn next_step(draft: &Draft) -> &'static str {
    if tester::of(draft).is_some() { "gap" } else { "run" }
}

/// Writes the spec; `file` is the name of the data file, `next` the arguments of the next command.
pub fn spec_text(draft: &Draft, file: &str, next: &str) -> String {
    let mut text = String::new();
    for line in overview::head(draft, file, next) {
        // A heading may contain line breaks.
        let _ = writeln!(text, "{}", format!("// {}", line.replace(['\n', '\r'], " ")).trim_end());
    }
    let notation = Notation::of(draft);
    let _ = writeln!(text, "(\n    title: {}, // EDIT: what is it?", quoted(file));
    if let Some(tester) = tester::of(draft) {
        tester.write(&mut text);
    } else {
        model::constants(draft, &notation, &mut text);
        model::model(draft, &notation, &mut text);
    }
    text.push_str("    data: [\n");
    for part in &draft.records {
        record::record(draft, &notation, part, file, &mut text);
    }
    text.push_str("    ],\n)\n");
    text
}

/// Whether a spec passes all checks.
///
/// # Errors
/// The message of the first mistake.
pub fn accepted(text: &str) -> Result<(), String> {
    let first = |all: Vec<Diagnostic>| {
        all.into_iter().find(Diagnostic::is_error).map_or(String::new(), |d| d.message)
    };
    let (spec, _) = phisindy_phys::spec::read(text, SourceId(0)).map_err(first)?;
    phisindy_phys::check(&spec, SourceId(0)).map(|_| ()).map_err(first)
}
