//! The limits of a rig, in SI.

use phisindy_phys::Record;
use phisindy_phys::System;
use phisindy_phys::spec::{ConstantSpec, Spec, Text};
use phisindy_phys::unit::Unit;

/// The lowest frequency of a drive makes so many cycles in a run; the highest has so many samples in a cycle.
const CYCLES: f64 = 2.0;
const SAMPLES_IN_A_CYCLE: f64 = 20.0;

/// What one quantity may do.
#[derive(Clone, Debug, PartialEq)]
pub struct Range {
    /// Its name.
    pub name: String,
    /// The unit that the spec has it in.
    pub unit: String,
    /// How many SI units this is.
    pub factor: f64,
    /// Lowest and highest value (SI).
    pub within: (f64, f64),
    /// Whether the spec says so; otherwise it is what the records have shown.
    pub stated: bool,
}

/// Within what a next run stays.
#[derive(Clone, Debug, PartialEq)]
pub struct Limits {
    /// Of the inputs that may drive it, in the order of the system.
    pub inputs: Vec<(usize, Range)>,
    /// Of columns (states, then outputs) that must stay within.
    pub columns: Vec<(usize, Range)>,
    /// Of constants that can be set before a run.
    pub constants: Vec<Range>,
    /// The longest run (s), and whether the spec says so.
    pub duration: (f64, bool),
    /// The frequencies of a drive (Hz), and whether the spec says so.
    pub band: (f64, f64, bool),
}

impl Limits {
    /// As the spec states them; what it does not say is what its records have shown.
    pub fn of(spec: &Spec, system: &System, records: &[Record]) -> Limits {
        let stated = spec.limits.clone().unwrap_or_default();
        let range = |(name, unit, factor): (&str, &str, f64), within: (f64, f64), stated: bool| Range {
            name: name.to_owned(),
            unit: unit.to_owned(),
            factor,
            within,
            stated,
        };
        let of_spec = |of: (&str, &str, f64)| {
            let own = stated.ranges.iter().find(|(n, _)| n.value == of.0);
            own.map(|(_, (low, high))| range(of, (low.value * of.2, high.value * of.2), true))
        };
        let shown = |of: (&str, &str, f64), columns: Vec<&[f64]>| {
            let all = || columns.iter().flat_map(|c| c.iter().copied());
            let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
            (low < high).then(|| range(of, (low, high), false))
        };
        let says = stated.ranges.iter().any(|(n, _)| system.input(&n.value).is_some());
        let inputs = system.inputs.iter().enumerate().filter_map(|(k, input)| {
            // What follows from another input, or what the spec leaves out where it names others, is not driven.
            let follows = records.iter().any(|r| r.derivations.iter().any(|d| d.input == k));
            let of = (input.name.as_str(), input.unit.as_str(), input.factor);
            let seen = || {
                let columns = records.iter().map(|r| r.inputs[k].values()).collect();
                shown(of, columns).filter(|_| !says)
            };
            let range = of_spec(of).or_else(seen).filter(|_| !follows);
            range.map(|range| (k, range))
        });
        let inputs: Vec<(usize, Range)> = inputs.collect();
        let columns = (0..system.columns()).filter_map(|k| {
            let (name, unit) = system.measured(k);
            let of = (name, unit, system.factor(k));
            let seen = || shown(of, records.iter().filter_map(|r| r.columns[k].as_deref()).collect());
            of_spec(of).or_else(seen).map(|range| (k, range))
        });
        let columns = columns.collect();
        let of_constant = |(name, constant): &(Text, ConstantSpec)| {
            let unit = constant.unit().map_or("", |unit| unit.value.as_str());
            of_spec((&name.value, unit, Unit::parse(unit).map_or(1.0, |unit| unit.factor)))
        };
        let constants = spec.constants.iter().filter_map(of_constant).collect();
        let longest = records.iter().map(|r| r.time[r.len() - 1] - r.time[0]).fold(0.0, f64::max);
        let duration = stated.duration.as_ref().map_or((longest, false), |d| (d.value, true));
        let step = records.iter().map(step).fold(f64::INFINITY, f64::min);
        // A faster drive is another one between its samples, however these are joined.
        let fastest = (SAMPLES_IN_A_CYCLE * step).recip();
        let band = stated.band.as_ref().map_or_else(
            || ((CYCLES / duration.0).min(fastest), fastest, false),
            |(low, high)| (low.value.min(fastest), high.value.min(fastest), true),
        );
        Limits { inputs, columns, constants, duration, band }
    }
}

/// The time between the samples of a record, on the whole.
pub fn step(record: &Record) -> f64 {
    (record.time[record.len() - 1] - record.time[0]) / (record.len() - 1).max(1) as f64
}
