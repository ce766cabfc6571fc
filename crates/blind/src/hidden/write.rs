//! The files of a set: the incomplete model and its data, without anything hidden.

use super::made::{Made, Shown};
use super::motion::ACCELERATION;
use super::rig::{Drive, Extra, Line, Rig};
use crate::dice::Dice;
use crate::folder::Folder;
use anyhow::Result;
use std::fmt::Write;

/// The headings of columns and the unit of displacements.
struct Style {
    time: &'static str,
    suffix: bool,
    millimetres: bool,
}

/// Writes `spec.ron`, the data files and `truth.json`.
///
/// # Errors
/// A file cannot be written.
pub(super) fn write(folder: &Folder, index: usize, made: &Made, dice: &mut Dice) -> Result<()> {
    let style = Style {
        time: dice.pick::<&str>(&["t", "time", "time_s"]),
        suffix: dice.chance(0.5),
        millimetres: made.rig.scale == "laboratory" && dice.chance(0.3),
    };
    let files: &[&str] =
        if made.records.len() == 1 { &["data.csv"] } else { &["data_fit.csv", "data_validate.csv"] };
    // Files of an earlier set with this number would count as its own.
    for old in ["data.csv", "data_fit.csv", "data_validate.csv", "result.json", "gap.log"] {
        let _ = std::fs::remove_file(folder.path().join(old));
    }
    for (name, record) in files.iter().zip(&made.records) {
        folder.write(name, &csv(made, record, &style))?;
    }
    folder.write("spec.ron", &spec(index, made, files, &style))?;
    folder.write("truth.json", &(serde_json::to_string_pretty(&made.truth)? + "\n"))
}

/// The shortest text that reads back as the same number, with a point in it.
fn number(x: f64) -> String {
    let size = x.abs();
    if size != 0.0 && !(1e-4..1e9).contains(&size) { format!("{x:e}") } else { format!("{x:?}") }
}

/// Heading, unit and factor of a column.
fn heading(name: &str, unit: &str, style: &Style) -> (String, String, f64) {
    let (unit, factor) = match unit {
        "m" if style.millimetres => ("mm", 1e3),
        other => (other, 1.0),
    };
    let suffix = unit.replace('/', "_per_");
    (
        if style.suffix && !unit.is_empty() { format!("{name}_{suffix}") } else { name.to_owned() },
        unit.to_owned(),
        factor,
    )
}

/// Columns of a file: name in the spec, heading, unit, factor.
fn columns(made: &Made, style: &Style) -> Vec<(String, String, String, f64)> {
    let rig = &made.rig;
    let mut all: Vec<(String, &str)> = Vec::new();
    for (state, name) in &made.measured {
        let unit = match *state {
            k if k >= ACCELERATION => "m/s^2",
            k if k < rig.count() => "m",
            _ => "m/s",
        };
        all.push((name.clone(), unit));
    }
    all.extend(
        inputs(rig)
            .into_iter()
            .filter(|(name, _)| !derives(rig) || *name != "du")
            .map(|(n, u)| (n.to_owned(), u)),
    );
    all.into_iter()
        .map(|(name, unit)| {
            let (head, unit, factor) = heading(&name, unit, style);
            (name, head, unit, factor)
        })
        .collect()
}

fn inputs(rig: &Rig) -> Vec<(&'static str, &'static str)> {
    match rig.drive {
        Drive::Force(_) => vec![("F", "N")],
        Drive::Base { .. } => vec![("u", "m"), ("du", "m/s")],
        Drive::Explicit(_) | Drive::Free => vec![],
    }
}

fn derives(rig: &Rig) -> bool {
    matches!(rig.drive, Drive::Base { derived: true })
}

fn csv(made: &Made, record: &Shown, style: &Style) -> String {
    let columns = columns(made, style);
    let mut text = style.time.to_owned();
    columns.iter().for_each(|(_, head, ..)| text += &format!(",{head}"));
    text.push('\n');
    for (i, t) in record.times.iter().enumerate() {
        text += &number(*t);
        for (k, (name, _, _, factor)) in columns.iter().enumerate() {
            let value = match (record.columns.get(k), name.as_str()) {
                (Some(column), _) => column[i],
                (None, "du") => record.drive[i].1,
                (None, _) => record.drive[i].0,
            };
            text += &format!(",{}", number(value * factor));
        }
        text.push('\n');
    }
    text
}

/// The explicit force with the names of its constants.
fn force(lines: &[Line]) -> String {
    if lines.len() == 1 {
        return "F0*cos(W*t)".to_owned();
    }
    let one = |k: usize| format!("A{k}*cos(W{k}*t+p{k})");
    format!("({})", (1..=lines.len()).map(one).collect::<Vec<_>>().join(" + "))
}

