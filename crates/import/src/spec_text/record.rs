//! A record of the file.

use super::literals::{literal, round};
use super::notation::Notation;
use crate::draft::Draft;
use crate::records::RecordDraft;
use crate::roles::Input;
use crate::time_column::RATE;
use std::fmt::Write;

/// As `Csv(...)`.
pub(super) fn record(
    draft: &Draft,
    notation: &Notation,
    record: &RecordDraft,
    file: &str,
    text: &mut String,
) {
    let (path, name) = (literal(file), literal(&record.name));
    let (time, remark) = time(draft);
    let columns = columns(draft, notation).join(", ");
    let _ = writeln!(
        text,
        "        Csv(path: {path}, name: {name}, time: {time}, columns: {{ {columns} }},{remark}"
    );
    let mut fields = Vec::new();
    if let Input::Base(_) = draft.roles.input {
        fields.push("derive: { \"du\": Derivative(\"u\") }".to_owned());
    }
    if !draft.table.reading.is_empty() {
        fields.push(draft.table.reading.join(", "));
    }
    if let (Some(_), Some(_)) = (draft.roles.place, draft.estimate.spring) {
        let (start, low, high) = zero(draft);
        let (place, unit) = (notation.place, &notation.place_unit);
        fields.push(format!(
            "sensors: {{ \"{place}\": (offset: Find(start: {start:?}, unit: \"{unit}\", within: ({low:?}, {high:?}))) }}"
        ));
    }
    if !record.rows.is_empty() {
        let rows: Vec<String> =
            record.rows.iter().map(|(name, value)| format!("{}: {value:?}", literal(name))).collect();
        fields.push(format!("rows: {{ {} }}", rows.join(", ")));
    }
    fields.extend(record.run.map(|run| format!("run: {run}")));
    if draft.decimate > 1 {
        fields.push(format!("decimate: {}", draft.decimate));
    }
    let window = record.window.map_or(String::new(), |(a, b)| format!("window: ({a:?}, {b:?}), "));
    fields.push(format!("{window}role: {}", if record.fit { "Fit" } else { "Validate" }));
    let _ = writeln!(text, "            {}),", fields.join(",\n            "));
}

/// A heading with its unit.
fn column(draft: &Draft, c: usize) -> String {
    let heading = &draft.table.columns[c].heading;
    match &heading.unit {
        Some(unit) => format!("({}, \"{unit}\")", literal(&heading.raw)),
        None => literal(&heading.raw),
    }
}

/// The column of time, and what to look at there.
fn time(draft: &Draft) -> (String, &'static str) {
    let time = &draft.time;
    if time.counted {
        return (format!("Rate({RATE:?})"), " // EDIT: no column is time: how many rows per second?");
    }
    let has_unit = draft.table.columns[time.column].heading.unit.is_some();
    let remark = match (time.guessed, has_unit) {
        (true, _) => " // EDIT: no heading says which column is time, and in which unit (taken: s)",
        (false, false) => {
            " // EDIT: the heading gives no unit of time (taken: s; else `time: (\"t\", \"ms\")`)"
        }
        (false, true) if time.unit_guessed => " // EDIT: the unit of time is a guess",
        (false, true) => "",
    };
    (column(draft, time.column), remark)
}

/// The states and inputs that have a column.
fn columns(draft: &Draft, notation: &Notation) -> Vec<String> {
    let roles = &draft.roles;
    let named = |name: &str, c: usize| format!("\"{name}\": {}", column(draft, c));
    let place = roles.place.map(|c| named(notation.place, c));
    let speed = roles.speed.map(|c| named(notation.speed, c));
    let input = match roles.input {
        Input::None => None,
        Input::Base(c) => Some(named("u", c)),
        Input::Force(c) | Input::Drive(c) => Some(named("F", c)),
    };
    [place, speed, input].into_iter().flatten().collect()
}

/// Where the sensor's zero may be: start and bounds, in the state's unit as far as that is SI.
fn zero(draft: &Draft) -> (f64, f64, f64) {
    let (low, high) = draft.extent;
    let half = if draft.motion.swing { 0.5 } else { 0.5 * (high - low) };
    let mut rest = draft.estimate.rest;
    if let Some(base) = &draft.motion.base {
        rest -= base.iter().sum::<f64>() / base.len().max(1) as f64;
    }
    (round(rest), round(rest - half), round(rest + half))
}
