//! The text of the spec, and a summary of it.

use crate::draft::{Draft, Part};
use crate::headings::Kind;
use crate::roles::Input;
use phisindy_phys::{Diagnostic, SourceId};
use std::fmt::Write;
use std::path::Path;

/// How the model is written down for one kind of motion.
struct Words {
    /// Names of the states.
    place: &'static str,
    speed: &'static str,
    /// Their units.
    place_unit: String,
    speed_unit: String,
    /// The inertia, where a force is measured: name and unit.
    inertia: Option<(&'static str, &'static str)>,
    /// Units of stiffness, damping, of the input and of what it is multiplied with.
    spring_unit: &'static str,
    damper_unit: &'static str,
    input_unit: String,
    gain_unit: String,
}

impl Words {
    fn of(draft: &Draft) -> Words {
        let heading = |c: usize| &draft.survey.columns[c].heading;
        let own = heading(draft.moving());
        let (place, speed) = if draft.roles.angle { ("theta", "w") } else { ("x", "v") };
        let place_unit = match own.kind {
            Kind::Electric | Kind::Other if draft.roles.place.is_some() => {
                own.unit.clone().unwrap_or_default()
            }
            _ if draft.roles.angle => "rad".to_owned(),
            _ => "m".to_owned(),
        };
        let speed_unit = format!("{place_unit}/s");
        let inertia = match (draft.roles.input, draft.roles.angle) {
            (Input::Force(_), false) => Some(("m", "kg")),
            (Input::Force(_), true) => Some(("J", "kg*m^2")),
            _ => None,
        };
        let (spring_unit, damper_unit) = match inertia {
            Some(("m", _)) => ("N/m", "N*s/m"),
            Some(_) => ("N*m", "N*m*s"),
            None => ("1/s^2", "1/s"),
        };
        let (input_unit, gain_unit) = match draft.roles.input {
            Input::None => (String::new(), String::new()),
            Input::Base(_) => (place_unit.clone(), String::new()),
            Input::Force(_) => (if draft.roles.angle { "N*m" } else { "N" }.to_owned(), String::new()),
            Input::Drive(c) => {
                let unit = heading(c).unit.clone().unwrap_or_default();
                let gain = format!("{place_unit}/s^2");
                (
                    unit.clone(),
                    match unit.contains(['*', '/']) {
                        true => format!("{gain}/({unit})"),
                        false if unit.is_empty() => gain,
                        false => format!("{gain}/{unit}"),
                    },
                )
            }
        };
        Words {
            place,
            speed,
            place_unit,
            speed_unit,
            inertia,
            spring_unit,
            damper_unit,
            input_unit,
            gain_unit,
        }
    }
}

/// The whole text; `next` is what `run` takes after this.
pub fn spec(draft: &Draft, file: &str, next: &str) -> String {
    let mut text = String::new();
    for line in head(draft, file, next) {
        // Headings may hold anything.
        let _ = writeln!(text, "{}", format!("// {}", line.replace(['\n', '\r'], " ")).trim_end());
    }
    let words = Words::of(draft);
    let _ = writeln!(text, "(\n    title: {}, // EDIT: what is it?", literal(file));
    constants(draft, &words, &mut text);
    model(draft, &words, &mut text);
    text.push_str("    data: [\n");
    for part in &draft.parts {
        record(draft, &words, part, file, &mut text);
    }
    text.push_str("    ],\n)\n");
    text
}

