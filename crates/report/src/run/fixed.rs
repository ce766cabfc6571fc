//! Constants and sensor parameters that the fit did not move, with their values.

use crate::input::Input;
use crate::table::short;
use phisindy_learn::{Identified, Quantity};
use phisindy_phys::spec::{ConstantSpec, DataSpec, Role};
use phisindy_phys::unit::Unit;
use phisindy_phys::{Sensor, SensorPart};
use serde::Serialize;

/// A number that the fit did not move.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct FixedValue {
    /// `m`, or `x.delay` for a sensor.
    name: String,
    /// In `unit`.
    value: f64,
    /// Unit as the spec writes it; empty for an SI number without a stated unit.
    unit: String,
    /// The record that has this value; none if all records share it.
    record: Option<String>,
    /// By how many per cent what was found moves if this is one per cent larger.
    moves: Vec<Move>,
}

/// How a number that was found moves.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct Move {
    of: String,
    percent: f64,
}

/// All fixed numbers in the order of the spec: constants, constants of records, sensors.
pub(crate) fn fixed_values(input: Input<'_>, found: &Identified) -> Vec<FixedValue> {
    let mut all = constants(input, found);
    for held in &found.held {
        let of = |(number, part): &(Quantity, f64)| Move { of: number.to_string(), percent: *part };
        let told = all.iter_mut().filter(|h| h.name == held.name);
        told.for_each(|h| h.moves = held.moves.iter().map(of).collect());
    }
    let (spec, system, records) = (input.spec, &input.case.system, input.records);
    for (k, (name, _)) in system.record_constants.iter().enumerate() {
        let unit = |r: usize| {
            let own: &[_] = match &spec.data[r] {
                DataSpec::Csv(csv) => &csv.constants,
                DataSpec::Synthetic(synthetic) => &synthetic.constants,
            };
            let stated = own.iter().chain(&spec.constants).find(|(n, _)| n.value == *name);
            stated.map_or(String::new(), |(_, c)| unit_of(c))
        };
        let value = |r: usize| {
            let unit = unit(r);
            Some((records[r].constants.get(k)? / factor(&unit), unit))
        };
        all.extend(of_records(name, input, &value));
    }
    let perfect = Sensor::default();
    for (k, (column, own)) in system.quantities().enumerate() {
        for (part, idle) in SensorPart::ALL.into_iter().zip(perfect.parameters().map(|p| p.start)) {
            let (name, unit) = (format!("{column}.{}", part.name()), part.unit(own));
            let moved = |r: usize| {
                found.parameters.iter().any(|p| p.id.sensor() == Some((k, part)) && p.id.holds_in(r))
            };
            let value = |r: usize| {
                let s = &records[r].sensors[k];
                // A derived input has the sensor of the input that it is derived from, told there.
                if s.follows.is_some() {
                    return None;
                }
                let parameter = s.parameters()[part as usize];
                // Shared constants are listed as constants.
                let told =
                    parameter.shared.is_none() && (parameter.start != idle || parameter.within.is_some());
                (told && !moved(r)).then(|| (parameter.start / factor(unit), unit.to_owned()))
            };
            all.extend(of_records(&name, input, &value));
        }
    }
    all
}

/// Constants of the spec that did not move.
fn constants(input: Input<'_>, found: &Identified) -> Vec<FixedValue> {
    let system = &input.case.system;
    let moved = |name: &str| {
        let moves = |p: &phisindy_learn::FoundParameter| {
            p.id.constant().is_some_and(|k| system.parameters[k].name == name)
        };
        found.parameters.iter().any(moves)
    };
    let value = |name: &str, constant: &ConstantSpec| match constant {
        ConstantSpec::Movable(m) => Some(m.value.value),
        ConstantSpec::Find(f) => Some(f.start.value),
        _ => Some(system.constants.iter().find(|(n, _)| n == name)?.1 / factor(&unit_of(constant))),
    };
    let stands = |(name, constant): &(phisindy_phys::spec::Text, ConstantSpec)| {
        let name = name.value.clone();
        let value = value(&name, constant).filter(|_| !moved(&name))?;
        Some(FixedValue { name, value, unit: unit_of(constant), record: None, moves: vec![] })
    };
    input.spec.constants.iter().filter_map(stands).collect()
}

