//! On a parabola the equations are exact: coefficients, bounds and what a subset explains can be written
//! down.

use super::*;
use crate::line_models::{STEP, records};
use approx::assert_relative_eq;
use phisindy_phys::Case;
use phisindy_phys::spec::Role;

/// `x' = 0.1 + 0.3 - 0.2 * 2 t`, of which 0.1 is known; and of another equation `z' = 0.7`.
fn parabola(within: &str) -> (Case, Vec<Record>) {
    let time = |i: usize| STEP * i as f64;
    let (case, mut records) = records(
        &format!(
            r#"states: {{"x": "", "z": ""}}, known: {{"x": "0.1", "z": "0"}},
               unknown: {{"x": (factor: "1", candidates: ["1", "2*t", "1/(t - 9.5)"], within: {{{within}}}), "z": (factor: "1", candidates: ["t^2", "1"])}}"#
        ),
        &[(Role::Fit, (0..100).map(|i| 0.4 * time(i) - 0.2 * time(i).powi(2)).collect())],
    );
    records[0].columns[1] = Some((0..100).map(|i| 0.7 * time(i)).collect());
    (case, records)
}

#[test]
fn the_regression_of_a_parabola_is_exact() {
    let (case, records) = parabola("");
    let all = Regression::new(&case.system, &records, &[]);
    assert_eq!(all.singular, [2]);
    let found = all.solve(&[0, 1, 4]);
    // But for the damping.
    for (found, due) in found.iter().zip([0.3, -0.2, 0.7]) {
        assert_relative_eq!(*found, due, max_relative = 1e-3);
    }
    // In the order in which they are asked for.
    assert_relative_eq!(all.solve(&[4, 1, 0])[0], 0.7, max_relative = 1e-4);
    // What is explained is what the left sides have: three stretches of 25 samples, each of which moves by
    // 0.7
    // * 2.5 in z.
    let power = 3.0 * (0.7 * 2.5_f64).powi(2);
    assert_relative_eq!(all.explained(&[4]), power, max_relative = 1e-4);
    assert!(all.explained(&[3]) < 0.9 * power);
    assert_relative_eq!(all.explained(&[0, 4]), all.explained(&[0]) + power, max_relative = 1e-4);
}