/// What there is to know about the file.
fn head(draft: &Draft, file: &str, next: &str) -> Vec<String> {
    let survey = &draft.survey;
    let mut lines = vec![
        format!(
            "Written by `phisindy new {file}`. Look at the lines marked EDIT, then type: phisindy run {next}"
        ),
        String::new(),
        sampling(draft, file),
    ];
    let step = draft.clock.step
        * crate::headings::factor(survey.columns[draft.clock.column].heading.unit.as_deref());
    let widths = survey.columns.iter().map(|c| c.heading.raw.chars().count());
    let width = widths.max().unwrap_or(6).clamp(6, 40);
    lines.push(String::new());
    lines.push(format!(
        "{:width$} {:>11} {:>11} {:>11} {:>10} {:>10}  what it is taken for",
        "column", "min", "max", "std", "noise", "frequency"
    ));
    let time = crate::headings::factor(survey.columns[draft.clock.column].heading.unit.as_deref());
    for (k, (column, look)) in survey.columns.iter().zip(&draft.looks).enumerate() {
        let is_time = k == draft.clock.column;
        let noise = if is_time || look.noise == 0.0 { "-".to_owned() } else { short(look.noise) };
        let frequency = look
            .line
            .filter(|l| !is_time && l.share > 0.1)
            .map_or("-".to_owned(), |l| format!("{} Hz", short(l.frequency / time)));
        let (min, max) = if look.min <= look.max {
            (short(look.min), short(look.max))
        } else {
            ("-".to_owned(), "-".to_owned())
        };
        let values = look.values.as_ref().filter(|v| v.len() > 1).map_or(String::new(), |v| {
            format!("; values {}", v.iter().map(|x| format!("{x}")).collect::<Vec<_>>().join(", "))
        });
        let missing = if look.missing > 0 { format!("; {} missing", look.missing) } else { String::new() };
        lines.push(format!(
            "{:width$} {min:>11} {max:>11} {:>11} {noise:>10} {frequency:>10}  {}{values}{missing}",
            column.heading.raw,
            short(look.std),
            draft.roles.words[k]
        ));
    }
    lines.push(String::new());
    let moving = draft.raw(draft.moving());
    let stops = &draft.stops;
    if stops.part > 0.01 {
        let longest = stops.stretches.iter().map(|s| s.len()).max().unwrap_or(0) as f64 * step;
        lines.push(format!(
            "`{moving}` stands still for {:.0} % of the first record, in {} stretches, the longest {} s: friction that sticks, or a pause.",
            100.0 * stops.part,
            stops.stretches.len(),
            short(longest)
        ));
    } else {
        lines.push(format!(
            "`{moving}` does not stand still anywhere for long: it turns, but it does not stick."
        ));
    }
    for (k, look) in draft.looks.iter().enumerate().filter(|(_, l)| l.clipped > 0) {
        let mark = if draft.roles.used().any(|used| used == k) { "EDIT: " } else { "" };
        lines.push(format!(
            "{mark}`{}` stands at exactly its least or greatest value in {} samples, where it arrives in motion: is the sensor at its limit?",
            draft.raw(k),
            look.clipped
        ));
    }
    lines.extend(draft.remarks.iter().cloned());
    if draft.decimate > 1 {
        lines.push(format!(
            "The records are long: `decimate` takes the mean of every {} rows, which is a low-pass filter. Without it the fit takes longer.",
            draft.decimate
        ));
    }
    lines
}

/// Rows, duration, rate.
fn sampling(draft: &Draft, file: &str) -> String {
    let (survey, clock) = (&draft.survey, &draft.clock);
    let unit = crate::headings::factor(survey.columns[clock.column].heading.unit.as_deref());
    let time = draft.time();
    let span = clock.runs(survey.rows()).iter().map(|r| time[r.end - 1] - time[r.start]).sum::<f64>() * unit;
    let rows = survey.rows();
    let count = if survey.part < 1.0 {
        format!(
            "about {:.0} million rows, of which the first {rows} were looked at",
            rows as f64 / survey.part / 1e6
        )
    } else {
        format!("{rows} rows")
    };
    let uniform = match clock.jitter {
        j if j < 1e-3 => "uniform".to_owned(),
        j if j < 0.02 => format!("uniform to {:.1} % of a step", 100.0 * j),
        j => format!("not uniform: steps vary by {:.0} % (no harm)", 100.0 * j),
    };
    let mut text =
        format!("{file}: {count}, {} s at {} Hz, {uniform}", short(span), short(1.0 / (clock.step * unit)));
    let times = |n: usize| if n == 1 { "once".to_owned() } else { format!("{n} times") };
    for (list, what) in
        [(&clock.gaps, "gaps in time"), (&clock.repeats, "repeated times"), (&clock.backs, "jumps back")]
    {
        if let Some(first) = list.first() {
            let _ = write!(
                text,
                "; {what} {} (first in line {})",
                times(list.len()),
                survey.lines[(*first).min(rows - 1)]
            );
        }
    }
    text + "."
}

