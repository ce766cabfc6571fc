//! The same records in other words: units, origins, samples and files.

use super::format::Format;
use super::question::{Question, TIME, heading, put, records};
use super::rewording::Reworded;
use crate::dice::Dice;
use phisindy_phys::spec::{CsvSpec, Role, Spec};
use phisindy_phys::splice::quoted;

/// Units by which the same is said: unit, another, and how many decimal places the number moves.
pub(super) const UNITS: &[(&str, &str, i32)] = &[
    ("m", "mm", 3),
    ("m", "um", 6),
    ("m", "km", -3),
    ("mm", "m", -3),
    ("m/s", "mm/s", 3),
    ("m/s", "m/ms", -3),
    ("m/s^2", "cm/s^2", 2),
    ("N", "kN", -3),
    ("N", "mN", 3),
    ("N/m", "kN/m", -3),
    ("N/m", "N/mm", -3),
    ("N*s/m", "N*s/mm", -3),
    ("kg", "g", 3),
    ("kg", "t", -3),
    ("s", "ms", 3),
    ("s", "us", 6),
];
/// Standard gravity, by definition.
const GRAVITY: f64 = 9.80665;
/// Where another clock begins, in seconds.
pub(super) const ORIGIN: f64 = 512.0;
/// A day in 2023 since 1970.
pub(super) const EPOCH: f64 = 1.7e9;

/// A number with its point moved: not a digit of it changes.
pub(super) fn moved(number: &str, places: i32) -> Option<String> {
    let (digits, exponent) = number.split_once(['e', 'E']).unwrap_or((number, "0"));
    Some(format!("{digits}e{}", exponent.parse::<i32>().ok()? + places))
}

/// Another unit for one, drawn.
pub(super) fn other(unit: &str, dice: &mut Dice) -> Option<(&'static str, i32)> {
    let all: Vec<_> = UNITS.iter().filter(|(of, ..)| *of == unit).collect();
    (!all.is_empty()).then(|| *dice.pick(&all)).map(|(_, to, places)| (*to, *places))
}

/// A quantity with a column, drawn, and the unit of its numbers; if `fits`.
fn drawn(spec: &Spec, dice: &mut Dice, fits: impl Fn(&str, &str) -> bool) -> Option<(String, String)> {
    let first = records(spec).next()?;
    let all: Vec<_> = first
        .columns
        .iter()
        .map(|(name, column)| {
            (name.value.clone(), column.unit.as_ref().map_or(String::new(), |u| u.value.clone()))
        })
        .filter(|(name, unit)| fits(name, unit))
        .collect();
    (!all.is_empty()).then(|| dice.pick(&all).clone())
}

/// With the unit of a quantity's columns replaced, and their numbers changed by `to`.
fn column(
    mut question: Question,
    spec: &Spec,
    quantity: &str,
    unit: &str,
    to: impl FnMut(&str) -> Option<String>,
) -> Option<Question> {
    question.rewrite(quantity, spec, to)?;
    let units =
        records(spec).filter_map(|r| heading(r, quantity)?.unit.as_ref().map(|u| (u.span, unit.to_owned())));
    Some(question.edited(units.collect()))
}

/// As [`column()`], with a number for a number.
fn scaled(by: impl Fn(f64) -> f64) -> impl FnMut(&str) -> Option<String> {
    move |text| text.parse().ok().map(|x| format!("{:?}", by(x)))
}

pub(super) fn unit(question: Question, spec: &Spec, dice: &mut Dice) -> Option<Reworded> {
    let (quantity, unit) = drawn(spec, dice, |_, unit| UNITS.iter().any(|(of, ..)| *of == unit))?;
    let (to, places) = other(&unit, dice)?;
    column(question, spec, &quantity, to, |text| moved(text, places)).map(Reworded::from)
}

pub(super) fn unit_of_time(question: Question, spec: &Spec, dice: &mut Dice) -> Option<Reworded> {
    let (to, places) = other("s", dice)?;
    column(question, spec, TIME, to, |text| moved(text, places)).map(Reworded::from)
}

pub(super) fn gravities(question: Question, spec: &Spec, dice: &mut Dice) -> Option<Reworded> {
    let (quantity, _) = drawn(spec, dice, |_, unit| unit == "m/s^2")?;
    column(question, spec, &quantity, "gn", scaled(|x| x / GRAVITY)).map(Reworded::from)
}

/// With a field of the sensor of a quantity in each record that has it.
fn sensor(mut question: Question, spec: &Spec, quantity: &str, field: &str, value: &str) -> Option<Question> {
    for (k, _) in records(spec).enumerate().filter(|(_, r)| heading(r, quantity).is_some()) {
        question = question.set(&["data", &k.to_string(), "sensors", quantity, field], value)?;
    }
    Some(question)
}

