//! The comment at the head of a spec, and a summary for the terminal.

use super::literals::four_digits;
use super::quarter_car;
use crate::draft::Draft;
use crate::question::{OPEN_QUESTION, Question};
use crate::roles::Input;
use std::fmt::Write;

/// The lines at the head of the spec.
pub(super) fn head(draft: &Draft, file: &str, next: &str) -> Vec<String> {
    let first = format!(
        "Written by `phisindy new {file}`. Look at the lines marked EDIT, then type: phisindy {} {next}",
        super::next_step(draft)
    );
    let asked = |question: &Question| format!("{OPEN_QUESTION}{question} ({})", question.edit());
    let mut lines: Vec<String> = draft.questions.iter().map(asked).collect();
    lines.extend([first, String::new(), sampling(draft, file), String::new()]);
    lines.extend(columns(draft));
    lines.push(String::new());
    lines.push(standstill(draft));
    lines.extend(clipping(draft));
    lines.extend(draft.remarks.iter().map(|remark| {
        let mark = if remark.needs_edit() { "EDIT: " } else { "" };
        format!("{mark}{remark}")
    }));
    if draft.decimate > 1 {
        lines.push(format!(
            "The records are long: `decimate` takes the mean of every {} rows, which is a low-pass filter. Without it the fit takes longer.",
            draft.decimate
        ));
    }
    lines
}

/// A table of all columns.
fn columns(draft: &Draft) -> Vec<String> {
    let columns = &draft.table.columns;
    let widths = columns.iter().map(|c| c.heading.raw.chars().count());
    let width = widths.max().unwrap_or(6).clamp(6, 40);
    let heading = format!(
        "{:width$} {:>11} {:>11} {:>11} {:>10} {:>10}  what it is taken for",
        "column", "min", "max", "std", "noise", "frequency"
    );
    let none = || "-".to_owned();
    let row = |(k, column): (usize, &crate::table::Column)| {
        let statistics = &draft.statistics[k];
        let is_time = k == draft.time.column;
        let noise = if is_time || statistics.noise == 0.0 { none() } else { four_digits(statistics.noise) };
        let frequency = draft.frequency(k).map_or_else(none, |f| format!("{} Hz", four_digits(f)));
        let (min, max) = if statistics.min <= statistics.max {
            (four_digits(statistics.min), four_digits(statistics.max))
        } else {
            (none(), none())
        };
        let values = statistics.values.as_ref().filter(|v| v.len() > 1).map_or(String::new(), |v| {
            format!("; values {}", v.iter().map(|x| format!("{x}")).collect::<Vec<_>>().join(", "))
        });
        let missing = match statistics.missing {
            0 => String::new(),
            n => format!("; {n} missing"),
        };
        format!(
            "{:width$} {min:>11} {max:>11} {:>11} {noise:>10} {frequency:>10}  {}{values}{missing}",
            column.heading.raw,
            four_digits(statistics.std),
            draft.usages[k]
        )
    };
    [heading].into_iter().chain(columns.iter().enumerate().map(row)).collect()
}

/// How often the motion is at rest.
fn standstill(draft: &Draft) -> String {
    let (moving, stops) = (draft.raw(draft.moving()), &draft.stops);
    let accelerates = draft.roles.acceleration == Some(draft.moving());
    if stops.fraction <= 0.01 {
        return match accelerates {
            true => format!("`{moving}` is nowhere zero for long: the body is never at rest."),
            false => {
                format!("`{moving}` does not stand still anywhere for long: it turns, but it does not stick.")
            }
        };
    }
    let step = draft.time.step * draft.factor(draft.time.column);
    let longest = stops.stretches.iter().map(|s| s.len()).max().unwrap_or(0) as f64 * step;
    let rests = if accelerates { "is zero" } else { "stands still" };
    format!(
        "`{moving}` {rests} for {:.0} % of the first record, in {} stretches, the longest {} s: friction that sticks, or a pause.",
        100.0 * stops.fraction,
        stops.stretches.len(),
        four_digits(longest)
    )
}