/// The others are solved again beside what stays at a bound.
#[test]
fn a_coefficient_stays_within_its_bounds() {
    for (within, held) in [((-0.1, 9.0), Some(-0.1)), ((-9.0, -0.3), Some(-0.3)), ((-9.0, 9.0), None)] {
        let (case, records) = parabola(&format!(r#""2*t": {within:?}"#));
        let found = Regression::new(&case.system, &records, &[]).solve(&[0, 1]);
        assert_relative_eq!(found[1], held.unwrap_or(-0.2), max_relative = 1e-3);
        // Normal equation of the level: stretch by stretch, the integral of 2 t over it.
        let ends = [(0.0, 2.5), (2.5, 5.0), (5.0, 7.5)];
        let (mut top, mut bottom) = (0.0, 0.0);
        for (a, b) in ends {
            let left = 0.3 * (b - a) - (0.2 + found[1]) * (b * b - a * a);
            (top, bottom) = (top + (b - a) * left, bottom + (b - a) * (b - a));
        }
        assert_relative_eq!(found[0], top / bottom, max_relative = 1e-3);
    }
}

#[test]
fn terms_are_ranked_equation_by_equation() {
    let (case, records) = parabola("");
    let all = Regression::new(&case.system, &records, &[]);
    // The three stretches move by -0.5, -3 and -5.5, integrals are as here (the last one by logarithms, to
    // what the trapezoidal rule can do).
    let moved = [-0.5, -3.0, -5.5];
    let rows = [[2.5; 3], [6.25, 18.75, 31.25], [7.0 / 9.5, 4.5 / 7.0, 2.0 / 4.5].map(f64::ln)];
    let dot = |a: &[f64; 3], b: &[f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let alone = rows.map(|row| dot(&row, &moved).powi(2) / dot(&row, &row));
    assert!(alone[1] > alone[2] && alone[2] > alone[0]);
    for (k, due) in alone.into_iter().enumerate() {
        assert_relative_eq!(all.explained(&[k]), due, max_relative = 1e-3);
    }
    assert_eq!(all.single(&case.system, 0), [1, 4]);
    assert_eq!(all.single(&case.system, 1), [2, 3]);
    // Beyond the last one of the second equation.
    assert_eq!(all.single(&case.system, 2), [0, 3]);
    assert_eq!(all.best(&case.system, 1), [1, 4]);
    assert_eq!(all.best(&case.system, 2), [0, 1, 3, 4]);
    assert_eq!(all.best(&case.system, 0), [0; 0]);
}

/// Neither through a turn nor while it is slow, nor over more than 25 samples, nor over fewer than five.
#[test]
fn a_stretch_goes_one_way() {
    let ways = |runs: &[(f64, usize)]| -> Vec<f64> {
        runs.iter().flat_map(|&(v, n)| std::iter::repeat_n(v, n)).collect()
    };
    let steady = vec![1.0; 60];
    assert_eq!(stretches(&[], 60), [(0, 25), (25, 50)]);
    assert_eq!(stretches(std::slice::from_ref(&steady), 60), [(0, 25), (25, 50)]);
    let turned = ways(&[(1.0, 12), (-1.0, 20), (-0.01, 8), (1.0, 5), (-1.0, 15)]);
    assert_eq!(stretches(std::slice::from_ref(&turned), 60), [(0, 11), (12, 31)]);
    assert_eq!(stretches(&[steady, turned], 60), [(0, 11), (12, 31)]);
    // A twentieth of the rms speed is slow.
    let root = |v: f64| stretches(&[ways(&[(1.0, 30), (v, 30)])], 60).len();
    assert_eq!((root(0.06), root(0.03)), (2, 1));
}

/// A speed without a column is the slope of its place.
#[test]
fn a_smoothed_record_has_its_velocities() {
    let samples = (0..100).map(|i| (0.5 * STEP * i as f64).sin()).collect();
    let (case, records) = records(
        r#"states: {"x": "", "v": "", "z": ""}, known: {"x": "v", "v": "0", "z": "0"}, unknown: {}"#,
        &[(Role::Fit, samples)],
    );
    let smooth = smoothed(&case.system, &records[0]);
    let speed = smooth.columns[1].as_ref().unwrap();
    assert_relative_eq!(speed[50], 0.5 * (0.5 * STEP * 50.0).cos(), epsilon = 1e-3);
    assert!(smooth.columns[2].is_none());
    let mut measured = records[0].clone();
    measured.columns[1] = Some(vec![3.0; 100]);
    let speed = smoothed(&case.system, &measured).columns[1].clone().unwrap();
    assert_relative_eq!(speed[50], 3.0, epsilon = 1e-6);
}

/// A rate breaks where the argument of a sign or a step changes sign, in what is known as in a term.
#[test]
fn whatever_has_a_sign_breaks_a_stretch() {
    let (case, mut records) = records(
        r#"states: {"x": "", "v": ""}, known: {"x": "v", "v": "-0.2*sgn(v)"}, unknown: {"v": (factor: "1", candidates: ["step(x - 2)", "v^2"])}"#,
        &[(Role::Fit, (0..50).map(f64::from).collect())],
    );
    records[0].columns[1] = Some((0..50).map(|i| 10.0 - f64::from(i)).collect());
    let values = evaluate(&case.system, &[0, 1], &records[0], &[]).unwrap();
    let mut breaks: Vec<[f64; 2]> = values.contacts.iter().map(|w| [w[0], w[30]]).collect();
    breaks.sort_by(|a, b| a[0].total_cmp(&b[0]));
    assert_eq!(breaks, [[-2.0, 28.0], [10.0, -20.0]]);
    assert_eq!([values.terms[0][0], values.terms[0][30], values.terms[1][30]], [0.0, 1.0, 400.0]);
    assert_eq!([values.known[0][30], values.known[1][30]], [-20.0, 0.2]);
}
