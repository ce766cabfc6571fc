//! The mistakes of a text as an editor shows them: those of `phisindy check`.

use crate::descriptions::Known;
use crate::document::Document;
use crate::position::range;
use lsp_types::{DiagnosticRelatedInformation, DiagnosticSeverity, Location, Range, Uri};
use phisindy::files::{Purpose, Request, beside, load_text};
use phisindy_phys::{Diagnostic, Law, Severity, SourceId, Sources, measures, spec};
use std::path::Path;

/// The mistakes of a spec with its data files, or of a law.
pub(crate) fn mistakes(uri: &Uri, path: &Path, text: &str, request: &Request) -> Vec<lsp_types::Diagnostic> {
    let (mut sources, mut found) = (Sources::default(), Vec::new());
    if Document::new(text, path).is_law() {
        let source = sources.add(path.display().to_string(), text);
        found = Law::checked(text, source).err().unwrap_or_default();
        if found.is_empty() {
            let own = path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
            let laws = laws(path, request).into_iter().map(|(id, _)| id).chain(own).collect::<Vec<_>>();
            let known: Vec<&str> = laws.iter().map(String::as_str).collect();
            found = Law::unknown_references(text, source, &known);
        }
    } else {
        // The text is the first source.
        let loaded = load_text(path, text.to_owned(), request, Purpose::Check, &mut sources, &mut found);
        // Beside a mistake warnings are mostly its consequences.
        found.retain(|d| loaded.is_ok() || d.is_error());
    }
    found.iter().map(|d| converted(d, uri, text, &sources)).collect()
}

fn converted(d: &Diagnostic, uri: &Uri, text: &str, sources: &Sources) -> lsp_types::Diagnostic {
    let (here, elsewhere): (Vec<_>, Vec<_>) = d.labels.iter().partition(|label| label.source == SourceId(0));
    let main = here.iter().find(|label| label.primary).or(here.first());
    let mut message = d.message.clone();
    message += &main.filter(|l| !l.message.is_empty()).map_or(String::new(), |l| format!(" ({})", l.message));
    for label in elsewhere {
        let source = sources.get(label.source);
        let (line, column) = source.line_and_column(label.span.start);
        message += &format!("\nat {}:{line}:{column} {}", source.name, label.message);
    }
    d.help.iter().for_each(|line| message += &format!("\nhelp: {line}"));
    let others = here.iter().filter(|label| main.is_some_and(|main| main != *label));
    let related = others.map(|label| DiagnosticRelatedInformation {
        location: Location::new(uri.clone(), range(text, label.span)),
        message: label.message.clone(),
    });
    lsp_types::Diagnostic {
        range: main.map_or(Range::default(), |label| range(text, label.span)),
        severity: Some(match d.severity {
            Severity::Error => DiagnosticSeverity::ERROR,
            Severity::Warning => DiagnosticSeverity::WARNING,
        }),
        source: Some("phisindy".to_owned()),
        message,
        related_information: Some(related.collect()),
        ..lsp_types::Diagnostic::default()
    }
}

/// The laws that a text may name, each with what it is.
fn laws(path: &Path, request: &Request) -> Vec<(String, String)> {
    // A law finds its neighbours beside itself.
    let folder = path.parent().filter(|parent| parent.ends_with("laws")).unwrap_or(path);
    let all = beside(folder, request).unwrap_or_else(|_| phisindy::Catalogue::built_in());
    all.laws()
        .iter()
        .map(|entry| (entry.id.clone(), format!("{}. {}", entry.law.name, entry.law.about)))
        .collect()
}

/// What is known of a text beside itself; its names keep what they measured where it has a mistake now.
pub(crate) fn known(path: &Path, text: &str, request: &Request, before: Known) -> Known {
    let checked = spec::read_without_data(text, SourceId(0))
        .ok()
        .filter(|(spec, _)| phisindy_phys::check_names(spec, SourceId(0)).is_ok())
        .map(|(spec, _)| measures(&spec));
    let laws = if before.laws.is_empty() { laws(path, request) } else { before.laws };
    Known { measures: checked.unwrap_or(before.measures), laws }
}