fn constants(draft: &Draft, words: &Words, text: &mut String) {
    let estimate = &draft.estimate;
    text.push_str("    constants: {\n");
    let mut add = |name: &str, value: f64, unit: &str, within: (f64, f64), comment: &str| {
        let (low, high) = (round(within.0), round(within.1));
        let value = round(value).clamp(low, high);
        let _ = writeln!(
            text,
            "        \"{name}\": (value: {value:?}, unit: \"{unit}\", within: ({low:?}, {high:?})), // {comment}"
        );
    };
    // The inverse mass that the regression saw; one is as good as anything where it saw none.
    let mass = words.inertia.map(|_| estimate.force.filter(|b| *b > 0.0).map_or(1.0, |b| 1.0 / b));
    if let (Some((name, unit)), Some(mass)) = (words.inertia, mass) {
        let known = estimate.force.is_some_and(|b| b > 0.0);
        let comment = if known {
            "EDIT: the inertia, a first guess; if you know it: "
        } else {
            "EDIT: the inertia, not seen in the data; if you know it: "
        };
        add(name, mass, unit, (mass / 5.0, mass * 5.0), &format!("{comment}\"{name}\": (1.23, \"{unit}\")"));
    }
    let per = mass.unwrap_or(1.0);
    let damping = match estimate.spring {
        Some(k) => {
            let (what, short) = match (draft.motion.swing, words.inertia.is_some()) {
                (true, false) => ("gravity over length, for a pendulum that hangs at theta = 0", "k"),
                (true, true) => ("weight times lever, for a pendulum that hangs at theta = 0", "k"),
                (false, false) => ("stiffness / mass", "k"),
                (false, true) => ("stiffness", "k"),
            };
            add(
                short,
                k * per,
                words.spring_unit,
                (k * per / 4.0, k * per * 4.0),
                &format!("EDIT: {what}, from the data; narrow the bounds if you know better"),
            );
            2.0 * k.sqrt()
        }
        None => 10.0 * estimate.damper.abs().max(0.1),
    };
    let start = estimate.damper.clamp(0.005 * damping, 0.5 * damping);
    let what = if words.inertia.is_some() { "viscous damping" } else { "viscous damping / mass" };
    add("c", start * per, words.damper_unit, (0.0, damping * per), &format!("EDIT: {what}"));
    if let Input::Drive(_) = draft.roles.input {
        let gain = estimate.force.filter(|b| *b != 0.0).unwrap_or(1.0);
        let size = 5.0 * gain.abs();
        add(
            "b",
            gain,
            &words.gain_unit,
            (-size, size),
            "EDIT: acceleration for each unit of the input; either sign",
        );
    }
    text.push_str("    },\n");
}

fn model(draft: &Draft, words: &Words, text: &mut String) {
    let Words { place, speed, .. } = words;
    let edit = match &draft.roles.doubt {
        Some(doubt) => format!(" // EDIT: {doubt}"),
        None if !draft.has_unit() => " // EDIT: the heading gives no unit".to_owned(),
        None => String::new(),
    };
    let _ = writeln!(
        text,
        "    states: {{ \"{place}\": \"{}\", \"{speed}\": \"{}\" }},{edit}",
        words.place_unit, words.speed_unit
    );
    let doubt = draft.roles.input_doubt.as_ref().map_or(String::new(), |d| format!(" // EDIT: {d}"));
    match draft.roles.input {
        Input::None => {
            text.push_str("    inputs: {}, // EDIT: nothing that acts on it is measured; is it free?\n")
        }
        Input::Base(_) => {
            let _ = writeln!(
                text,
                "    inputs: {{ \"u\": \"{}\", \"du\": \"{}\" }},{doubt}",
                words.input_unit, words.speed_unit
            );
        }
        Input::Force(_) | Input::Drive(_) => {
            let _ = writeln!(text, "    inputs: {{ \"F\": \"{}\" }},{doubt}", words.input_unit);
        }
    }
    let relative = matches!(draft.roles.input, Input::Base(_));
    let (gap, slip) = if relative {
        (format!("({place} - u)"), format!("({speed} - du)"))
    } else {
        ((*place).to_owned(), (*speed).to_owned())
    };
    let gap = if draft.motion.swing { format!("sin({})", gap.trim_matches(['(', ')'])) } else { gap };
    let mut rate = format!("-c*{slip}");
    if draft.estimate.spring.is_some() {
        let _ = write!(rate, " - k*{gap}");
    }
    let rate = match (draft.roles.input, words.inertia) {
        (Input::Force(_), Some((mass, _))) => format!("(F {})/{mass}", rate.replacen('-', "- ", 1)),
        (Input::Drive(_), _) => format!("{rate} + b*F"),
        _ => rate,
    };
    let _ = writeln!(
        text,
        "    known: {{\n        \"{place}\": \"{speed}\",\n        \"{speed}\": \"{rate}\", // EDIT: the physics that you are sure of"
    );
    if draft.estimate.spring.is_none() {
        text.push_str("        // The data show no spring. If there is one, add `- k*x` and a constant k.\n");
    }
    text.push_str("    },\n");
    let over = words.inertia.map_or(String::new(), |(mass, _)| format!("/{mass}"));
    if let Some((mass, _)) = words.inertia {
        let _ = writeln!(text, "    inertia: {{ \"{speed}\": \"{mass}\" }},");
    } else if let Some((mass, unit, force)) = match words.place_unit.as_str() {
        "m" if draft.has_unit() => Some(("m", "kg", "N")),
        "rad" => Some(("J", "kg*m^2", "N*m")),
        _ => None,
    } {
        // The motion alone says nothing of it.
        let _ = writeln!(
            text,
            "    // inertia: {{ \"{speed}\": \"{mass}\" }}, // EDIT: if you know it, with \"{mass}\": (1.23, \"{unit}\") in constants: then forces are told in {force}"
        );
    }
    let _ = writeln!(
        text,
        "    // What may be missing: dry friction at least. Others: {place}^3, {speed}*|{speed}|; `phisindy gap` tries every \
         law of the catalogue.\n    // If the friction comes out negative, something else is missing."
    );
    let minus = format!("-1{over}");
    let unknown = match draft.estimate.spring {
        // Only a motion of many frequencies tells a hardening spring from a stiff one.
        Some(_) if draft.is_rich() => {
            format!("(factor: \"{minus}\", candidates: [\"sgn({speed})\", \"{place}^3\"])")
        }
        Some(_) => format!("(factor: \"-sgn({speed}){over}\", candidates: [\"1\"])"),
        // Without a spring a constant force is no offset of the sensor.
        None => format!("(factor: \"{minus}\", candidates: [\"sgn({speed})\", \"1\"])"),
    };
    let _ = writeln!(text, "    unknown: {{\n        \"{speed}\": {unknown}, // EDIT: candidates");
    let rubs = if relative {
        format!(
            "EDIT: it rubs on something at rest; on the base: \"{speed}-du\" here, and sgn({speed}-du) above"
        )
    } else {
        "it rubs on something at rest".to_owned()
    };
    let _ = writeln!(text, "    }},\n    contacts: [\"{speed}\"], // {rubs}");
}