fn spec(index: usize, made: &Made, files: &[&str], style: &Style) -> String {
    let rig = &made.rig;
    let mut text =
        String::from("// A known part, and data of a rig that may have something more in it.\n(\n");
    let _ = writeln!(text, "    title: \"Rig {index:03}\",\n    constants: {{");
    let quantity =
        |x: f64, unit: &str| if unit.is_empty() { number(x) } else { format!("({}, \"{unit}\")", number(x)) };
    for c in &rig.constants {
        let value = match c.movable {
            None => quantity(c.value, c.unit),
            Some((nominal, low, high)) => {
                let unit = if c.unit.is_empty() { String::new() } else { format!("unit: \"{}\", ", c.unit) };
                format!("(value: {}, {unit}within: ({}, {}))", number(nominal), number(low), number(high))
            }
        };
        let _ = writeln!(text, "        \"{}\": {value},", c.name);
    }
    let unit = |unit: &'static str| if rig.inertia { unit } else { "" };
    if matches!(rig.drive, Drive::Explicit(_)) {
        let single = rig.lines.len() == 1;
        for (k, line) in rig.lines.iter().enumerate() {
            let (a, w) = if single {
                ("F0".to_owned(), "W".to_owned())
            } else {
                (format!("A{}", k + 1), format!("W{}", k + 1))
            };
            if !made.own_amplitude {
                let _ = writeln!(text, "        \"{a}\": {},", quantity(line.amplitude, unit("N")));
            }
            let _ = writeln!(text, "        \"{w}\": {},", quantity(line.frequency, unit("rad/s")));
            if !single {
                let _ = writeln!(text, "        \"p{}\": {},", k + 1, number(line.phase));
            }
        }
    }
    text += "    },\n";
    let pairs = |list: &[(String, String)]| {
        list.iter().map(|(a, b)| format!("\"{a}\": \"{b}\"")).collect::<Vec<_>>().join(", ")
    };
    let mut states: Vec<(String, String)> = rig.x.iter().map(|x| (x.clone(), "m".to_owned())).collect();
    states.extend(rig.v.iter().map(|v| (v.clone(), "m/s".to_owned())));
    let _ = writeln!(text, "    states: {{ {} }},", pairs(&states));
    let inputs: Vec<(String, String)> =
        inputs(rig).into_iter().map(|(n, u)| (n.to_owned(), u.to_owned())).collect();
    if inputs.is_empty() {
        text += "    inputs: {},\n";
    } else {
        let _ = writeln!(text, "    inputs: {{ {} }},", pairs(&inputs));
    }
    let reads = |(k, name): &(usize, String)| {
        let mass = k.checked_sub(ACCELERATION)?;
        Some(format!("\"{name}\": (unit: \"m/s^2\", reads: \"rate({})\")", rig.v[mass]))
    };
    let outputs: Vec<String> = made.measured.iter().filter_map(reads).collect();
    if !outputs.is_empty() {
        let _ = writeln!(text, "    outputs: {{ {} }},", outputs.join(", "));
    }
    let drive = if matches!(rig.drive, Drive::Force(_)) { "F".to_owned() } else { force(&rig.lines) };
    text += "    known: {\n";
    rig.x.iter().zip(&rig.v).for_each(|(x, v)| text += &format!("        \"{x}\": \"{v}\",\n"));
    rig.v
        .iter()
        .zip(rig.rates(&drive, "u", "du"))
        .for_each(|(v, rate)| text += &format!("        \"{v}\": \"{rate}\",\n"));
    text += "    },\n";
    if rig.inertia {
        let own: Vec<(String, String)> =
            rig.v.iter().enumerate().map(|(k, v)| (v.clone(), rig.named("m", k))).collect();
        let _ = writeln!(text, "    inertia: {{ {} }},", pairs(&own));
    }
    text += "    unknown: {},\n";
    if rig.extra == Some(Extra::Coulomb) {
        let _ = writeln!(text, "    contacts: [\"{}\"],", rig.v[rig.count() - 1]);
    }
    text += "    data: [\n";
    for role in 0..2 {
        text += &record(made, files, style, role);
    }
    text + "    ],\n)\n"
}

fn record(made: &Made, files: &[&str], style: &Style, role: usize) -> String {
    let rig = &made.rig;
    let columns: Vec<String> = columns(made, style)
        .into_iter()
        .map(|(name, head, unit, _)| {
            if unit.is_empty() {
                format!("\"{name}\": \"{head}\"")
            } else {
                format!("\"{name}\": (\"{head}\", \"{unit}\")")
            }
        })
        .collect();
    let (file, name) = (files[role.min(files.len() - 1)], ["first", "second"][role]);
    let mut text = format!(
        "        Csv(path: \"{file}\", name: \"{name}\", time: \"{}\", columns: {{ {} }},\n            ",
        style.time,
        columns.join(", ")
    );
    if derives(rig) {
        text += "derive: { \"du\": Derivative(\"u\") }, ";
    }
    if made.own_amplitude {
        let amplitude = number(made.records[role].lines[0].amplitude);
        let value = if rig.inertia { format!("({amplitude}, \"N\")") } else { amplitude };
        let _ = write!(text, "constants: {{ \"F0\": {value} }}, ");
    }
    if files.len() == 1 {
        let times = &made.records[0].times;
        let neat = |t: f64| number((t * 1e7).round() / 1e7);
        let half = |k: usize| neat(0.5 * (times[k - 1] + times[k]));
        let end = neat(times[times.len() - 1] + 0.5 * times[1]);
        let window = if role == 0 {
            format!("0.0, {}", half(made.split))
        } else {
            format!("{}, {end}", half(made.split))
        };
        let _ = write!(text, "window: ({window}), ");
    }
    text + &format!("role: {}),\n", ["Fit", "Validate"][role])
}
