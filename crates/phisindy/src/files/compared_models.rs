//! The texts of a model that a comparison fits: with all numbers free, with those that were found held or believed within
//! their errors, and with the records of another spec.

use crate::error::{Error, SpecError};
use phisindy_compare::Estimates;
use phisindy_phys::spec::{self, ConstantSpec, DataSpec, Number, Spec, Text};
use phisindy_phys::{Sources, splice};

/// A number may move by this factor in another record.
const REACH: f64 = 10.0;
/// What is believed of the gain of a sensor before it is asked: an exchanged or miscalibrated one seldom errs by more.
const GAIN_BELIEF: f64 = 0.1;
/// The start of the name of the constant that is a gain.
const GAIN: &str = "gain_of_";

/// Reads a spec.
pub(super) fn parsed(text: &str) -> Result<Spec, Error> {
    let mut sources = Sources::default();
    let source = sources.add("the model", text.to_owned());
    spec::read_without_files(text, source)
        .map(|(spec, _)| spec)
        .map_err(|mistakes| SpecError::new(mistakes, sources).into())
}

/// What a parameter of a fit is called: a gain that is asked for here, in words.
pub(super) fn label(parameter: &str) -> String {
    parameter.strip_prefix(GAIN).map_or(parameter.to_owned(), gain_of)
}

/// What the gain of a column is called.
pub(super) fn gain_of(column: &str) -> String {
    format!("gain of {column}")
}

/// A number that may move, as a spec writes it.
struct Movable<'a> {
    value: f64,
    unit: Option<&'a Text>,
    within: (f64, f64),
    sigma: Option<f64>,
}

impl<'a> Movable<'a> {
    /// That of a constant; `None` for one that is held, and for one of each record.
    fn of(constant: &'a ConstantSpec) -> Option<Movable<'a>> {
        let ends = |(low, high): &(Number, Number)| (low.value, high.value);
        let sigma = |sigma: &Option<Number>| sigma.as_ref().map(|s| s.value);
        let (value, unit, within, sigma, each) = match constant {
            ConstantSpec::Movable(m) => (&m.value, &m.unit, ends(&m.within), sigma(&m.sigma), m.each),
            ConstantSpec::Find(f) => (&f.start, &f.unit, ends(&f.within), sigma(&f.sigma), f.each),
            _ => return None,
        };
        (!each).then_some(Movable { value: value.value, unit: unit.as_ref(), within, sigma })
    }

    fn written(&self) -> String {
        let Movable { value, unit, within: (low, high), sigma } = self;
        let unit = unit.map_or(String::new(), |unit| format!(", unit: {:?}", unit.value));
        let sigma = sigma.map_or(String::new(), |sigma| format!(", sigma: {sigma:?}"));
        format!("Find(start: {value:?}{unit}, within: ({low:?}, {high:?}){sigma})")
    }
}

/// A number that is held, as a spec writes it.
fn held(value: f64, unit: Option<&Text>) -> String {
    unit.map_or(format!("{value:?}"), |unit| format!("({value:?}, {:?})", unit.value))
}

/// The model with each constant as `now` says; `None` leaves it.
fn with_constants(model: &str, now: impl Fn(&str, &ConstantSpec) -> Option<String>) -> Result<String, Error> {
    let mut text = model.to_owned();
    for (name, constant) in &parsed(model)?.constants {
        if let Some(now) = now(&name.value, constant) {
            text = splice::set_at(&text, &["constants", &name.value], &now)?;
        }
    }
    Ok(text)
}

/// The identified model with its numbers free again: coefficients, and what the spec let move.
pub(super) fn freed(model: &str, given: &Spec) -> Result<String, Error> {
    with_constants(model, |name, constant| {
        let ConstantSpec::Number { value, unit } = constant else { return None };
        let before = given.constants.iter().find(|(n, _)| n.value == name).map(|(_, c)| c);
        let within = match before {
            Some(before) => Movable::of(before)?.within,
            None => (-REACH * value.value.abs(), REACH * value.value.abs()),
        };
        let free = Movable { value: value.value, unit: unit.as_ref(), within, sigma: None };
        (within.0 < value.value && value.value < within.1).then(|| free.written())
    })
}

/// The model as it was found in the older record: each number held, or within its error.
pub(super) fn believed(model: &str, known: &Estimates, hold: bool) -> Result<String, Error> {
    with_constants(model, |name, constant| {
        let movable = Movable::of(constant)?;
        let k = known.position(name)?;
        let factor = known.numbers[k].factor;
        let (value, sigma) = (known.values[k] / factor, known.std_error(k) / factor);
        let inside = movable.within.0 < value && value < movable.within.1;
        let now = || {
            if hold {
                held(value, movable.unit)
            } else {
                Movable { value, sigma: Some(sigma), ..movable }.written()
            }
        };
        (inside && sigma > 0.0 && sigma.is_finite()).then(now)
    })
}

/// A model in which each number may move, the gains of all columns too: what changed need not be what was to be found.
/// A number that the record does not determine is held by a belief as wide as itself.
pub(super) fn all_free(model: &str) -> Result<String, Error> {
    let spec = parsed(model)?;
    // Of a synthetic record the truth has the constants, and the sensors are perfect.
    let measured = spec.data.iter().all(|data| matches!(data, DataSpec::Csv(_)));
    let mut text = with_constants(model, |_, constant| {
        let free = match constant {
            ConstantSpec::Number { value, unit } if measured => {
                let (a, b) = (value.value / REACH, value.value * REACH);
                Movable { value: value.value, unit: unit.as_ref(), within: (a.min(b), a.max(b)), sigma: None }
            }
            other => Movable::of(other)?,
        };
        let asked = free.sigma.is_none() && free.value != 0.0;
        asked.then(|| Movable { sigma: Some(free.value.abs()), ..free }.written())
    })?;
    for column in columns(&spec).into_iter().filter(|_| measured) {
        let number = format!("{GAIN}{}", column.replace('.', "_"));
        let taken = spec.constants.iter().any(|(other, _)| other.value == number);
        if taken || spec.data.iter().any(|data| has_gain(data, &column)) {
            continue;
        }
        let free = Movable { value: 1.0, unit: None, within: (1.0 / REACH, REACH), sigma: Some(GAIN_BELIEF) };
        text = splice::set_at(&text, &["constants", &number], &free.written())?;
        for (k, _) in spec.data.iter().enumerate().filter(|(_, data)| names(data).any(|name| name == column))
        {
            let path = ["data", &k.to_string(), "sensors", &column, "gain"];
            text = splice::set_at(&text, &path, &splice::quoted(&number))?;
        }
    }
    Ok(text)
}

/// A model with the records of another spec, and with the constants that this one holds.
pub(super) fn with_records_of(model: &str, newer: &str) -> Result<String, Error> {
    let spec = parsed(newer)?;
    let entries = spec.data.iter().map(|data| match data {
        DataSpec::Csv(csv) => csv.span,
        DataSpec::Synthetic(made) => made.span,
    });
    let entries: Vec<&str> = entries.map(|span| &newer[span.range()]).collect();
    let text = splice::set(model, "data", &format!("[{}]", entries.join(", ")))?;
    with_constants(&text, |name, constant| {
        let ConstantSpec::Number { value: before, unit: unit_before } = constant else { return None };
        let (_, now) = spec.constants.iter().find(|(n, _)| n.value == name)?;
        let ConstantSpec::Number { value, unit } = now else { return None };
        let word = |unit: &Option<Text>| unit.as_ref().map(|u| u.value.clone());
        let same = value.value == before.value && word(unit) == word(unit_before);
        (!same).then(|| held(value.value, unit.as_ref()))
    })
}

/// The columns of a record that its spec uses.
fn names(data: &DataSpec) -> impl Iterator<Item = &str> {
    let columns = match data {
        DataSpec::Csv(csv) => csv.columns.as_slice(),
        DataSpec::Synthetic(_) => &[],
    };
    columns.iter().map(|(name, _)| name.value.as_str())
}

/// Those of all records.
pub(super) fn columns(spec: &Spec) -> Vec<String> {
    let mut all: Vec<String> = spec.data.iter().flat_map(names).map(str::to_owned).collect();
    all.sort();
    all.dedup();
    all
}

/// Whether a record has a gain of its own for a column.
fn has_gain(data: &DataSpec, column: &str) -> bool {
    let DataSpec::Csv(csv) = data else { return false };
    csv.sensors.iter().any(|(name, sensor)| name.value == column && sensor.gain.is_some())
}

#[cfg(test)]
mod tests {
    use super::*;