fn record(draft: &Draft, words: &Words, part: &Part, file: &str, text: &mut String) {
    let column = |c: usize| {
        let heading = &draft.survey.columns[c].heading;
        match &heading.unit {
            Some(unit) => format!("({}, \"{unit}\")", literal(&heading.raw)),
            None => literal(&heading.raw),
        }
    };
    let (_, place, speed) = ((), words.place, words.speed);
    let mut columns = Vec::new();
    columns.extend(draft.roles.place.map(|c| format!("\"{place}\": {}", column(c))));
    columns.extend(draft.roles.speed.map(|c| format!("\"{speed}\": {}", column(c))));
    let mut fields = Vec::new();
    match draft.roles.input {
        Input::None => {}
        Input::Base(c) => {
            columns.push(format!("\"u\": {}", column(c)));
            fields.push("derive: { \"du\": Derivative(\"u\") }".to_owned());
        }
        Input::Force(c) | Input::Drive(c) => columns.push(format!("\"F\": {}", column(c))),
    }
    let time = if draft.clock.counted {
        format!("Rate({:?})", crate::time_column::RATE)
    } else {
        column(draft.clock.column)
    };
    let _ = write!(
        text,
        "        Csv(path: {}, name: {}, time: {time}, columns: {{ {} }},",
        literal(file),
        literal(&part.name),
        columns.join(", ")
    );
    text.push_str(
        match (
            draft.clock.counted,
            draft.clock.guessed,
            draft.survey.columns[draft.clock.column].heading.unit.is_some(),
        ) {
            (true, ..) => " // EDIT: no column is time: how many rows per second?\n",
            (false, true, _) => {
                " // EDIT: no heading says which column is time, and in which unit (taken: s)\n"
            }
            (false, false, false) => {
                " // EDIT: the heading gives no unit of time (taken: s; else `time: (\"t\", \"ms\")`)\n"
            }
            (false, false, true) if draft.clock.fine => " // EDIT: the unit of time is a guess\n",
            (false, false, true) => "\n",
        },
    );
    let mut written = Vec::new();
    let separator = match draft.survey.separator {
        Some(',') => None,
        Some('\t') => Some("'\\t'".to_owned()),
        Some(c) => Some(format!("'{c}'")),
        None => Some("' '".to_owned()),
    };
    written.extend(separator.map(|s| format!("separator: {s}")));
    written.extend(draft.survey.comma.then(|| "decimal: ','".to_owned()));
    written.extend((!draft.survey.has_header).then(|| "header: false".to_owned()));
    written.extend((draft.survey.skip > 0).then(|| format!("skip: {}", draft.survey.skip)));
    if !written.is_empty() {
        fields.push(written.join(", "));
    }
    if let (Some(_), Some(_)) = (draft.roles.place, draft.estimate.spring) {
        let (start, low, high) = zero(draft);
        let unit = &words.place_unit;
        fields.push(format!(
            "sensors: {{ \"{place}\": (offset: Find(start: {start:?}, unit: \"{unit}\", within: ({low:?}, {high:?}))) }}"
        ));
    }
    if !part.rows.is_empty() {
        let rows: Vec<String> =
            part.rows.iter().map(|(name, value)| format!("{}: {value:?}", literal(name))).collect();
        fields.push(format!("rows: {{ {} }}", rows.join(", ")));
    }
    fields.extend(part.run.map(|run| format!("run: {run}")));
    if draft.decimate > 1 {
        fields.push(format!("decimate: {}", draft.decimate));
    }
    let mut last = String::new();
    if let Some((a, b)) = part.window {
        let _ = write!(last, "window: ({a:?}, {b:?}), ");
    }
    let _ = write!(last, "role: {}", if part.fit { "Fit" } else { "Validate" });
    fields.push(last);
    let _ = writeln!(text, "            {}),", fields.join(",\n            "));
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

/// A text as RON reads it, without escapes: names must stand in the spec as they are.
fn literal(text: &str) -> String {
    if text.contains(['"', '\\']) { format!("r#\"{text}\"#") } else { format!("\"{text}\"") }
}

/// Four digits for people.
fn short(x: f64) -> String {
    let size = x.abs();
    match () {
        () if x == 0.0 => "0".to_owned(),
        () if !(1e-3..1e6).contains(&size) => format!("{x:.3e}"),
        () => {
            let digits = (3 - size.log10().floor() as i32).clamp(0, 6) as usize;
            let text = format!("{x:.digits$}");
            if text.contains('.') {
                text.trim_end_matches('0').trim_end_matches('.').to_owned()
            } else {
                text
            }
        }
    }
}

/// Three digits: more would promise too much.
fn round(x: f64) -> f64 {
    format!("{x:.2e}").parse().unwrap_or(x)
}

/// Whether the program takes its own spec.
pub fn accepted(text: &str) -> Result<(), String> {
    let first = |all: Vec<Diagnostic>| {
        all.into_iter().find(Diagnostic::is_error).map_or(String::new(), |d| d.message)
    };
    let (spec, _) = phisindy_phys::spec::read(text, SourceId(0)).map_err(first)?;
    phisindy_phys::check(&spec, SourceId(0)).map(|_| ()).map_err(first)
}

/// A few lines for the terminal.
pub fn summary(draft: &Draft, file: &str, out: Option<&Path>, next: &str) -> Vec<String> {
    let mut lines = vec![sampling(draft, file)];
    let named = |c: usize| format!("`{}`", draft.raw(c));
    let mut taken =
        vec![format!("time {}", named(draft.clock.column)), format!("motion {}", named(draft.moving()))];
    taken.extend(match draft.roles.input {
        Input::None => None,
        Input::Base(c) => Some(format!("base {}", named(c))),
        Input::Force(c) => Some(format!("force {}", named(c))),
        Input::Drive(c) => Some(format!("drive {}", named(c))),
    });
    lines.push(format!("taken for {}", taken.join(", ")));
    lines.extend(draft.remarks.iter().map(|r| format!("note: {}", r.trim_start_matches("EDIT: "))));
    match out {
        Some(out) => {
            lines.push(format!("{} is written: look at its lines marked EDIT, then type", out.display()))
        }
        None => lines.push(
            "save this as a file (or say --out FILE), look at its lines marked EDIT, then type".to_owned(),
        ),
    }
    lines.push(format!("    phisindy run {next}"));
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        for (x, text) in [
            (0.0, "0"),
            (12345.0, "12345"),
            (0.5, "0.5"),
            (1.0 / 3.0, "0.3333"),
            (2e-5, "2.000e-5"),
            (250.0, "250"),
        ] {
            assert_eq!(short(x), text);
        }
        assert_eq!(round(1234.5), 1230.0);
    }

    #[test]
    fn headings_with_quotes_are_raw() {
        assert_eq!(literal("x"), "\"x\"");
        assert_eq!(literal("x \"a\""), "r#\"x \"a\"\"#");
    }
}
