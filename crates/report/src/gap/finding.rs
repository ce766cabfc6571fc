//! The finding in one sentence, with its numbers.

use super::outcome::{NOISE, basis, has_coarse_input, outcome, sensitivity};
use crate::format::capital;
use crate::table::{raised, short, with_error};
use crate::terminal::unicode;
use phisindy_gap::{Alternative, CHANGED, DISCOVERED, Gap, Status, Step, StepParameter};

/// Most parameters of one effect in the sentence; the others stand in its table.
const NUMBERS: usize = 2;

/// The verdict in a word and the finding in a sentence.
pub(crate) struct Finding {
    /// `Explained`.
    pub(crate) headline: &'static str,
    /// What is missing, how much, and what is left.
    pub(crate) sentence: String,
}

/// The gap that counts: on Validate records where there are any.
pub(crate) fn counted((fit, validate): (f64, Option<f64>)) -> f64 {
    validate.unwrap_or(fit)
}

/// The finding.
pub(crate) fn finding(found: &Gap) -> Finding {
    let (before, after) = (counted(found.before), counted(found.after));
    let all: Vec<String> = found.steps.iter().map(effect).collect();
    let fall = fall(before, after);
    let which = basis(found);
    let brought = |what: &str| match all.is_empty() {
        true => format!("a gap of {} times the noise is left {which}", short3(after)),
        false => format!(
            "{} {} {what} from {} to {} times the noise {which}",
            joined(&all),
            if all.len() == 1 { "brings" } else { "bring" },
            short3(before),
            short3(after)
        ),
    };
    // What was not compared explains nothing, and nothing speaks against it.
    if found.interrupted() && found.status != Status::NothingMissing {
        let compared = if all.is_empty() { "" } else { ", not yet compared with all other laws" };
        let so_far = brought("the gap");
        let sentence = format!("The search was stopped before its end. So far {so_far}{compared}.");
        return Finding { headline: "Stopped before the end", sentence };
    }
    match found.status {
        Status::NothingMissing => {
            Finding { headline: "Nothing missing", sentence: capital(&outcome(found)) + "." }
        }
        Status::Undetermined if all.is_empty() => {
            Finding { headline: "Undetermined", sentence: capital(&outcome(found)) + "." }
        }
        Status::Named if let Some(Alternative::Pushes(pushes)) = &found.alternative => {
            let each: Vec<String> = pushes.iter().map(ToString::to_string).collect();
            let with = match all.is_empty() {
                true => "The model is right".to_owned(),
                false => format!("With {} the model is right", joined(&all)),
            };
            let sentence = format!("{with}, but for a force that nobody measured: {}.", joined(&each));
            Finding { headline: "Named, a force is left", sentence }
        }
        Status::Explained | Status::Described | Status::Named | Status::Undetermined => {
            let sentence = format!(
                "{} {} {fall} of the gap {which} ({} → {} times the noise); {}.",
                capital(&joined(&all)),
                if all.len() == 1 { "explains" } else { "explain" },
                short3(before),
                short3(after),
                rest(found, after)
            );
            let least = found.steps.iter().filter_map(|s| s.probability).fold(1.0, f64::min);
            match found.status {
                Status::Described => Finding { headline: "Described by a formula", sentence },
                Status::Named => Finding { headline: "Named, a force is left", sentence },
                Status::Undetermined => Finding {
                    headline: "Undetermined",
                    sentence: format!(
                        "{sentence} Other laws leave as little: the probability of this choice is {}.",
                        short3(least)
                    ),
                },
                _ => Finding { headline: "Explained", sentence },
            }
        }
        Status::Unexplained => {
            let place =
                found.left.first().map_or(String::new(), |r| format!(", mostly in {}, {r}", r.column));
            let opening = match &found.alternative {
                Some(other) => format!(
                    "No law of the catalogue explains the gap, but {} would (see the warnings)",
                    alternative(other)
                ),
                None => "Something is missing that no law of the catalogue explains".to_owned(),
            };
            Finding { headline: "Unexplained", sentence: format!("{opening}: {}{place}.", brought("it")) }
        }
    }
}

/// What would explain the gap in the place of a law.
fn alternative(other: &Alternative) -> String {
    match other {
        Alternative::Constant(other) => format!("{} in the place of {}", other.constant, other.stated),
        Alternative::Drive(_) => "a drive at another frequency".to_owned(),
        Alternative::InputNoise(noise) => format!("the noise of the measured {}", noise.inputs.join(" and ")),
        Alternative::Pushes(_) => "pushes that nobody measured".to_owned(),
    }
}

