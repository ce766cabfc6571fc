//! The ends of a profile where they can be written down: the slope of a line, and a number whose square is
//! that slope.

use super::*;
use crate::line_models::{STEP, fitted, lever, records, scatter};
use approx::assert_relative_eq;
use phisindy_phys::spec::Role;
use phisindy_phys::{Case, Record};

const SIGMA: f64 = 0.3;
const SAMPLES: usize = 60;

/// `x = x0 + c t`.
fn line() -> (Case, Vec<Record>) {
    let samples = scatter(SAMPLES).iter().enumerate().map(|(i, e)| 0.2 * i as f64 + SIGMA * e).collect();
    records(
        r#"states: {"x": ""}, known: {"x": "0"}, unknown: {"x": (factor: "1", candidates: ["1"])}"#,
        &[(Role::Fit, samples)],
    )
}

/// `x = x0 + q^2 t`, and how well the square is known from samples with the noise `sigma`; the best `q` is 1
/// within rounding.
fn square(sigma: f64, within: &str) -> (Case, Vec<Record>, f64) {
    let samples = (0..SAMPLES).map(|i| 0.1 * i as f64).collect();
    let (case, records) = records(
        &format!(
            r#"constants: {{"q": (value: 0.9, within: {within})}}, states: {{"x": ""}}, known: {{"x": "q^2"}}, unknown: {{}}"#
        ),
        &[(Role::Fit, samples)],
    );
    (case, records, sigma / lever(SAMPLES).sqrt())
}

/// 95 % of a normal distribution.
const NORMAL: f64 = 1.959_964;

/// On a cost that is quadratic the interval is the one of every table.
#[test]
fn of_a_line_it_is_the_quadratic_one() {
    let (case, records) = line();
    let fit = fitted(&case, &records, SIGMA);
    let error = SIGMA / lever(SAMPLES).sqrt();
    let (low, high) = interval(&fit, 0, error, error);
    assert_relative_eq!(low, fit.x[0] - NORMAL * error, max_relative = 1e-6);
    assert_relative_eq!(high, fit.x[0] + NORMAL * error, max_relative = 1e-6);
    // A rise that is up to a fifth off is near enough: the interval is that of the error, whatever the cost
    // says.
    for part in [0.92, 1.08] {
        let (low, high) = interval(&fit, 0, part * error, part * error);
        assert_relative_eq!(high - low, 2.0 * NORMAL * part * error, max_relative = 1e-6);
    }
}

/// Where the curvature says another error than the scatter does, the rise to look for is stretched by the
/// square of their ratio.
#[test]
fn what_the_curvature_does_not_say_stretches_the_rise() {
    let (case, records) = line();
    let fit = fitted(&case, &records, SIGMA);
    let error = SIGMA / lever(SAMPLES).sqrt();
    for (scatter, curvature) in [(1.0, 2.0), (1.0, 0.25), (3.0, 12.0), (2.0, 0.6), (0.2, 0.25)] {
        let (low, high) = interval(&fit, 0, scatter * error, curvature * error);
        // The rise at a distance d is (d / error)^2, so it is 3.84 (scatter / curvature)^2 here.
        let reach = NORMAL * error * scatter / curvature;
        // Two per cent of the rise are one of the distance.
        assert_relative_eq!(fit.x[0] - low, reach, max_relative = 0.0105);
        assert_relative_eq!(high - fit.x[0], reach, max_relative = 0.0105);
    }
}

/// The interval of a square, and of its root: the ends are the roots of the ends.
#[test]
fn of_a_root_it_is_the_root_of_the_interval() {
    let (case, records, known) = square(0.3 * lever(SAMPLES).sqrt(), "(0.0, 5.0)");
    let fit = fitted(&case, &records, known * lever(SAMPLES).sqrt());
    assert_relative_eq!(fit.x[0], 1.0, max_relative = 1e-6);
    let error = known / 2.0;
    assert_relative_eq!(error, 0.15, max_relative = 1e-12);
    let (low, high) = interval(&fit, 0, error, error);
    assert_relative_eq!(high, (1.0 + NORMAL * known).sqrt(), max_relative = 3e-3);
    assert_relative_eq!(low, (1.0 - NORMAL * known).sqrt(), max_relative = 6e-3);
    // The quadratic ends are further away than that.
    assert!((1.0 + NORMAL * error - high) > 0.03 && low < 1.0 - NORMAL * error - 0.05);
}

/// Beyond its bounds a number is nowhere; where it is not known at all they are the interval.
#[test]
fn bounds_end_it() {
    let (case, records, known) = square(0.3 * lever(SAMPLES).sqrt(), "(0.8, 1.1)");
    let fit = fitted(&case, &records, known * lever(SAMPLES).sqrt());
    assert_eq!(interval(&fit, 0, known / 2.0, known / 2.0), (0.8, 1.1));
    assert_eq!(interval(&fit, 0, f64::INFINITY, f64::INFINITY), (0.8, 1.1));
    // A bound beyond the end of the interval is none.
    let (case, records, known) = square(0.3 * lever(SAMPLES).sqrt(), "(0.6, 1.2)");
    let fit = fitted(&case, &records, known * lever(SAMPLES).sqrt());
    let (low, high) = interval(&fit, 0, known / 2.0, known / 2.0);
    assert_relative_eq!(low, (1.0 - NORMAL * known).sqrt(), max_relative = 6e-3);
    assert_eq!(high, 1.2);
}

/// Without any scatter there is nothing around the number.
#[test]
fn without_an_error_it_is_a_point() {
    let (case, records) = line();
    let fit = fitted(&case, &records, SIGMA);
    assert_eq!(interval(&fit, 0, 0.0, 0.1), (fit.x[0], fit.x[0]));
}

/// A line of another slope still goes through the middle of the samples.
#[test]
fn the_others_follow_what_is_held() {
    let (case, records) = line();
    let fit = fitted(&case, &records, SIGMA);
    let samples = records[0].columns[0].as_ref().unwrap();
    let middle = samples.iter().sum::<f64>() / SAMPLES as f64;
    for slope in [0.7, 2.0, 5.5] {
        let x = followed(&fit, 0, slope);
        assert_eq!(x[0], slope);
        assert_relative_eq!(x[1], middle - slope * 0.5 * (SAMPLES - 1) as f64 * STEP, max_relative = 1e-6);
    }
}
