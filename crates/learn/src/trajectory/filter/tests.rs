//! The filter beside that of a textbook on a spring, whose motion has a closed form; its derivatives by
//! differences; a contact that sticks.

use crate::line_models::{STEP, records, scatter};
use crate::trajectory::noise::ColumnNoise;
use crate::trajectory::problem::{Noise, Problem};
use crate::trajectory::random_force::RandomForce;
use approx::assert_relative_eq;
use faer::Mat;
use phisindy_phys::spec::Role;
use phisindy_phys::{Case, Record, SensorParameter};

const SAMPLES: usize = 80;
const SPRING: f64 = 1.2;
const DAMPER: f64 = 0.7;

/// Place and speed of a damped spring, both measured.
fn spring() -> (Case, Vec<Record>) {
    let column = |turn: f64| -> Vec<f64> {
        scatter(SAMPLES).iter().enumerate().map(|(i, e)| (0.6 * i as f64 + turn).cos() + 0.05 * e).collect()
    };
    let (case, mut records) = records(
        r#"states: {"x": "", "v": ""}, known: {"x": "v", "v": "-k*x - c*v"}, unknown: {"v": (factor: "1", candidates: ["1"])},
           constants: {"k": (value: 1.2, within: (0.5, 400.0)), "c": (value: 0.7, within: (-9.0, 9.0))}"#,
        &[(Role::Fit, column(0.0))],
    );
    records[0].columns[1] = Some(column(1.5).iter().map(|v| 5.0 * v).collect());
    (case, records)
}

fn noise() -> Noise {
    vec![vec![ColumnNoise { additive: 0.06, relative: 0.0 }, ColumnNoise { additive: 0.4, relative: 0.02 }]]
}

fn force(intensity: f64) -> RandomForce {
    RandomForce { groups: vec![vec![(1, 1.0)]], intensities: vec![vec![intensity]] }
}

fn problem<'a>(case: &'a Case, records: &'a [Record]) -> Problem<'a> {
    let mut problem = Problem::new(&case.system, &[], &[&records[0]], &[1]).unwrap();
    problem.tolerance = 1e-11;
    problem
}

const X: [f64; 4] = [SPRING, DAMPER, 0.9, 0.3];

/// `exp(A h)` by its series.
fn exponential(a: &Mat<f64>) -> Mat<f64> {
    let n = a.nrows();
    let (mut sum, mut term) = (Mat::identity(n, n), Mat::identity(n, n));
    for k in 1..40 {
        term = &term * a * (1.0 / k as f64);
        sum += &term;
    }
    sum
}

/// Twice the negative logarithm of the likelihood of the spring's readings: the textbook's filter with Van Loan's
/// covariance of the force (IEEE Trans. Autom. Control 23 (1978) 395-404), both readings at once.
fn textbook(record: &Record, intensity: f64) -> f64 {
    let a = Mat::from_fn(2, 2, |i, j| [[0.0, 1.0], [-SPRING, -DAMPER]][i][j]);
    let block = Mat::from_fn(4, 4, |i, j| match (i < 2, j < 2) {
        (true, true) => -a[(i, j)] * STEP,
        (true, false) => f64::from(u8::from((i, j) == (1, 3))) * intensity * STEP,
        (false, false) => a[(j - 2, i - 2)] * STEP,
        (false, true) => 0.0,
    });
    let loan = exponential(&block);
    let phi = Mat::from_fn(2, 2, |i, j| loan[(2 + j, 2 + i)]);
    let q = &phi * Mat::from_fn(2, 2, |i, j| loan[(i, 2 + j)]);
    let mut x = Mat::from_fn(2, 1, |i, _| X[2 + i]);
    let mut p: Mat<f64> = Mat::zeros(2, 2);
    let mut sum = 0.0;
    for i in 0..SAMPLES {
        if i > 0 {
            (x, p) = (&phi * &x, &phi * &p * phi.transpose() + &q);
        }
        let read = |k: usize| record.columns[k].as_ref().unwrap()[i];
        // The relative part of the noise hangs on the reading after the first column.
        for k in 0..2 {
            let noise = noise()[0][k].variance(x[(k, 0)]);
            let (variance, miss) = (p[(k, k)] + noise, read(k) - x[(k, 0)]);
            sum += variance.ln() + miss * miss / variance;
            let gain = Mat::from_fn(2, 1, |r, _| p[(r, k)] / variance);
            let row = Mat::from_fn(1, 2, |_, c| p[(k, c)]);
            x += &gain * miss;
            p -= &gain * row;
        }
    }
    sum
}

#[test]
fn the_likelihood_is_that_of_the_textbook() {
    let (case, records) = spring();
    for intensity in [1e-6, 0.02, 3.0] {
        let mut problem = problem(&case, &records);
        let (_, found) = problem.follow(&X, &noise(), &force(intensity)).unwrap();
        // Simpson's rule for the covariance of the force is right to the third power of what a step turns, 0.11
        // radians here.
        assert_relative_eq!(found, textbook(&records[0], intensity), max_relative = 2e-5);
    }
}

