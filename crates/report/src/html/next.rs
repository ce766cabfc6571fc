//! What to do next, where a result cannot be used.

use super::page::{Page, worded};
use crate::format::capital;
use crate::markup::element;
use phisindy_learn::Rejection;
use phisindy_phys::{Diagnostic, Sources};

/// Begins a page with a numbered list of steps, if there are any.
pub(crate) fn add(page: &mut Page, steps: &[String]) {
    let items = steps.iter().map(|step| worded(element("li"), &capital(step)));
    let list = element("ol").all(items);
    page.section("What to do next", (!steps.is_empty()).then_some(list));
}

/// A mistake of a spec: what is wrong, in which line, what helps.
pub(crate) struct Mistake<'a> {
    what: &'a str,
    line: Option<usize>,
    helps: &'a [String],
}

impl<'a> Mistake<'a> {
    /// Of an error; its place is the first that it is about.
    pub(crate) fn new(error: &'a Diagnostic, sources: &Sources) -> Mistake<'a> {
        let line = error.labels.iter().find(|label| label.primary).and_then(|label| {
            let source = sources.files.get(label.source.0)?;
            Some(source.line_and_column(label.span.start).0)
        });
        Mistake { what: &error.message, line, helps: &error.help }
    }

    /// `unknown name `xx` (line 9)`.
    pub(crate) fn said(&self) -> String {
        match self.line {
            Some(line) => format!("{} (line {line})", self.what),
            None => self.what.to_owned(),
        }
    }
}

/// What to do about each mistake, each advice once, and then to check again.
pub(crate) fn repairs(all: &[Mistake<'_>], spec: &str) -> Vec<String> {
    let mut out: Vec<String> = Vec::new();
    let mut told: Vec<&String> = Vec::new();
    for mistake in all {
        let new: Vec<&String> = mistake.helps.iter().filter(|help| !told.contains(help)).collect();
        if new.is_empty() && !mistake.helps.is_empty() {
            continue;
        }
        told.extend(&new);
        let line = mistake.line.map_or(String::new(), |line| format!("line {line}: "));
        let helps: String = new.iter().map(|help| format!(": {help}")).collect();
        out.push(format!("{line}{}{helps}", mistake.what));
    }
    out.push(format!("Then check again: `phisindy check {spec}`"));
    out
}

/// The title in the text of a spec that cannot be read.
pub(crate) fn title_of(text: &str) -> Option<String> {
    let field = |line: &str| {
        let (_, rest) = line.trim_start_matches([' ', '\t', '(']).strip_prefix("title")?.split_once(':')?;
        let (title, _) = rest.trim_start().strip_prefix('"')?.split_once('"')?;
        Some(title.to_owned())
    };
    text.lines().find_map(field).filter(|title| !title.is_empty() && !title.contains('\\'))
}

/// What to do first where the search was stopped.
pub(crate) fn after_stop(spec: &str) -> String {
    format!("Let it go to its end: `phisindy gap {spec}`, or give it more time with `--limit`.")
}

/// What to do where no law explains.
pub(crate) fn after_unexplained(spec: &str) -> Vec<String> {
    [
        "See where the gap sits, below: at which speeds, displacements or times does the model miss?".to_owned(),
        "Check what the spec holds for known (units, signs, constants): warnings say what looks odd.".to_owned(),
        format!("Write a law of your own: `phisindy laws new NAME --out laws`, then `phisindy gap {spec} --laws laws`."),
        "Record the motion at other amplitudes and speeds: it tells what the missing force depends on.".to_owned(),
    ]
    .to_vec()
}

/// What to do about a rejection.
pub(crate) fn after_rejection(why: &Rejection, spec: &str) -> Vec<String> {
    let steps: &[&str] = match why {
        Rejection::NoTerms { .. } | Rejection::NothingMissing => &[
            "Look at the NRMSE of the known part alone: is it as small as the noise? Then the model is complete as it is.",
            "If it is not, the dictionary lacks the right candidate: `phisindy gap SPEC` tries every law of the catalogue.",
        ],
        Rejection::FitFailed(_) => &[
            "Start movable constants nearer to what you expect: `(value: .., within: (.., ..))`.",
            "Hold some of them at first, and free them once the fit follows the motion.",
        ],
        Rejection::RunFails { .. }
        | Rejection::RunMisses { .. }
        | Rejection::LawMissing { .. }
        | Rejection::NoBetter => &[
            "Look at the figure of the motion below: does the model miss the size, the frequency or the moment of the stops?",
            "Check the units of the columns, the signs in the known part, and the constants that you are least sure of; let those move.",
            "Ask what is missing: `phisindy gap SPEC` tries every law of the catalogue at every place.",
        ],
        Rejection::Unfulfilled(_) | Rejection::LawAtBound { .. } => &[
            "Try a simpler or a richer law of the same family: `phisindy laws` lists them.",
            "If no law fits, `phisindy gap SPEC` compares all of them.",
        ],
        Rejection::Feeds(_) => &[
            "Check the signs of forces and columns: a passive part cannot feed the motion.",
            "Record a motion at other speeds: this one does not tell the friction near rest from the rest.",
        ],
    };
    steps.iter().map(|s| s.replace("SPEC", spec)).collect()
}

#[cfg(test)]
mod tests {
    use super::{Mistake, repairs, title_of};
    use phisindy_expr::Span;
    use phisindy_phys::{Diagnostic, Sources};

    #[test]
    fn each_mistake_has_its_line_and_each_advice_is_said_once() {
        let mut sources = Sources::default();
        let spec = sources.add_excerpt("a.ron", "y: xx,\n\n\nz: xx", 9);
        let error = |at: usize| {
            let place = Span::new(at, at + 2);
            Diagnostic::error("unknown name `xx`").at(spec, place, "").help("did you mean `x`?")
        };
        let errors = [error(3), error(12)];
        let all: Vec<Mistake<'_>> = errors.iter().map(|e| Mistake::new(e, &sources)).collect();
        assert_eq!(all[1].said(), "unknown name `xx` (line 12)");
        let due =
            ["line 9: unknown name `xx`: did you mean `x`?", "Then check again: `phisindy check a.ron`"];
        assert_eq!(repairs(&all, "a.ron"), due);
    }

    #[test]
    fn the_title_of_a_broken_spec_is_read() {
        assert_eq!(title_of("// title: \"no\"\n(title: \"A rig\", states: {").as_deref(), Some("A rig"));
        assert_eq!(title_of("(\n    title : \"A rig\",\n").as_deref(), Some("A rig"));
        assert_eq!(title_of("(states: {})"), None);
    }
}
