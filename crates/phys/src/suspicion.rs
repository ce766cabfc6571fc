//! What is odd about a record before any model is fitted.
//!
//! Detected are missing samples, constant, quantised, repeated, clipped and frozen columns, spikes, jumps of
//! level, undersampled inputs (this file and its detectors on one column), velocities that are not the rate
//! of their displacement (`rates`), and columns or units that contradict the known part (`balance`). Each
//! finding is a [`Suspicion`]; `words` turns it into a sentence.

mod balance;
mod clipped;
mod frozen;
mod jumps;
mod rates;
mod repeats;
mod scatter;
mod spikes;
mod words;
mod wraparound;

pub use clipped::clipped;
pub use words::Suspicion;
pub use wraparound::{Wrap, wraps};

use crate::system::equations::System;
use crate::system::record::Record;
use balance::balance;
use frozen::frozen;
use jumps::jumps;
use phisindy_signal::{
    Interpolation, Signal, bounds, moves_by_jumps, noise_level, quantum, standard_deviation,
};
use rates::rates;
use repeats::repeats;
use spikes::spikes;
use std::borrow::Cow;

/// A time step of this many median steps is a gap.
const GAP_STEPS: f64 = 5.0;
/// A gap in more than one of this many steps is no gap, but how this record is sampled.
const RARE_GAPS: usize = 50;
/// A quantisation step beyond this part of the standard deviation hides the motion.
const COARSE_STEP: f64 = 0.2;
/// A column of fewer levels is a switch, not a quantised motion.
const MIN_LEVELS: usize = 3;
/// An interpolation error beyond this part of the standard deviation of an input changes the result.
const INTERPOLATION_ERROR: f64 = 0.01;
/// A smaller part of the largest jump of a switched input is noise.
const LOW_JUMP: f64 = 0.1;
/// Fewer samples of an input do not tell its interpolation error.
const MIN_INPUT_SAMPLES: usize = 64;

/// What is odd about a record. Nothing of it prevents a fit.
pub fn suspicions(system: &System, record: &Record) -> Vec<Suspicion> {
    let mut found = Vec::new();
    let clocks = (0..system.columns()).filter(|&k| record.columns[k].is_some() && !record.own_times.all(k));
    let clocks: Vec<Cow<'_, [f64]>> = clocks.map(|k| record.own_times.of(k, &record.time)).collect();
    match clocks.is_empty() {
        true => missing_samples(&record.time, &mut found),
        false => clocks.iter().for_each(|time| missing_samples(time, &mut found)),
    }
    let before = found.len();
    for (k, (name, _)) in system.quantities().take(system.columns()).enumerate() {
        if let Some((time, column)) = record.own_column(k) {
            let column = &*column;
            constant(name, column, &mut found);
            // What a sensor reads of a force or an acceleration may have a flat top where friction holds.
            if k < system.states.len() {
                clipped_range(name, column, false, &mut found);
            }
            let velocity =
                system.states.get(k).and_then(|s| s.velocity).map(|v| record.columns[v].as_deref());
            let velocity = velocity.map(|v| v.map(|v| record.own_times.of(k, v)));
            // Every step of a coarsely quantised or repeated column would be reported as a jump.
            let few = quantised(name, column, &mut found);
            if !repeated(name, column, None, &mut found) && !few && k < system.states.len() {
                let velocity = velocity.as_ref().map(Option::as_deref);
                faulty_samples(&time, name, column, velocity, &mut found);
            }
        }
    }
    let whole = found.len() == before;
    for (k, (input, signal)) in system.inputs.iter().zip(&record.inputs).enumerate() {
        // The samples of an input before they were smoothed for its derivative.
        let raw = record.derivations.iter().find(|d| d.of == k).map(|d| d.column.as_slice());
        let values = raw.unwrap_or(signal.values());
        clipped_range(&input.name, values, true, &mut found);
        let holds = repeated(&input.name, values, Some(signal.kind()), &mut found);
        // A derivative of a repeated input jumps from sample to sample; the input itself is reported.
        let derived = record.derivations.iter().any(|d| d.input == k && repeats(&d.column).is_some());
        if !holds && !derived {
            undersampled(&input.name, signal, &mut found);
        }
    }
    // A faulty column violates the balance too.
    if !rates(system, record, &mut found) && whole {
        balance(system, record, &mut found);
    }
    found
}

