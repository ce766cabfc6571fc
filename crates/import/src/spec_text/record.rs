//! A record of the file.

use super::literals::{quoted, three_digits};
use super::notation::Notation;
use crate::draft::Draft;
use crate::records::RecordDraft;
use crate::roles::Input;
use crate::table::Table;
use crate::time_column::TimeColumn;
use phisindy_phys::unit::Unit;
use std::fmt::Write;

/// As `Csv(...)`, or `Table(...)` of another format.
pub(super) fn record(
    draft: &Draft,
    notation: &Notation,
    record: &RecordDraft,
    (file, name): (&str, &str),
    load: Option<f64>,
    text: &mut String,
) {
    let (path, name) = (quoted(file), quoted(name));
    let (time, remark) = time(&draft.time, &draft.table);
    let form = if draft.table.is_text { "Csv" } else { "Table" };
    let columns = columns(draft, notation).join(", ");
    let form_of_columns = if draft.merged.is_some() { "streams" } else { "columns" };
    let _ = writeln!(
        text,
        "        {form}(path: {path}, name: {name}, time: {time}, {form_of_columns}: {{ {columns} }},{remark}"
    );
    let mut fields = Vec::new();
    fields.extend(load.map(|load| format!("constants: {{ \"load\": ({load:?}, \"kg\") }}")));
    let quarter_car = super::quarter_car::is_one(draft);
    if let (Input::Base(_), false) = (draft.roles.input, quarter_car) {
        fields.push("derive: { \"du\": Derivative(\"u\") }".to_owned());
    }
    let tester = super::tester::of(draft);
    fields.extend(tester.iter().flat_map(|tester| tester.fields(draft)));
    if tester.is_none() && draft.is_held() {
        fields.push("interpolate: { \"F\": Hold }".to_owned());
    }
    if !draft.table.record_fields.is_empty() {
        fields.push(draft.table.record_fields.join(", "));
    }
    let offset = |name: &str, (start, low, high): (f64, f64, f64)| {
        let unit = &notation.displacement_unit;
        format!("\"{name}\": (offset: Find(start: {start:?}, unit: \"{unit}\", within: ({low:?}, {high:?})))")
    };
    let springs = draft.estimate.stiffness.is_some() || quarter_car;
    if let (Some(_), true, None) = (draft.roles.displacement, springs, tester) {
        let own = if quarter_car { "x1" } else { notation.displacement };
        let of_wheel = draft.roles.wheel.filter(|_| quarter_car).map(|c| offset("x2", middle(draft, c)));
        let offsets: Vec<String> = [offset(own, zero(draft))].into_iter().chain(of_wheel).collect();
        fields.push(format!("sensors: {{ {} }}", offsets.join(", ")));
    }
    if let Some(c) = draft.roles.acceleration {
        // The sensor may count from anywhere: gravity is in it, or a zero error.
        let numbers = &draft.statistics[c];
        let factor = draft.factor(c);
        let [low, high] = [numbers.min, numbers.max].map(|x| three_digits(x * factor));
        let start = three_digits(0.5 * (low + high));
        fields.push(format!(
            "sensors: {{ \"a\": (offset: Find(start: {start:?}, unit: \"{}\", within: ({low:?}, {high:?}))) }}",
            notation.acceleration_unit()
        ));
    }
    if !record.rows.is_empty() {
        let rows: Vec<String> =
            record.rows.iter().map(|(name, value)| format!("{}: {value:?}", quoted(name))).collect();
        fields.push(format!("rows: {{ {} }}", rows.join(", ")));
    }
    fields.extend(record.run.map(|run| format!("run: {run}")));
    if record.omits_missing {
        fields.push("missing: Omit".to_owned());
    }
    if draft.decimate > 1 {
        fields.push(format!("decimate: {}", draft.decimate));
    }
    // By the same arithmetic as the reader's, so that the first and the last row are in it.
    let column = (!draft.time.counted).then(|| &draft.table.columns[draft.time.column]);
    let unit = column.and_then(|column| Unit::parse(column.heading.unit.as_deref()?).ok());
    let scale = unit.unwrap_or(Unit::ONE).scale();
    let seconds = |t: f64| scale.si(&t.to_string()).unwrap_or(t);
    let window = record
        .window
        .map_or(String::new(), |(a, b)| format!("window: ({:?}, {:?}), ", seconds(a), seconds(b)));
    fields.push(format!("{window}role: {}", if record.fit { "Fit" } else { "Validate" }));
    let _ = writeln!(text, "            {}),", fields.join(",\n            "));
}