/// One number for all Fit records, or one for each of them. (A Validate record has the numbers of the run
/// that it continues, or fits its own.)
fn of_records(
    name: &str,
    input: Input<'_>,
    value: &dyn Fn(usize) -> Option<(f64, String)>,
) -> Vec<FixedValue> {
    let fitted: Vec<usize> =
        (0..input.records.len()).filter(|&r| input.records[r].role == Role::Fit).collect();
    let entry = |&r: &usize| {
        let (value, unit) = value(r)?;
        Some(FixedValue {
            name: name.to_owned(),
            value,
            unit,
            record: Some(input.records[r].name.clone()),
            moves: vec![],
        })
    };
    let mut all: Vec<FixedValue> = fitted.iter().filter_map(entry).collect();
    let same = |h: &FixedValue| (h.value, &h.unit) == (all[0].value, &all[0].unit);
    if all.len() == fitted.len() && all.iter().all(same) {
        all.truncate(1);
        all.iter_mut().for_each(|h| h.record = None);
    }
    all
}

/// `held: m = 3.0799 kg, N = 2.4525 N [250 g] and 4.4145 N [450 g]`; none without fixed numbers.
pub(crate) fn line(all: &[FixedValue]) -> Option<String> {
    let mut words: Vec<(&str, Vec<String>)> = Vec::new();
    for h in all {
        let value = format!("{} {}", short(h.value), h.unit);
        let record = h.record.as_ref().map_or(String::new(), |r| format!(" [{r}]"));
        let text = format!("{}{record}", value.trim_end());
        match words.last_mut().filter(|(name, _)| *name == h.name) {
            Some((_, values)) => values.push(text),
            None => words.push((&h.name, vec![text])),
        }
    }
    let each: Vec<String> =
        words.iter().map(|(name, values)| format!("{name} = {}", values.join(" and "))).collect();
    (!each.is_empty()).then(|| format!("held: {}", each.join(", ")))
}

/// Most numbers beside each other in a table that can be read; JSON has them all.
const BESIDE: usize = 8;

/// A table of the constants on which something hangs: by how many per cent each number moves for one of the
/// constant's.
pub(crate) fn moves(all: &[FixedValue]) -> Vec<Vec<String>> {
    let hangs = |h: &&FixedValue| h.moves.iter().any(|m| m.percent.abs() >= 0.005);
    let told: Vec<&FixedValue> = all.iter().filter(hangs).collect();
    let Some(first) = told.first().filter(|first| first.moves.len() <= BESIDE) else { return vec![] };
    let heading = ["with 1 % more".to_owned()].into_iter();
    let mut rows = vec![heading.chain(first.moves.iter().map(|m| m.of.clone())).collect::<Vec<String>>()];
    let row = |h: &&FixedValue| -> Vec<String> {
        let shown =
            |m: &Move| if m.percent.is_finite() { format!("{:+.2} %", m.percent) } else { "-".to_owned() };
        let cells = h.moves.iter().map(shown);
        [h.name.clone()].into_iter().chain(cells).collect()
    };
    rows.extend(told.iter().map(row));
    rows
}

/// The stated unit of a constant.
fn unit_of(constant: &ConstantSpec) -> String {
    let unit = match constant {
        ConstantSpec::Number { unit, .. } => unit.as_ref(),
        ConstantSpec::Movable(m) => m.unit.as_ref(),
        ConstantSpec::Find(f) => f.unit.as_ref(),
        ConstantSpec::Expression(_) | ConstantSpec::MaxAbs(_) => None,
    };
    unit.map_or(String::new(), |u| u.value.clone())
}

fn factor(unit: &str) -> f64 {
    Unit::parse(unit).map_or(1.0, |u| u.factor)
}
