//! What makes a record useless for a fit, told before one is tried.

use crate::decisions::{FEWEST_SAMPLES, FILTER_SEEN};
use crate::result::error::{DataError, LearnError};
use phisindy_phys::{Filter, FilterKind, Record, System};
use phisindy_signal::standard_deviation;
use std::f64::consts::TAU;

/// Refuses a record from which nothing can be learned.
///
/// # Errors
/// It has too few samples, or a column that does not move or is out of range.
pub fn suitable(system: &System, record: &Record) -> Result<(), LearnError> {
    if record.len() < FEWEST_SAMPLES {
        let (record, samples) = (record.name.clone(), record.len());
        return Err(DataError::TooFewSamples { record, samples }.into());
    }
    dead_column(system, record).map_or(Ok(()), |dead| Err(dead.into()))
}

/// What is wrong with a record in which the squares of a moving column are no numbers, or all zero: nothing
/// can be said of how well it is met.
fn column_out_of_range(system: &System, record: &Record) -> Option<DataError> {
    let out = |c: &Option<Vec<f64>>| {
        let moves = |c: &&Vec<f64>| c.iter().any(|v| *v != c[0]);
        c.as_ref()
            .filter(moves)
            .is_some_and(|c| !(c.len() as f64 * standard_deviation(c).powi(2)).is_normal())
    };
    let k = record.columns.iter().position(out)?;
    let column = system.measured(k).0.to_owned();
    Some(DataError::OutOfRange { record: record.name.clone(), column })
}

/// What is wrong with a record in which a column is not a number.
fn not_a_number(system: &System, record: &Record) -> Option<DataError> {
    let lost =
        |(k, c): (usize, &Option<Vec<f64>>)| Some((k, c.as_ref()?.iter().position(|v| !v.is_finite())?));
    let (k, i) = record.columns.iter().enumerate().find_map(lost)?;
    let (record_name, column) = (record.name.clone(), system.measured(k).0.to_owned());
    Some(DataError::NotANumber { record: record_name, column, time: record.time[i] })
}

/// What is wrong with a record of which a sensor shows nothing: it is later than the record is long, or has a
/// filter that is settled between two samples, behind which a jump is no jump and has no sample either.
fn unseen_sensor(system: &System, record: &Record) -> Option<DataError> {
    let duration = record.time.last()? - record.time.first()?;
    let interval = duration / (record.len() - 1).max(1) as f64;
    // Inputs have sensors, and no column here.
    let has = |k: usize| record.columns.get(k).is_none_or(Option::is_some);
    let sensors = system.quantities().zip(&record.sensors).enumerate();
    for (_, ((name, _), sensor)) in sensors.filter(|(k, _)| has(*k)) {
        let delay = sensor.delay.start;
        if delay.abs() >= duration {
            let (record, column) = (record.name.clone(), name.to_owned());
            return Some(DataError::DelayBeyondRecord { record, column, delay, duration });
        }
    }
    let unseen = |filter: &&Filter| {
        let settles = |cutoff: f64| filter.order as f64 / (TAU * cutoff);
        let measured =
            system.column(&system.outputs[filter.output].name).is_some_and(|k| record.columns[k].is_some());
        let fixed = system.graph.value(filter.cutoff);
        filter.kind == FilterKind::Lowpass
            && measured
            && fixed.is_some_and(|f| settles(f) < FILTER_SEEN * interval)
    };
    let filter = system.filters.iter().find(unseen)?;
    let (record, column) = (record.name.clone(), system.outputs[filter.output].name.clone());
    let (cutoff, rate) = (system.graph.value(filter.cutoff)?, 1.0 / interval);
    Some(DataError::FilterBetweenSamples { record, column, cutoff, rate })
}

/// What is wrong with a record that cannot be compared with a model: a column is no number or beyond what can
/// be computed with, or a sensor shows nothing.
pub(crate) fn unreadable(system: &System, record: &Record) -> Option<DataError> {
    not_a_number(system, record)
        .or_else(|| column_out_of_range(system, record))
        .or_else(|| unseen_sensor(system, record))
}

/// What is wrong with a record that cannot be compared with a model, or in which a measured column does not move.
pub fn dead_column(system: &System, record: &Record) -> Option<DataError> {
    let still = |c: &Option<Vec<f64>>| c.as_ref().is_some_and(|c| c.iter().all(|v| *v == c[0]));
    unreadable(system, record).or_else(|| {
        let k = record.columns.iter().position(still)?;
        let column = system.measured(k).0.to_owned();
        Some(DataError::ConstantColumn { record: record.name.clone(), column })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::step::onestep::tests::common;

    /// The mistakes of a record of 6 s, sampled at 250 Hz, with a sensor of its acceleration.
    fn mistake(reads: &str, sensor: &str) -> Option<DataError> {
        let text = format!(
            r#"(states: {{ "x": "m", "v": "m/s" }}, outputs: {{ "a": (unit: "m/s^2", reads: "{reads}") }},
                constants: {{ "k": (9.0, "1/s^2"), "g": (9.8, "m/s^2"), "h": (1.0, "m") }}, known: {{ "x": "v", "v": "-k*x" }}, unknown: {{}},
                data: [ Synthetic(truth: {{}}, start: {{ "x": 1.0, "v": 0.0 }}, duration: 6.0, step: 0.004,
                    sensors: {{ "a": ({sensor}) }}, noise: None, measure: ["a"]) ])"#
        );
        let (case, records) = common::load_text(&text, &[]);
        unreadable(&case.system, &records[0])
    }

    #[test]
    fn a_sensor_that_shows_nothing_is_a_mistake() {
        let kind = |found: Option<DataError>| match found {
            None => "fine",
            Some(DataError::DelayBeyondRecord { .. }) => "late",
            Some(DataError::FilterBetweenSamples { .. }) => "fast",
            Some(_) => "other",
        };
        let table = [
            ("", "fine"),
            ("delay: 5.9", "fine"),
            ("delay: 6.0", "late"),
            ("delay: -50.0", "late"),
            // Two poles at 700 Hz settle in 0.45 ms, at 900 Hz in 0.35 ms; a tenth of a sample is 0.4 ms.
            (r#"lowpass: (order: 2, cutoff: (700.0, "Hz"))"#, "fine"),
            (r#"lowpass: (order: 2, cutoff: (900.0, "Hz"))"#, "fast"),
            (r#"highpass: (order: 2, cutoff: (900.0, "Hz"))"#, "fine"),
        ];
        for (sensor, due) in table {
            assert_eq!(kind(mistake("rate(v)", sensor)), due, "{sensor}");
        }
    }

    #[test]
    fn a_column_that_is_no_number_is_told_with_its_time() {
        let found = mistake("g*sqrt(x/h)", "");
        // The cosine of 3 t is negative after a quarter of its period.
        let due = std::f64::consts::PI / 6.0;
        assert!(
            matches!(&found, Some(DataError::NotANumber { time, .. }) if (time - due).abs() < 0.004),
            "{found:?}"
        );
    }
}
