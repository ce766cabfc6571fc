//! What to do next, where a result cannot be used.

use super::page::{Page, block, capital, worded};
use crate::markup::element;
use phisindy_learn::Rejection;

/// Begins a page with a numbered list of steps, and a command.
pub(crate) fn add(page: &mut Page, steps: &[String], command: Option<&str>) {
    if steps.is_empty() && command.is_none() {
        return;
    }
    let items = steps.iter().map(|step| worded(element("li"), &capital(step)));
    let list = element("ol").all(items);
    let command = command.map(|command| block(command, "next command"));
    let list = (!steps.is_empty()).then_some(list);
    page.section("What to do next", list.into_iter().chain(command));
}

/// The advice that stands in drawn mistakes, each once: their `help:` lines.
pub(crate) fn helps(mistakes: &str) -> Vec<String> {
    let mut out: Vec<String> = Vec::new();
    for line in mistakes.lines() {
        let Some((_, help)) = line.split_once("help: ") else { continue };
        let help = help.trim().to_owned();
        if !help.is_empty() && !out.contains(&help) {
            out.push(help);
        }
    }
    out
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
    use super::helps;

    #[test]
    fn each_advice_is_said_once() {
        let drawn = "error: unknown name\n  = help: write `x`\n  = help: write `x`\n  = note: why\n";
        assert_eq!(helps(drawn), ["write `x`"]);
    }
}