pub(super) fn gain(mut question: Question, spec: &Spec, dice: &mut Dice) -> Option<Reworded> {
    let (quantity, _) = drawn(spec, dice, |_, _| true)?;
    let (gain, places) = *dice.pick(&[("100.0", 2), ("0.01", -2)]);
    question.rewrite(&quantity, spec, |text| moved(text, places))?;
    sensor(question, spec, &quantity, "gain", gain).map(Reworded::from)
}

pub(super) fn counts(question: Question, spec: &Spec, dice: &mut Dice) -> Option<Reworded> {
    let (quantity, per) = question.counts.clone()?;
    let count = scaled(move |x| (x * per).round());
    if dice.chance(0.5) {
        return column(question, spec, &quantity, &format!("mm/{per}"), count).map(Reworded::from);
    }
    let mut question = question;
    question.rewrite(&quantity, spec, count)?;
    let said = format!("(\"mm\", {per})");
    let bare = |r: &CsvSpec| {
        let column = heading(r, &quantity)?;
        // From before the heading's quotes to after the bracket.
        let end = column.unit.as_ref()?.span.end + 2;
        Some((phisindy_expr::Span::new(column.header.span.start - 2, end), quoted(&column.header.value)))
    };
    let places = records(spec).filter_map(bare).collect();
    sensor(question.edited(places), spec, &quantity, "per", &said).map(Reworded::from)
}

pub(super) fn quantum(question: Question, spec: &Spec, _: &mut Dice) -> Option<Reworded> {
    let (quantity, per) = question.counts.clone()?;
    sensor(question, spec, &quantity, "quantum", &format!("({:?}, \"mm\")", 1.0 / per)).map(Reworded::from)
}

/// With times counted from another origin.
pub(super) fn from_origin(mut question: Question, spec: &Spec, origin: f64) -> Option<Reworded> {
    question.rewrite(TIME, spec, scaled(|t| t + origin))?;
    let ends = records(spec).filter_map(|r| r.window.as_ref()).flat_map(|(a, b)| [a, b]);
    let windows: Vec<_> = ends.map(|end| (end.span, format!("{:?}", end.value + origin))).collect();
    let since = [(TIME.to_owned(), format!("({TIME} - {origin:?})"))];
    let expressions = super::question::expressions(spec).into_iter().map(|e| (e.span, put(&e.value, &since)));
    Some(question.edited(windows.into_iter().chain(expressions).collect()).into())
}

pub(super) fn cut(question: Question, spec: &Spec, _: &mut Dice) -> Option<Reworded> {
    let (k, record) = records(spec).enumerate().find(|(_, r)| r.role == Role::Fit && r.start.is_empty())?;
    let sheet = question.sheets.get(&record.path.value)?;
    let column = sheet.heads.iter().position(|head| *head == record.time.header.value)?;
    let times: Option<Vec<f64>> = sheet.rows.iter().map(|row| row[column].parse().ok()).collect();
    let times = times?;
    let (from, to) = record.window.as_ref().map_or((times[0], *times.last()?), |(a, b)| (a.value, b.value));
    let inside: Vec<f64> = times.into_iter().filter(|t| (from..=to).contains(t)).collect();
    let (before, after) = (inside.get(inside.len() / 2 - 1)?, inside.get(inside.len() / 2)?);
    let middle = 0.5 * (before + after);
    let text = question.spec[record.span.range()].to_owned();
    let mut question = question.edited(vec![(record.span, format!("{text}, {text}"))]);
    for (at, part, window) in [(k, "early", (from, middle)), (k + 1, "late", (middle, to))] {
        let at = at.to_string();
        question = question.set(&["data", &at, "name"], &quoted(part))?;
        question = question.set(&["data", &at, "window"], &format!("{window:?}"))?;
    }
    Some(question.into())
}

/// With each file in another format.
pub(super) fn file(mut question: Question, spec: &Spec, format: Format) -> Option<Reworded> {
    let mut places = Vec::new();
    for record in records(spec) {
        let stem = record.path.value.rsplit_once('.').map_or(&*record.path.value, |(stem, _)| stem);
        let path = format!("{stem}.{}", format.extension());
        if let Some(mut sheet) = question.sheets.remove(&record.path.value) {
            sheet.format = format;
            question.sheets.insert(path.clone(), sheet);
        }
        places.push((record.path.span, path));
        let start = record.span.start;
        places.push((phisindy_expr::Span::new(start, start + "Csv".len()), "Table".to_owned()));
    }
    Some(question.edited(places).into())
}

/// With some rows of each file only.
pub(super) fn rows(mut question: Question, keep: impl Fn(usize) -> bool) -> Reworded {
    for sheet in question.sheets.values_mut() {
        let mut k = 0;
        sheet.rows.retain(|_| {
            k += 1;
            keep(k - 1)
        });
    }
    question.into()
}

pub(super) fn later(question: Question, _: &Spec, dice: &mut Dice) -> Option<Reworded> {
    let first = dice.whole(1, 5);
    Some(rows(question, |k| k >= first))
}