/// Gaps in time.
fn missing_samples(time: &[f64], found: &mut Vec<Suspicion>) {
    let mut steps: Vec<f64> = time.windows(2).map(|w| w[1] - w[0]).collect();
    let after = |k: usize| (time[k], time[k + 1]);
    steps.sort_by(f64::total_cmp);
    let usual = steps.get(steps.len() / 2).copied().unwrap_or(0.0);
    let all: Vec<usize> =
        (0..time.len().saturating_sub(1)).filter(|&k| after(k).1 - after(k).0 > GAP_STEPS * usual).collect();
    // Irregular sampling is no gap.
    if let (Some(&first), true) = (all.first(), all.len() * RARE_GAPS <= time.len()) {
        let (from, to) = after(first);
        found.push(Suspicion::MissingSamples { from, to, steps: (to - from) / usual, count: all.len() });
    }
}

/// A column without any change.
fn constant(name: &str, column: &[f64], found: &mut Vec<Suspicion>) {
    let (min, max) = bounds(column);
    if min == max {
        let (column, samples) = (name.to_owned(), column.len());
        found.push(Suspicion::Constant { column, value: min, samples });
    }
}

/// Whether a column has too few digits or comes from too undersampled a sensor.
fn quantised(name: &str, column: &[f64], found: &mut Vec<Suspicion>) -> bool {
    let size = standard_deviation(column);
    let Some(step) = quantum(column, MIN_LEVELS).filter(|step| *step > COARSE_STEP * size) else {
        return false;
    };
    let (min, max) = bounds(column);
    let levels = ((max - min) / step).round() + 1.0;
    found.push(Suspicion::Quantised { column: name.to_owned(), levels, step, size });
    true
}

/// Whether a column repeats each value for several samples. An input with zero-order hold may do so.
fn repeated(name: &str, column: &[f64], input: Option<Interpolation>, found: &mut Vec<Suspicion>) -> bool {
    let Some(length) = repeats(column).filter(|_| input != Some(Interpolation::Hold)) else { return false };
    found.push(Suspicion::Repeated { column: name.to_owned(), length, input: input.is_some() });
    true
}

/// A column that is clipped at the end of its range.
fn clipped_range(name: &str, column: &[f64], input: bool, found: &mut Vec<Suspicion>) {
    let (min, max) = bounds(column);
    let samples = if min < max { clipped(column, min, max) } else { 0 };
    if samples > 0 {
        found.push(Suspicion::Clipped { column: name.to_owned(), range: (min, max), samples, input });
    }
}

/// The interpolation error of an input.
///
/// Every second sample is predicted from the others. With all samples the error is a quarter of that for
/// straight lines (error of order h^2) and a sixteenth for cubics (h^4). The part of the misfit that noise
/// explains does not count.
fn undersampled(name: &str, signal: &Signal, found: &mut Vec<Suspicion>) {
    let (time, values) = (signal.time(), signal.values());
    let order = match signal.kind() {
        Interpolation::Linear => 4.0,
        Interpolation::Cubic => 16.0,
        // With zero-order hold the samples are the input.
        Interpolation::Hold => return,
    };
    if values.len() < MIN_INPUT_SAMPLES {
        return;
    }
    if moves_by_jumps(values) {
        switched(name, values, found);
        return;
    }
    let every_second = |v: &[f64]| v.iter().copied().step_by(2).collect::<Vec<f64>>();
    let Ok(half) = Signal::new(every_second(time).into(), every_second(values), signal.kind()) else {
        return;
    };
    let mut hint = usize::MAX;
    let misfit: Vec<f64> = (1..values.len() - 1)
        .step_by(2)
        .map(|k| values[k] - half.value_and_slope(time[k], &mut hint).0)
        .collect();
    let power = misfit.iter().map(|e| e * e).sum::<f64>() / misfit.len() as f64;
    let noise = noise_level(&misfit).min(noise_level(values));
    let error = (power - 1.5 * noise * noise).max(0.0).sqrt() / order / standard_deviation(values);
    if error > INTERPOLATION_ERROR {
        found.push(Suspicion::Undersampled { input: name.to_owned(), error, interpolation: signal.kind() });
    }
}

