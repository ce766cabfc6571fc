//! The part of the motion that has more of the residual than its share of the samples: a stretch of time, a
//! regime, or a range of a displacement, velocity or input.

use crate::decisions::SURPLUS;
use phisindy_learn::Calibration;
use phisindy_phys::spec::Role;
use phisindy_phys::{Record, System};

/// The share of a column in the gap, and where it lies.
#[derive(Clone, Debug)]
pub struct Region {
    /// Name of the column.
    pub column: String,
    /// Part of the sum of (residual/noise)^2 of all columns.
    pub share: f64,
    /// Where in the motion.
    pub location: Location,
    /// Part of the column's sum that lies there.
    pub power: f64,
}

/// Where in a motion.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)] // the names say it; values are in `unit`
pub enum Location {
    Everywhere,
    Sticking,
    Switching,
    Slipping,
    FirstFifth,
    FirstHalf,
    LastHalf,
    LastFifth,
    Above { name: String, value: f64, unit: String },
    Below { name: String, value: f64, unit: String },
    SizeAbove { name: String, value: f64, unit: String },
    SizeBelow { name: String, value: f64, unit: String },
}

/// A subset of the samples.
struct Cut {
    location: Location,
    /// Fraction of the residual's power minus fraction of the samples.
    surplus: f64,
    power: f64,
}

/// A quantity that may separate large from small residuals.
struct Axis {
    name: String,
    /// As in the spec, empty for time and regime.
    unit: String,
    /// Factor from `unit` to SI.
    factor: f64,
    /// Values in SI, one per sample.
    values: Vec<f64>,
}

/// The location of the residuals of the Fit records, column by column, largest share first.
pub(crate) fn regions(
    system: &System,
    records: &[Record],
    fitted: &Calibration,
    noise: &[Vec<f64>],
) -> Vec<Region> {
    let mut all: Vec<(f64, Region)> = Vec::new();
    for (k, (column, _)) in system.quantities().take(system.columns()).enumerate() {
        let mut total = 0.0;
        let mut axes: Vec<Axis> = Vec::new();
        let mut power: Vec<f64> = Vec::new();
        for (r, fit) in fitted.records.iter().enumerate().filter(|(_, f)| f.role == Role::Fit) {
            let (Some(run), residual) = (&fit.run, &fit.residuals[k]) else { continue };
            if residual.is_empty() {
                continue;
            }
            let record = &records[r];
            let span = record.time[record.len() - 1] - record.time[0];
            let switches = run.modes.len() / residual.len().max(1);
            let own: Vec<usize> = (0..residual.len()).filter(|&i| fit.own_times.has(k, i)).collect();
            let along = |value: &dyn Fn(usize) -> f64| own.iter().map(|&i| value(i)).collect::<Vec<f64>>();
            let mut put = |name: &str, unit: &str, factor: f64, values: Vec<f64>| match axes
                .iter_mut()
                .find(|a| a.name == name)
            {
                Some(axis) => axis.values.extend(values),
                None => axes.push(Axis { name: name.to_owned(), unit: unit.to_owned(), factor, values }),
            };
            put("time", "", 1.0, along(&|i| (record.time[i] - record.time[0]) / span));
            for (s, other) in system.states.iter().enumerate() {
                let values = along(&|i| run.states[i * run.n + s]);
                put(&other.name, &other.unit, other.factor, values);
            }
            for (u, input) in system.inputs.iter().enumerate() {
                let values = along(&|i| record.inputs[u].value(record.time[i]));
                put(&input.name, &input.unit, input.factor, values);
            }
            let near = 0.02 * span;
            let regime = |i: usize| {
                let stuck = switches > 0 && run.modes[i * switches..(i + 1) * switches].contains(&0);
                let switching = run.changes_near(record.time[i], 0.05 * near);
                if stuck {
                    2.0
                } else if switching {
                    1.0
                } else {
                    0.0
                }
            };
            put("regime", "", 1.0, along(&regime));
            let noise = noise[r][record.columns[..k].iter().flatten().count()];
            let powers = along(&|i| (residual[i] / noise).powi(2));
            total += powers.iter().sum::<f64>();
            power.extend(powers);
        }
        if power.is_empty() {
            continue;
        }
        let cuts = axes.iter().flat_map(|axis| cuts(axis, &power));
        let best = cuts.max_by(|a, b| a.surplus.total_cmp(&b.surplus));
        let (location, power) = match best {
            Some(cut) if cut.surplus > SURPLUS => (cut.location, cut.power),
            _ => (Location::Everywhere, 1.0),
        };
        all.push((total, Region { column: column.to_owned(), share: 0.0, location, power }));
    }
    let sum: f64 = all.iter().map(|(total, _)| total).sum();
    let share = |total: f64| total / sum.max(f64::MIN_POSITIVE);
    let mut out: Vec<Region> =
        all.into_iter().map(|(total, region)| Region { share: share(total), ..region }).collect();
    out.sort_by(|a, b| b.share.total_cmp(&a.share));
    out
}

/// The upper and lower quarters of a quantity and of its size; stick, switch and slip for the regime; fifths
/// and halves of the time.
fn cuts(axis: &Axis, power: &[f64]) -> Vec<Cut> {
    let Axis { name, values, .. } = axis;
    let total: f64 = power.iter().sum();
    let count = power.len() as f64;
    let cut = |location: Location, inside: &dyn Fn(f64) -> bool| {
        let (mut p, mut c) = (0.0, 0.0);
        for (v, e) in values.iter().zip(power) {
            if inside(*v) {
                p += e;
                c += 1.0;
            }
        }
        let (p, c) = (p / total.max(f64::MIN_POSITIVE), c / count);
        Cut { location, surplus: p - c, power: p }
    };
    if name == "regime" {
        return vec![
            cut(Location::Sticking, &|v| v == 2.0),
            cut(Location::Switching, &|v| v == 1.0),
            cut(Location::Slipping, &|v| v == 0.0),
        ];
    }
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let q = |p: f64| sorted[((sorted.len() - 1) as f64 * p) as usize];
    if name == "time" {
        return vec![
            cut(Location::FirstFifth, &|v| v < 0.2),
            cut(Location::FirstHalf, &|v| v < 0.5),
            cut(Location::LastHalf, &|v| v >= 0.5),
            cut(Location::LastFifth, &|v| v >= 0.8),
        ];
    }
    let mut sizes: Vec<f64> = values.iter().map(|v| v.abs()).collect();
    sizes.sort_unstable_by(f64::total_cmp);
    let size = |p: f64| sizes[((sizes.len() - 1) as f64 * p) as usize];
    let (high, low, large, small) = (q(0.75), q(0.25), size(0.75), size(0.25));
    let of = |x: f64| (name.clone(), x / axis.factor, axis.unit.clone());
    let place = |kind: fn((String, f64, String)) -> Location, at: f64| kind(of(at));
    vec![
        cut(place(|(name, value, unit)| Location::Above { name, value, unit }, high), &|v| v > high),
        cut(place(|(name, value, unit)| Location::Below { name, value, unit }, low), &|v| v < low),
        cut(place(|(name, value, unit)| Location::SizeAbove { name, value, unit }, large), &|v| {
            v.abs() > large
        }),
        cut(place(|(name, value, unit)| Location::SizeBelow { name, value, unit }, small), &|v| {
            v.abs() < small
        }),
    ]
}
