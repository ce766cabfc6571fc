//! Stick and slip over time.

use crate::chart::{Axis, Mark, Strip, digits};
use crate::seen::Seen;

/// A strip for each contact of the model that can stick.
pub(crate) fn strips<'s>(seen: &'s Seen<'_>, chain: &[usize], time: &'s Axis) -> Vec<Strip<'s>> {
    let strip = |(switch, name)| Strip { name, x: time, marks: marks(seen, chain, switch) };
    contacts(seen).into_iter().map(strip).collect()
}

/// Number and total duration of each contact's sticking phases, in words.
pub(crate) fn described(seen: &Seen<'_>, chain: &[usize]) -> String {
    let one = |(switch, name): (usize, &str)| {
        let all = stretches(seen, chain, switch);
        let length = |s: &&(f64, f64, i8)| s.1 - s.0;
        let still: f64 = all.iter().filter(|s| s.2 == 0).map(|s| length(&s)).sum();
        let whole: f64 = all.iter().map(|s| length(&s)).sum();
        let part = digits(100.0 * still / whole.max(f64::MIN_POSITIVE), 2);
        match all.iter().filter(|s| s.2 == 0).count() {
            0 => format!(" The contact {name} never sticks."),
            1 => format!(" The contact {name} sticks once, {part} % of the time."),
            count => format!(" The contact {name} sticks {count} times, {part} % of the time."),
        }
    };
    contacts(seen).into_iter().map(one).collect()
}

/// Switches that can stick and their names.
fn contacts<'s>(seen: &'s Seen<'_>) -> Vec<(usize, &'s str)> {
    let all = seen.model.iter().flat_map(|m| m.contacts.iter().enumerate());
    all.filter_map(|(k, name)| Some((k, name.as_deref()?))).collect()
}

/// Sticking fills the whole height, slip forward the upper part, slip backward the lower part; colours are
/// not needed.
fn marks(seen: &Seen<'_>, chain: &[usize], switch: usize) -> Vec<Mark> {
    let all = stretches(seen, chain, switch);
    let boxes = |mode: i8, low: f64, high: f64| {
        let of = all.iter().filter(|s| s.2 == mode);
        of.map(|&(from, to, _)| (from, to, low, high)).collect::<Vec<_>>()
    };
    let slips = [boxes(1, 0.62, 1.0), boxes(-1, 0.0, 0.38)].concat();
    vec![
        Mark::Boxes { class: "slip", boxes: slips },
        Mark::Boxes { class: "stick", boxes: boxes(0, 0.0, 1.0) },
    ]
}

/// Intervals of constant mode: start, end, mode.
fn stretches(seen: &Seen<'_>, chain: &[usize], switch: usize) -> Vec<(f64, f64, i8)> {
    let Some(model) = &seen.model else { return vec![] };
    let mut out: Vec<(f64, f64, i8)> = Vec::new();
    for &r in chain {
        let Some(run) = &model.fits[r].run else { continue };
        let (time, switches) = (&seen.records[r].time, model.contacts.len());
        let modes: Vec<i8> = run.modes.iter().skip(switch).step_by(switches.max(1)).copied().collect();
        let samples = modes.len().min(time.len());
        let mut first = 0;
        for i in 1..=samples {
            if i == samples || modes[i] != modes[first] {
                out.push((time[first], time[i.min(samples - 1)], modes[first]));
                first = i;
            }
        }
    }
    out
}
