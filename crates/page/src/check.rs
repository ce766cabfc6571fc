//! What is wrong with a spec, by line.

use crate::edit;
use phisindy::files::{Purpose, Request, load_text};
use phisindy_phys::{Diagnostic, Sources};
use serde_json::{Value, json};
use std::path::Path;

/// The mistakes and warnings of a spec, as `phisindy check` finds them: data files are read if they are
/// there.
pub(crate) fn check(path: &Path, text: &str, request: &Request) -> Value {
    let (mut sources, mut found) = (Sources::default(), Vec::new());
    let loaded = load_text(path, text.to_owned(), request, Purpose::Check, &mut sources, &mut found);
    let told = said(&found, &sources, loaded.is_ok());
    let mut all = edit::shown(text);
    (all["ok"], all["diagnostics"]) = (json!(loaded.is_ok()), json!(told));
    all["open"] = json!(loaded.is_ok_and(|l| l.case.is_open()));
    all
}

/// Diagnostics as data. Beside a mistake warnings are mostly its consequences: they are left out.
pub(crate) fn said(found: &[Diagnostic], sources: &Sources, warnings: bool) -> Vec<Value> {
    found.iter().filter(|d| d.is_error() || warnings).map(|d| one(d, sources)).collect()
}

/// One diagnostic: its place is in the spec (`line`, `column`, `length` in characters), or in another file by
/// its name.
fn one(d: &Diagnostic, sources: &Sources) -> Value {
    let place = d.labels.iter().find(|l| l.primary).and_then(|l| {
        let source = sources.files.get(l.source.0)?;
        let (line, column) = source.line_and_column(l.span.start);
        let marked = source.text.get(l.span.range()).and_then(|t| t.lines().next()).unwrap_or_default();
        Some(json!({
            "file": if l.source.0 == 0 { Value::Null } else { json!(source.name) },
            "line": line, "column": column, "length": marked.chars().count().max(1), "words": l.message,
        }))
    });
    json!({ "error": d.is_error(), "message": d.message, "help": d.help, "place": place })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mistake_has_its_line() {
        let text = "(\n  states: { \"x\": \"m\", \"v\": \"m/s\" },\n  known: { \"x\": \"v\", \"v\": \"-kk*x\" },\n  data: [Synthetic(truth: {}, start: { \"x\": 1.0, \"v\": 0.0 }, duration: 9.0, step: 0.1)],\n)";
        let told = check(Path::new("a.ron"), text, &Request::default());
        let mistake = &told["diagnostics"][0];
        assert!(told["ok"] == false && mistake["error"] == true, "{told}");
        assert_eq!(
            (&mistake["place"]["line"], &mistake["place"]["length"]),
            (&json!(3), &json!(2)),
            "{told}"
        );
        assert!(
            mistake["place"]["file"].is_null() && mistake["message"].as_str().unwrap().contains("kk"),
            "{told}"
        );
    }
}