/// An input that jumps where its interpolation goes straight. Across a step from one value to the next the
/// mean square of the difference is a third of the square of the jump.
fn switched(name: &str, values: &[f64], found: &mut Vec<Suspicion>) {
    // The noise of the levels makes small steps.
    let largest = values.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max);
    let jumps = || values.windows(2).map(|w| w[1] - w[0]).filter(|d| d.abs() > LOW_JUMP * largest);
    let square: f64 = jumps().map(|d| d * d).sum();
    let error = (square / 3.0 / values.len() as f64).sqrt() / standard_deviation(values);
    if error > INTERPOLATION_ERROR {
        let jumps = jumps().count();
        found.push(Suspicion::Switched { input: name.to_owned(), jumps, error });
    }
}

/// Frozen samples, spikes and jumps of level. `velocity` is `Some` for a displacement, with the column of its
/// velocity if that is measured.
fn faulty_samples(
    time: &[f64],
    name: &str,
    column: &[f64],
    velocity: Option<Option<&[f64]>>,
    found: &mut Vec<Suspicion>,
) {
    if velocity.is_some()
        && let Some(Wrap { period, first, count }) = wraps(column)
    {
        let (column, time) = (name.to_owned(), time[first]);
        found.push(Suspicion::Wrapped { column, period, time, count });
        return;
    }
    let frozen = frozen(column);
    let whole = |k: usize| frozen.iter().all(|r| k + 1 < r.start || k > r.end);
    if let Some(first) = frozen.first() {
        found.push(Suspicion::Frozen {
            column: name.to_owned(),
            value: column[first.start],
            samples: first.len(),
            from_to: (time[first.start], time[first.end - 1]),
            count: frozen.len(),
        });
    }
    // Only displacements are tested for jumps: a velocity jumps at an impact. Levels taken from frozen
    // samples do not count.
    let apart = |k: usize| frozen.iter().all(|r| k + jumps::LEVEL < r.start || k > r.end + jumps::LEVEL);
    let jumps = velocity.map_or(vec![], |v| jumps(time, column, v));
    let jumps: Vec<usize> = jumps.into_iter().filter(|&k| apart(k)).collect();
    let spikes: Vec<usize> = spikes(column)
        .into_iter()
        .filter(|&k| whole(k) && jumps.iter().all(|j| k.abs_diff(*j) > 1))
        .collect();
    if let Some(&first) = spikes.first() {
        let (value, time, count) = (column[first], time[first], spikes.len());
        found.push(Suspicion::Spike { column: name.to_owned(), value, time, count });
    }
    if let Some(&k) = jumps.first() {
        let (before, after) = ((time[k], column[k]), (time[k + 1], column[k + 1]));
        found.push(Suspicion::Jump { column: name.to_owned(), before, after, count: jumps.len() });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    /// A harmonic motion at 2 rad/s, sampled every 0.025 s.
    fn sine(n: usize, phase: f64) -> Vec<f64> {
        // A small irregular part, so that the noise level is not zero.
        (0..n).map(|i| (0.05 * i as f64 + phase).sin() + 1e-4 * (7.3 * (i * i % 97) as f64).sin()).collect()
    }

    fn velocity() -> Vec<f64> {
        sine(2000, FRAC_PI_2).iter().map(|v| 2.0 * v).collect()
    }

    fn record(x: Vec<f64>, v: Vec<f64>) -> (System, Record) {
        let text = r#"(states: {"x": "m", "v": "m/s"}, known: {"x": "v", "v": "-x"}, unknown: {},
            data: [Csv(path: "a.csv", name: "a", time: "t", columns: {"x": ("x", "m"), "v": ("v", "m/s")})])"#;
        let mut sources = crate::text::diagnostic::Sources::default();
        let id = sources.add("spec", text);
        let (spec, _) = crate::text::spec::read(text, id).unwrap();
        let (case, _) = crate::system::check::check(&spec, id).unwrap();
        let time = (0..x.len()).map(|i| 0.025 * i as f64).collect();
        let table =
            crate::system::table::Table { time, columns: vec![x, v], lines: vec![], ..Default::default() };
        let record = Record::from_table(&case.records[0], &table, &case.system, id).unwrap();
        (case.system, record)
    }

    fn told(x: Vec<f64>, v: Vec<f64>) -> String {
        let (system, record) = record(x, v);
        suspicions(&system, &record).iter().map(Suspicion::to_string).collect::<Vec<_>>().join("; ")
    }

    #[test]
    fn a_good_record_is_not_suspected() {
        assert_eq!(told(sine(2000, 0.0), velocity()), "");
    }

    #[test]
    fn what_is_wrong_is_told() {
        let (x, v) = (sine(2000, 0.0), velocity());
        let thousand = |c: &[f64]| c.iter().map(|v| 1000.0 * v).collect::<Vec<f64>>();
        let minus = |c: &[f64]| c.iter().map(|v| -v).collect::<Vec<f64>>();
        assert!(told(thousand(&x), v.clone()).contains("moves at 1000 times the rate"));
        assert!(told(x.clone(), thousand(&v)).contains("1/1000 of the rate"));
        assert!(told(v.clone(), x.clone()).contains("swapped"));
        assert!(told(x.clone(), minus(&v)).contains("opposite sign"));
        assert!(told(x.iter().map(|v| v.clamp(-0.8, 0.8)).collect(), v.clone()).contains("cut off"));
        assert!(told(vec![0.3; 2000], v.clone()).contains("connected"));
        let mut spiked = x.clone();
        spiked[700] = 3.0;
        assert!(told(spiked, v.clone()).contains("at 17.500000 s"));
    }

    #[test]
    fn a_rounded_column_is_told_and_nothing_else_of_it() {
        let quantised =
            |c: &[f64], step: f64| c.iter().map(|v| (v / step).round() * step).collect::<Vec<f64>>();
        let (x, v) = (sine(2000, 0.0), velocity());
        let said = told(quantised(&x, 0.4), v.clone());
        assert!(
            said.contains("`x` has only 7 different values") && said.matches("`x`").count() == 1,
            "{said}"
        );
        // With fine quantisation the peaks are long runs of the largest value, which is no clipping.
        assert_eq!(told(quantised(&x, 0.02), v.clone()), "");
        // A column that is clipped and then quantised is reported as clipped.
        let clipped_range: Vec<f64> = x.iter().map(|v| v.clamp(-0.8, 0.8)).collect();
        assert!(told(quantised(&clipped_range, 0.001), v).contains("cut off"));
    }

    /// Straight lines through a sine are wrong by (w h)^2/8 of the amplitude in the middle of an interval.
    #[test]
    fn an_input_with_few_samples_is_told() {
        let told = |per_period: usize, kind: Interpolation| {
            let step = 1.0 / per_period as f64;
            let time: Vec<f64> = (0..600).map(|i| step * i as f64).collect();
            let values = time.iter().map(|t| (std::f64::consts::TAU * t).sin()).collect();
            let mut found = vec![];
            undersampled("u", &Signal::new(time.into(), values, kind).unwrap(), &mut found);
            found.iter().map(Suspicion::to_string).collect::<Vec<_>>().join("; ")
        };
        assert_eq!(told(40, Interpolation::Linear), "");
        // (2 pi/12)^2/8 = 3.4 % of the amplitude in the middle of each interval.
        assert!(
            told(12, Interpolation::Linear).contains("an error of about 3."),
            "{}",
            told(12, Interpolation::Linear)
        );
        assert_eq!(told(12, Interpolation::Cubic), "");
    }

    #[test]
    fn a_relay_is_to_be_held() {
        let told = |kind: Interpolation| {
            let time: Vec<f64> = (0..600).map(|i| 0.01 * f64::from(i)).collect();
            let values = (0..600).map(|i| if i / 30 % 2 == 0 { 13.3 } else { -13.3 }).collect();
            let mut found = vec![];
            undersampled("u", &Signal::new(time.into(), values, kind).unwrap(), &mut found);
            found.iter().map(Suspicion::to_string).collect::<Vec<_>>().join("; ")
        };
        // 19 jumps of 26.6 in 600 samples: 26.6/13.3*sqrt(19/600/3).
        let said = told(Interpolation::Linear);
        assert!(said.contains("(19 times)") && said.contains("20.5 %") && said.contains("Hold"), "{said}");
        assert_eq!(told(Interpolation::Hold), "");
    }

    #[test]
    fn a_hole_in_time_is_told() {
        let (system, mut record) = record(sine(2000, 0.0), velocity());
        record.time =
            record.time.iter().enumerate().map(|(i, t)| if i < 500 { *t } else { t + 3.0 }).collect();
        assert!(
            suspicions(&system, &record)[0]
                .to_string()
                .contains("no samples from 12.475000 s to 15.500000 s")
        );
    }
}
