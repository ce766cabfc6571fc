//! How the search ended, in words.

use crate::table::short;
use phisindy_gap::{Alternative, Gap, Status, Warning};

/// A larger gap is more than noise.
pub(super) const NOISE: f64 = 1.1;

/// The data that the shown gap refers to.
pub(crate) fn basis(found: &Gap) -> &'static str {
    if found.before.1.is_some() { "on data not used" } else { "on the fitted data" }
}

/// The outcome in words, behind its status.
pub(crate) fn outcome(found: &Gap) -> String {
    let shown = |(fit, validate): (f64, Option<f64>)| validate.unwrap_or(fit);
    let (before, last) = (shown(found.before), shown(found.after));
    match found.status {
        Status::NothingMissing => {
            let sensitive = sensitivity(found);
            let to = if leaves_noise(found) { " to their noise" } else { limit(found) };
            format!("the model explains the data{to} (gap {}{sensitive})", short(last))
        }
        Status::Undetermined if found.interrupted() => format!(
            "the search ended before it was done: the gap {} went from {} to {} so far",
            basis(found),
            short(before),
            short(last)
        ),
        // The model as it is leaves noise, and a law might be there all the same.
        Status::Undetermined if found.steps.is_empty() => {
            let fitted = found.tried.iter().filter(|t| t.gap.is_some());
            let nearest = fitted.max_by(|a, b| a.score.total_cmp(&b.score));
            let law = nearest.map_or("a law".to_owned(), |t| t.at.to_string());
            let left = if leaves_noise(found) {
                format!("only noise (gap {})", short(last))
            } else {
                format!("a gap of {}{}", short(last), limit(found))
            };
            let coarse = has_coarse_input(found);
            let would =
                if coarse { "an input that is recorded faster" } else { "longer ones or a larger motion" };
            format!(
                "the model leaves {left}, but these records do not tell whether {law} is there too; {would} would"
            )
        }
        Status::Named => {
            let left = match found.alternative {
                Some(Alternative::Pushes(_)) => "a force that nobody measured",
                _ => "a force in another form",
            };
            format!(
                "the gap {} went from {} to {}, and {left} is left",
                basis(found),
                short(before),
                short(last)
            )
        }
        Status::Explained | Status::Described | Status::Undetermined => {
            let why = match sensitivity(found) {
                words if !words.is_empty() => words,
                _ if last > NOISE => limit(found).to_owned(),
                _ => String::new(),
            };
            format!("the gap {} went from {} to {}{why}", basis(found), short(before), short(last))
        }
        Status::Unexplained => {
            let place =
                found.left.first().map_or(String::new(), |r| format!(", mostly in {}, {r}", r.column));
            let doubted = found.warnings.iter().any(|w| {
                matches!(w, Warning::Vetoed(_) | Warning::Cancelling(_) | Warning::SensorNonlinearity(_))
            });
            let words = match found.alternative {
                _ if found.interrupted() => "the search ended before it was done",
                Some(_) => "no law here explains it, but something else would (see above)",
                None if doubted && last <= NOISE => {
                    "what was added leaves only noise, but evidence speaks against it (see above)"
                }
                None => "something is missing that no law here and no formula explains",
            };
            format!("{words}: a gap of {} is left{place}", short(last))
        }
    }
}

/// Whether the model leaves noise alone, if its numbers move within their error bars.
fn leaves_noise(found: &Gap) -> bool {
    found.after.1.unwrap_or(found.after.0) <= NOISE || !sensitivity(found).is_empty()
}

/// Whether the samples of an input are too few to tell what is missing.
pub(super) fn has_coarse_input(found: &Gap) -> bool {
    found.warnings.iter().any(|w| matches!(w, Warning::CoarseInput(_)))
}

/// Why no model can come nearer than a gap above the noise.
fn limit(found: &Gap) -> &'static str {
    if has_coarse_input(found) {
        ", as near as the few samples of its input allow"
    } else if matches!(found.alternative, Some(Alternative::InputNoise(_))) {
        ", as near as the noise of its input allows"
    } else if found.repeat.is_empty() {
        ", and what is left is noise of another colour or size than the columns tell"
    } else {
        ", which is about what the motion itself repeats to"
    }
}

/// If the motion on Validate records is sensitive to uncertain parameters: the gap that remains when these
/// move within their errors.
pub(super) fn sensitivity(found: &Gap) -> String {
    match (found.after.1, found.predictive) {
        (Some(gap), Some(left)) if gap > NOISE && left < NOISE => {
            format!(
                "; {} with the numbers moved within their error bars, on which the motion there hangs",
                short(left)
            )
        }
        _ => String::new(),
    }
}
