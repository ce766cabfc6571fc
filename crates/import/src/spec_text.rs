//! The text of a draft: a spec with comments for its user.

pub(crate) mod literals;
mod model;
mod notation;
mod overview;
mod quarter_car;
pub(crate) mod record;
mod several_files;
mod tester;

use crate::draft::Draft;
pub(crate) use literals::quoted;
use notation::Notation;
pub use overview::summary;
use phisindy_phys::{Diagnostic, SourceId};
use std::fmt::Write;

/// What to type next: `gap` where the spec has no candidates, else `run`.
pub fn next_step(draft: &Draft) -> &'static str {
    if tester::of(draft).is_some() || quarter_car::is_one(draft) { "gap" } else { "run" }
}

/// Writes the spec; `file` is the name of the data file, `next` the arguments of the next command.
pub fn spec_text(draft: &Draft, file: &str, next: &str) -> String {
    written(&[(draft, file)], next)
}

/// One spec for several files of one rig, each with its draft and its name: the model is that of the first one.
///
/// # Errors
/// In words: which file is read in another way than the first one.
pub fn spec_text_of(drafts: &[(&Draft, &str)], next: &str) -> Result<String, String> {
    match drafts.iter().find_map(|other| several_files::unlike(drafts[0], *other)) {
        Some(why) => Err(why),
        None => Ok(written(drafts, next)),
    }
}

fn written(drafts: &[(&Draft, &str)], next: &str) -> String {
    let (draft, file) = drafts[0];
    let mut text = String::new();
    let mut head = overview::head(draft, file, next);
    let loads = if drafts.len() > 1 { several_files::loads(drafts) } else { None };
    if drafts.len() > 1 {
        let all = drafts.iter().map(|(_, file)| *file).collect::<Vec<_>>().join(", ");
        head.push(format!("The records are those of {all}; the numbers above are those of the first file."));
        let differ = several_files::differences(drafts);
        let what =
            if differ.is_empty() { "nothing that the files say".to_owned() } else { differ.join("; ") };
        head.push(match loads {
            Some(_) => format!("What differs between them is {what}. EDIT: it is taken for the load, a part of the mass."),
            None => format!(
                "EDIT: what differs between them is {what}. If it is a load, write it into each record, as in `constants: {{ \"N\": (2.5, \"N\") }}`, and into the model."
            ),
        });
    }
    for line in head {
        // A heading may contain line breaks.
        let _ = writeln!(text, "{}", format!("// {}", line.replace(['\n', '\r'], " ")).trim_end());
    }
    let notation = Notation::of(draft);
    let _ = writeln!(text, "(\n    title: {}, // EDIT: what is it?", quoted(file));
    if let Some(tester) = tester::of(draft) {
        tester.write(&mut text);
    } else if quarter_car::is_one(draft) {
        quarter_car::write(draft, &mut text);
    } else {
        let load = loads.as_ref().map(|loads| loads[0]);
        model::constants(draft, &notation, load, &mut text);
        model::model(draft, &notation, &mut text);
    }
    text.push_str("    data: [\n");
    for (k, (draft, file)) in drafts.iter().enumerate() {
        let load = loads.as_ref().map(|loads| loads[k]);
        for part in &draft.records {
            let name = match drafts.len() {
                1 => part.name.clone(),
                _ => format!("{} {}", file.rsplit_once('.').map_or(*file, |(stem, _)| stem), part.name),
            };
            record::record(draft, &notation, part, (file, &name), load, &mut text);
        }
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