#[test]
fn another_force_is_as_likely_along_the_pass_as_in_a_pass_of_its_own() {
    let (case, records) = spring();
    let problem = problem(&case, &records);
    let of = |q: f64, noise: &Noise| {
        let force = force(q);
        problem.filtered(0, &X, noise, (&force.groups, &force.intensities[0])).unwrap().0
    };
    let mut flat = noise();
    flat[0][1].relative = 0.0;
    let pass = of(0.02, &flat);
    for (q, factors) in [(0.02, [1.0, 1.0]), (0.5, [1.0, 1.0]), (1e-4, [2.0, 0.7])] {
        let mut other = flat.clone();
        other[0].iter_mut().zip(factors).for_each(|(n, f): (_, f64)| n.additive *= f.sqrt());
        // The spring is linear: nothing is lost by going along the derivatives of another pass.
        let found = pass.unlikelihood_with(&[q], &factors);
        assert_relative_eq!(found, of(q, &other).unlikelihood, max_relative = 1e-9);
    }
}

/// Offset, gain and delay of one sensor and the gain of the other move the state through the corrections.
#[test]
fn the_derivatives_of_innovations_are_those_of_differences() {
    let (case, mut records) = spring();
    let free = |start: f64| SensorParameter { within: Some((-9.0, 9.0)), ..SensorParameter::fixed(start) };
    let [x, v] = &mut records[0].sensors[..] else { panic!("two states") };
    (x.offset, x.gain, v.gain) = (free(0.0), free(1.0), free(1.0));
    let mut problem = problem(&case, &records);
    let at = vec![SPRING, DAMPER, 0.05, 1.1, 0.95, 0.9, 0.3];
    let (weights, _) = problem.follow(&at, &noise(), &force(0.3)).unwrap();
    let normal = problem.normal(&at, &weights).unwrap();
    for k in 0..at.len() {
        let reach = 1e-5 * at[k].abs().max(1.0);
        let cost = |by: f64| {
            let mut there = at.clone();
            there[k] += by;
            problem.cost(&there, &weights).unwrap()
        };
        let slope = (cost(reach) - cost(-reach)) / (2.0 * reach);
        // Differences lose the rounding of a cost of some thousand over twice the reach.
        assert_relative_eq!(2.0 * normal.gradient[k], slope, max_relative = 1e-5, epsilon = 1e-4);
    }
    let scores = problem.scores(&at, &weights).unwrap();
    for k in 0..at.len() {
        let sum: f64 = scores[0].iter().map(|part| part[k]).sum();
        assert_relative_eq!(sum, normal.gradient[k], max_relative = 1e-9, epsilon = 1e-9);
    }
}

#[test]
fn without_a_force_it_is_the_free_run() {
    let (case, records) = spring();
    let mut problem = problem(&case, &records);
    let free = problem.residuals(&X).unwrap();
    problem.follow(&X, &noise(), &force(0.0)).unwrap();
    let followed = problem.residuals(&X).unwrap();
    for (a, b) in free[0].iter().zip(&followed[0]) {
        let pairs = a.residual.iter().zip(&b.residual);
        // Steps that end at the samples are others, of the same accuracy.
        pairs.for_each(|(a, b)| assert_relative_eq!(a, b, epsilon = 1e-8));
    }
}

/// A block that rests under dry friction: whatever pulls at it less than the friction holds moves nothing.
#[test]
fn a_force_below_friction_moves_nothing() {
    let (case, mut records) = records(
        r#"states: {"x": "", "v": ""}, known: {"x": "v", "v": "0.2 - 0.5*sgn(v)"}, contacts: ["v"], unknown: {}"#,
        &[(Role::Fit, scatter(SAMPLES))],
    );
    records[0].columns[1] = None;
    let problem = Problem::new(&case.system, &[], &[&records[0]], &[1]).unwrap();
    let force = force(0.1);
    let (_, gains) =
        problem.filtered(0, &[0.0, 0.0], &noise(), (&force.groups, &force.intensities[0])).unwrap();
    assert!((0..SAMPLES).all(|i| gains.at(0, i, 2)[1] == 0.0));
    // The same block on ice.
    let (case, mut records) = records_without_friction();
    records[0].columns[1] = None;
    let problem = Problem::new(&case.system, &[], &[&records[0]], &[1]).unwrap();
    let (_, gains) =
        problem.filtered(0, &[0.0, 0.0], &noise(), (&force.groups, &force.intensities[0])).unwrap();
    assert!(gains.at(0, SAMPLES - 1, 2)[1] > 0.1);
}

fn records_without_friction() -> (Case, Vec<Record>) {
    records(
        r#"states: {"x": "", "v": ""}, known: {"x": "v", "v": "0.2"}, unknown: {}"#,
        &[(Role::Fit, scatter(SAMPLES))],
    )
}
