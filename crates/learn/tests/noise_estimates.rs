//! The noise of every column is found from the data, without being told.

use crate::common;
use phisindy_learn::{Identified, LearnOptions, NoiseModel, identify};
use std::ops::ControlFlow;

fn deviation(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
}

/// Identifies case 1a under some noise; also gives the standard deviations of the clean columns.
fn found(noise: &str) -> (Identified, Vec<f64>) {
    let (_, clean) = common::load("case1a", &[("data.0.noise", "Relative(0)")]);
    let clean = clean[0].columns.iter().map(|c| deviation(c.as_ref().unwrap())).collect();
    let (case, records) = common::load("case1a", &[("data.0.noise", noise), ("data.0.seed", "11")]);
    let found = identify(&case, &records, &LearnOptions::default(), &mut |_| ControlFlow::Continue(()));
    (found.unwrap(), clean)
}

fn assert_noise(found: &Identified, expected: &[(&str, f64)]) {
    let noise = &found.records[0].noise;
    assert_eq!(noise.len(), expected.len());
    for ((name, value), (column, truth)) in noise.iter().zip(expected) {
        assert_eq!(name, column);
        assert!((value - truth).abs() < 0.05 * truth, "{name}: {value}, truth {truth}");
    }
}

/// Relative noise is stated where the signal is one standard deviation.
#[test]
fn relative() {
    for part in [0.1, 0.03] {
        let (found, clean) = found(&format!("Relative({part})"));
        assert_eq!(found.noise_model, NoiseModel::Relative);
        assert_noise(&found, &[("x", part * clean[0]), ("y", part * clean[1])]);
    }
}

#[test]
fn additive() {
    for part in [0.02, 0.2] {
        let (found, clean) = found(&format!("Additive({part})"));
        assert_eq!(found.noise_model, NoiseModel::Additive);
        assert_noise(&found, &[("x", part * clean[0]), ("y", part * clean[1])]);
    }
}

#[test]
fn of_each_sensor() {
    let (found, _) = found(r#"Sensor({"x": (5.0, "mm"), "y": (0.03, "m/s")})"#);
    assert_eq!(found.noise_model, NoiseModel::Additive);
    assert_noise(&found, &[("x", 0.005), ("y", 0.03)]);
}
