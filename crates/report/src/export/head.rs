//! The comment at the head of an exported file: title, states, inputs, equations, usage.

use super::identifier::Identifiers;
use super::subject::{Quantity, Subject};
use phisindy_phys::Sensor;
use phisindy_signal::Interpolation;

/// The contact rule in words.
pub(crate) const RULE: [&str; 6] = [
    "Contacts: each sgn(w) in the rates is a mode s in {-1, 0, +1}, and |w| is s*w. Where w = 0, let r+ and r- be dw/dt with s = +1 and",
    "s = -1 (of friction that is singular near zero speed: the largest one-sided friction up to 1e-6 of the scale of speed). The contact",
    "sticks while r+ <= 0 <= r-, leaves in the direction of the one that fails, and goes on as it came where friction would be negative",
    "(r+ > 0 > r-). What sticks is held by the fraction of its friction that keeps dw/dt = 0; contacts that stick together are one linear",
    "system: all stick at first, while one is overloaded the most overloaded one slips the way it is pushed, and one that was relieved by",
    "that sticks again.",
];

/// The lines of the comment, without comment marks.
pub(crate) fn head(subject: &Subject, identifiers: &Identifiers, usage: &[&str]) -> Vec<String> {
    let record = subject.chosen();
    let mut lines = Vec::new();
    if !subject.title.is_empty() {
        lines.extend([plain(&subject.title), String::new()]);
    }
    lines.push(format!("Exported by phisindy {} from {}.", env!("CARGO_PKG_VERSION"), plain(&subject.spec)));
    lines.push("All numbers are in SI units.".to_owned());
    lines.push(String::new());
    lines.push(format!("States: {}", quantities(&subject.states)));
    if !subject.inputs.is_empty() {
        let kinds = subject.interpolation.iter().map(|i| kind(*i));
        let inputs = subject.inputs.iter().zip(kinds).map(|(q, kind)| format!("{}, {kind}", quantity(q)));
        lines.push(format!("Inputs: {}", inputs.collect::<Vec<_>>().join("; ")));
    }
    lines.push(String::new());
    for (k, state) in subject.states.iter().enumerate() {
        lines.push(plain(&format!("d({})/dt = {}", state.name, subject.model.text(subject.model.rates[k]))));
    }
    lines.push(String::new());
    lines.extend(usage.iter().map(|&line| line.to_owned()));
    lines.push(String::new());
    lines.extend(RULE.map(str::to_owned));
    let changed = identifiers.changed();
    if !changed.is_empty() {
        let names: Vec<String> = changed.iter().map(|(from, to)| format!("{from} is {to}")).collect();
        lines
            .extend([String::new(), format!("Names that this language does not take: {}", names.join(", "))]);
    }
    let several = subject.records.len() > 1;
    lines.push(String::new());
    let which = if several { " (another one: phisindy export --record NAME)" } else { "" };
    lines.push(plain(&format!(
        "The start state and the constants of records are those of `{}`{which}.",
        record.name
    )));
    for (column, sensor) in &record.sensors {
        lines.push(plain(&format!("The column of {column} reads {}", reading(column, sensor))));
    }
    lines
}

/// The text on one line.
fn plain(text: &str) -> String {
    text.replace(['\n', '\r'], " ")
}

fn quantity(q: &Quantity) -> String {
    if q.unit.is_empty() { q.name.clone() } else { format!("{} [{}]", q.name, q.unit) }
}

fn quantities(list: &[Quantity]) -> String {
    list.iter().map(quantity).collect::<Vec<_>>().join(", ")
}

/// The reading of a sensor as a formula.
fn reading(column: &str, sensor: &Sensor) -> String {
    let [offset, gain, delay, clock, lag] = sensor.parameters().map(|p| p.start);
    let column = if sensor.average > 0.0 {
        format!("mean over {:?} s of {column}", sensor.average)
    } else {
        column.to_owned()
    };
    let column = if lag > 0.0 { format!("lag of {lag:?} s after {column}") } else { column };
    if clock != 0.0 {
        let since = sensor.since;
        return format!("{offset:?} + {gain:?}*{column}(t - {delay:?} s + {clock:?}*(t - {since:?} s))");
    }
    format!("{offset:?} + {gain:?}*{column}(t - {delay:?} s)")
}

/// The name of an interpolation.
pub(crate) fn kind(interpolation: Interpolation) -> &'static str {
    match interpolation {
        Interpolation::Hold => "hold",
        Interpolation::Linear => "linear",
        Interpolation::Cubic => "cubic",
    }
}
