//! What to do next, where a result cannot be used.

use super::page::{Page, worded};
use crate::format::capital;
use crate::markup::element;
use phisindy_learn::Rejection;

/// Begins a page with a numbered list of steps, if there are any.
pub(crate) fn add(page: &mut Page, steps: &[String]) {
    let items = steps.iter().map(|step| worded(element("li"), &capital(step)));
    let list = element("ol").all(items);
    page.section("What to do next", (!steps.is_empty()).then_some(list));
}

/// A mistake as it is drawn: what is wrong, in which line, what helps.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Mistake {
    what: String,
    line: Option<String>,
    helps: Vec<String>,
}

impl Mistake {
    /// `unknown name `xx` (line 9)`.
    pub(crate) fn said(&self) -> String {
        match &self.line {
            Some(line) => format!("{} (line {line})", self.what),
            None => self.what.clone(),
        }
    }
}

/// The drawn mistakes.
pub(crate) fn mistakes(drawn: &str) -> Vec<Mistake> {
    let mut out: Vec<Mistake> = Vec::new();
    for line in drawn.lines() {
        if let Some(what) = line.strip_prefix("error: ") {
            out.push(Mistake { what: what.trim().to_owned(), line: None, helps: vec![] });
        }
        let Some(last) = out.last_mut() else { continue };
        if let Some((_, place)) = line.split_once("┌─ ") {
            last.line = place.rsplit(':').nth(1).map(str::to_owned);
        }
        if let Some((_, help)) = line.split_once("help: ") {
            last.helps.push(help.trim().to_owned());
        }
    }
    out
}

/// What to do about each mistake, each advice once, and then to check again.
pub(crate) fn repairs(all: &[Mistake], spec: &str) -> Vec<String> {
    let mut out: Vec<String> = Vec::new();
    let mut told: Vec<&String> = Vec::new();
    for mistake in all {
        let new: Vec<&String> = mistake.helps.iter().filter(|help| !told.contains(help)).collect();
        if new.is_empty() && !mistake.helps.is_empty() {
            continue;
        }
        told.extend(&new);
        let line = mistake.line.as_ref().map_or(String::new(), |line| format!("line {line}: "));
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
        Rejection::RunFails { .. } | Rejection::RunMisses { .. } | Rejection::NoBetter => &[
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
    use super::{mistakes, repairs, title_of};

    #[test]
    fn each_mistake_has_its_line_and_each_advice_is_said_once() {
        let drawn = "error: unknown name `xx`\n  ┌─ a.ron:9:18\n  = help: did you mean `x`?\n\n\
                     error: unknown name `xx`\n  ┌─ a.ron:12:3\n  = help: did you mean `x`?\n";
        let all = mistakes(drawn);
        assert_eq!(
            all.iter().map(super::Mistake::said).collect::<Vec<_>>()[1],
            "unknown name `xx` (line 12)"
        );
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