/// Columns that may be clipped.
fn clipping(draft: &Draft) -> impl Iterator<Item = String> {
    let clipped = draft.statistics.iter().enumerate().filter(|(_, s)| s.clipped > 0);
    clipped.map(|(k, statistics)| {
        let mark = if draft.roles.used().any(|used| used == k) { "EDIT: " } else { "" };
        format!(
            "{mark}`{}` stands at exactly its least or greatest value in {} samples, and is still moving when it gets there: is the sensor at its limit?",
            draft.raw(k),
            statistics.clipped
        )
    })
}

/// Number of rows, duration, sampling rate and irregularities.
fn sampling(draft: &Draft, file: &str) -> String {
    let (table, time, times) = (&draft.table, &draft.time, draft.times());
    let unit = draft.factor(time.column);
    let rows = table.rows();
    let span = time.runs(rows).iter().map(|r| times[r.end - 1] - times[r.start]).sum::<f64>() * unit;
    let count = if table.fraction_read < 1.0 {
        let all = rows as f64 / table.fraction_read / 1e6;
        format!("about {all:.0} million rows, of which the first {rows} were looked at")
    } else {
        format!("{rows} rows")
    };
    let uniform = match time.jitter {
        j if j < 1e-3 => "uniform".to_owned(),
        j if j < 0.02 => format!("uniform to {:.1} % of a step", 100.0 * j),
        j => format!("not uniform: steps vary by {:.0} % (no harm)", 100.0 * j),
    };
    let mut text = format!(
        "{file}: {count}, {} s at {} Hz, {uniform}",
        four_digits(span),
        four_digits(1.0 / (time.step * unit))
    );
    let often = |n: usize| if n == 1 { "once".to_owned() } else { format!("{n} times") };
    let lists =
        [(&time.gaps, "gaps in time"), (&time.repeats, "repeated times"), (&time.reversals, "jumps back")];
    for (list, what) in lists {
        if let Some(first) = list.first() {
            let line = table.row_numbers[(*first).min(rows - 1)];
            let _ = write!(text, "; {what} {} (first in line {line})", often(list.len()));
        }
    }
    text + "."
}

/// The text with a capital letter, as a sentence.
fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// The rig that the draft is of, in words that begin with a name of [`Rig`](crate::Rig) where there is one.
fn kind(draft: &Draft) -> &'static str {
    match (draft.roles.input, draft.motion.is_pendulum, draft.roles.is_angle) {
        (Input::Reaction(_), ..) => "a tester, whose motion is prescribed and meets the force",
        (Input::Base(_), ..) if quarter_car::is_one(draft) => "a quarter-car",
        (Input::Base(_) | Input::BaseAcceleration(_), ..) => "base-excited, a body on a base that moves",
        (Input::None, true, _) => "a pendulum",
        (Input::None, ..) => "free, nothing drives it",
        (_, true, _) => "a robot-joint, which a drive turns and gravity pulls",
        (_, false, true) => "a motor, which a drive turns",
        (_, false, false) => "a slider, a body that a force or a drive moves",
    }
}

/// A few lines on the file and on the roles of its columns.
pub fn summary(draft: &Draft, file: &str) -> Vec<String> {
    let named = |c: usize| format!("`{}`", draft.raw(c));
    let time = match draft.time.counted {
        true => format!("time the rows, {} in a second", draft.time.rate),
        false => format!("time {}", named(draft.time.column)),
    };
    let mut taken = vec![time, format!("motion {}", named(draft.moving()))];
    taken.extend(match draft.roles.input {
        Input::None => None,
        Input::Base(c) | Input::BaseAcceleration(c) => Some(format!("base {}", named(c))),
        Input::Force(c) => Some(format!("force {}", named(c))),
        Input::Drive(c) => Some(format!("drive {}", named(c))),
        Input::Reaction(c) => Some(format!("the force that it meets {}", named(c))),
    });
    let kind = kind(draft);
    let mut lines = vec![
        sampling(draft, file),
        format!("taken for {}: {kind} (--rig KIND says another)", taken.join(", ")),
    ];
    lines.extend(draft.remarks.iter().map(|remark| format!("note: {remark}")));
    let asked = |question: &Question| format!("question: {question} {}", capital(&question.answer()));
    lines.extend(draft.questions.iter().map(asked));
    lines
}