/// A heading with its unit.
pub(crate) fn column(table: &Table, c: usize) -> String {
    let heading = &table.columns[c].heading;
    match &heading.unit {
        Some(unit) => format!("({}, \"{unit}\")", quoted(&heading.raw)),
        None => quoted(&heading.raw),
    }
}

/// The time column, and a comment on what to check there.
pub(crate) fn time(time: &TimeColumn, table: &Table) -> (String, String) {
    if time.counted {
        let remark = match (&time.coarse, &time.stated) {
            _ if time.told => "",
            (Some(_), _) => {
                " // EDIT: counted from the stamps, which are coarser than the rows: is this the exact rate?"
            }
            (None, _) => " // as the header of the file says",
        };
        return (format!("Rate({:?})", time.rate), remark.to_owned());
    }
    let unit = table.columns[time.column].heading.unit.as_deref();
    let remark = match (time.guessed, unit) {
        (true, unit) => {
            let unit = unit.unwrap_or("s");
            format!(" // EDIT: no heading says which column is time, and in which unit (taken: {unit})")
        }
        (false, None) => {
            " // EDIT: the heading gives no unit of time (taken: s; else `time: (\"t\", \"ms\")`)".to_owned()
        }
        (false, Some(_)) if time.unit_guessed => " // EDIT: the unit of time is a guess".to_owned(),
        (false, Some(_)) => String::new(),
    };
    (column(table, time.column), remark)
}

/// The states and inputs that have a column.
fn columns(draft: &Draft, notation: &Notation) -> Vec<String> {
    let roles = &draft.roles;
    let named = |name: &str, c: usize| match draft.merged {
        Some(_) => format!("\"{name}\": (column: {})", column(&draft.table, c)),
        None => format!("\"{name}\": {}", column(&draft.table, c)),
    };
    let quarter_car = super::quarter_car::is_one(draft);
    let own = if quarter_car { "x1" } else { notation.displacement };
    let displacement = roles.displacement.map(|c| named(own, c));
    let wheel = roles.wheel.filter(|_| quarter_car).map(|c| named("x2", c));
    let velocity = roles.velocity.map(|c| named(notation.velocity, c));
    let acceleration = roles.acceleration.map(|c| named("a", c));
    let input = match roles.input {
        Input::None => None,
        Input::Base(c) => Some(named("u", c)),
        Input::BaseAcceleration(c) => Some(named("ab", c)),
        Input::Force(c) | Input::Drive(c) | Input::Reaction(c) => Some(named("F", c)),
    };
    [displacement, wheel, velocity, acceleration, input].into_iter().flatten().collect()
}

/// Start value and bounds of the offset of a column whose rest nothing tells, in SI.
fn middle(draft: &Draft, c: usize) -> (f64, f64, f64) {
    let (numbers, factor) = (&draft.statistics[c], draft.factor(c));
    let (low, high) = (numbers.min * factor, numbers.max * factor);
    (three_digits(0.5 * (low + high)), three_digits(low), three_digits(high))
}

/// Start value and bounds of the sensor offset, in SI.
fn zero(draft: &Draft) -> (f64, f64, f64) {
    let (low, high) = draft.extent;
    // A pendulum that is driven need not come near its rest, which may be at any angle.
    let half = match (draft.motion.is_pendulum, draft.roles.input) {
        (true, Input::None) => 0.5,
        (true, _) => std::f64::consts::PI,
        (false, _) => 0.5 * (high - low),
    };
    let mut rest = draft.estimate.rest;
    if let Some(base) = &draft.motion.base {
        rest -= base.iter().sum::<f64>() / base.len().max(1) as f64;
    }
    (three_digits(rest), three_digits(rest - half), three_digits(rest + half))
}