/// What is left where the gap is explained.
fn rest(found: &Gap, after: f64) -> &'static str {
    if found.status == Status::Named {
        "a force in another form is left beside it"
    } else if after <= NOISE {
        "the rest is noise"
    } else if !sensitivity(found).is_empty() {
        "the rest is within the error bars of the numbers"
    } else if has_coarse_input(found) {
        "the few samples of the input allow no more"
    } else if matches!(found.alternative, Some(Alternative::InputNoise(_))) {
        "the rest is the noise of the input"
    } else if found.repeat.is_empty() {
        "the rest is noise of another colour or size than the columns tell"
    } else {
        "the rest is about what the motion itself repeats to"
    }
}

/// `Coulomb friction at v (mu = 0.298 ± 0.008)`.
pub(crate) fn effect(step: &Step) -> String {
    let numbers: Vec<String> = step.parameters.iter().take(NUMBERS).map(number).collect();
    let more = if step.parameters.len() > NUMBERS { ", …" } else { "" };
    let numbers = if numbers.is_empty() { String::new() } else { format!(" ({}{more})", numbers.join(", ")) };
    let at = &step.effect.place.at;
    match late(step) {
        Some(words) => words,
        // A formula that was found is its own name.
        None if step.effect.entry.id == DISCOVERED => {
            format!("the force {} at {at}{numbers}", unicode::expression(&step.expression, &[]))
        }
        None if step.effect.entry.id == CHANGED => format!("another value of {at}{numbers}"),
        None => format!("{} at {at}{numbers}", step.effect.entry.law.name),
    }
}

/// The name of a parameter beside the expression of its step: of its constant in the completed spec, but of
/// the law's own number where that is the negative of it.
pub(crate) fn symbol<'a>(step: &Step, p: &'a StepParameter) -> &'a str {
    if step.effect.entry.law.input.as_deref() == Some("delay") { &p.name } else { &p.constant }
}

/// A delay in words, since the sign of its number means little to a reader:
/// `a record of u that is 9 ± 2 ms late`.
fn late(step: &Step) -> Option<String> {
    let law = &step.effect.entry.law;
    let input = law.input.as_deref() == Some("delay");
    if !input && law.sensor.as_deref() != Some("delay") {
        return None;
    }
    let [delay] = &step.parameters[..] else { return None };
    if !delay.each.is_empty() || delay.unit != "s" {
        return None;
    }
    let (low, high) = delay.ci95;
    let size = with_error(1e3 * delay.value.abs(), 0.5e3 * (high - low));
    let at = &step.effect.place.at;
    Some(match (input, delay.value < 0.0) {
        // What acts is u(t - tau): the rig answers late, or the record of its input is late.
        (true, false) => format!("an input {at} that acts {size} ms late"),
        (true, true) => format!("an input {at} that is recorded {size} ms late"),
        (false, false) => format!("a sensor of {at} that is {size} ms late"),
        (false, true) => format!("a sensor of {at} that is {size} ms early"),
    })
}

/// `mu = 0.298 ± 0.008`, with half the 95 % interval; the range of the values that records have of their own.
fn number(p: &StepParameter) -> String {
    let unit = raised(&p.unit);
    let unit = if unit.is_empty() { unit } else { format!(" {unit}") };
    let values = || p.each.iter().map(|r| r.value);
    let (low, high) = values().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    if p.each.is_empty() {
        format!("{} = {}{unit}", p.name, with_error(p.value, 0.5 * (p.ci95.1 - p.ci95.0)))
    } else {
        format!("{} = {} to {}{unit}", p.name, short3(low), short3(high))
    }
}

/// How much of the gap is gone.
fn fall(before: f64, after: f64) -> String {
    let part = 100.0 * (1.0 - after / before);
    if part.is_finite() {
        format!("{:.*} %", usize::from(part > 99.0 && part < 99.95), part.max(0.0))
    } else {
        "most".to_owned()
    }
}

/// A gap with three digits.
fn short3(x: f64) -> String {
    let rounded = format!("{x:.2e}").parse::<f64>().unwrap_or(x);
    short(rounded)
}

/// `a, b and c`.
fn joined(all: &[String]) -> String {
    match all {
        [] => "nothing".to_owned(),
        [one] => one.clone(),
        [front @ .., last] => format!("{} and {last}", front.join(", ")),
    }
}