    const MODEL: &str = r#"(constants: { "m": (2.0, "kg"), "k": (value: 8.0, unit: "N/m", within: (4.0, 16.0)), "zero": 0.0 },
        states: { "x": "m" }, known: { "x": "0" }, // kept
        data: [ Csv(path: "a.csv", time: "t", columns: { "x": "x" }, sensors: { "x": (offset: 0.1) }) ])"#;

    #[test]
    fn all_numbers_and_gains_are_free_and_nothing_else_changes() {
        let free = all_free(MODEL).expect("a text");
        assert!(
            free.contains(r#""m": Find(start: 2.0, unit: "kg", within: (0.2, 20.0), sigma: 2.0)"#),
            "{free}"
        );
        assert!(
            free.contains(r#""k": Find(start: 8.0, unit: "N/m", within: (4.0, 16.0), sigma: 8.0)"#),
            "{free}"
        );
        assert!(free.contains(r#""gain_of_x": Find(start: 1.0, within: (0.1, 10.0), sigma: 0.1)"#), "{free}");
        assert!(free.contains(r#"sensors: { "x": (offset: 0.1, gain: "gain_of_x") }"#), "{free}");
        assert!(free.contains(r#""zero": 0.0"#) && free.contains("// kept"), "{free}");
    }

    #[test]
    fn records_and_held_constants_are_those_of_the_newer_spec() {
        let newer = MODEL
            .replace("a.csv", "b.csv")
            .replace("(2.0, \"kg\")", "(2.5, \"kg\")")
            .replace("8.0, unit", "9.0, unit");
        let moved = with_records_of(MODEL, &newer).expect("a text");
        assert!(moved.contains("b.csv") && !moved.contains("a.csv") && moved.contains("// kept"), "{moved}");
        assert!(moved.contains(r#""m": (2.5, "kg")"#) && moved.contains("value: 8.0"), "{moved}");
    }
}
