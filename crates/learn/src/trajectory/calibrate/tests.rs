//! On a line the fit is a regression by hand; what a trial may cost and where another start lies can be
//! written down too.

use super::*;
use crate::line_models::{STEP, lever, leverage, records, scatter};
use crate::linear::covariance;
use crate::step::onestep::tests::common;
use approx::assert_relative_eq;
use phisindy_phys::Case;

/// A slope that may move.
const LINE: &str = r#"constants: {"c": (value: 0.3, within: (-9.0, 9.0))}, states: {"x": ""}, known: {"x": "c"}, unknown: {}"#;
const SAMPLES: usize = 200;
const SIGMA: f64 = 0.1;

/// Slope 0.5 and noise.
fn line() -> Vec<f64> {
    scatter(SAMPLES).iter().enumerate().map(|(i, e)| 2.0 + 0.5 * STEP * i as f64 + SIGMA * e).collect()
}

/// Slope, and sum of the squares that are left.
fn regression(samples: &[f64]) -> (f64, f64) {
    let n = samples.len() as f64;
    let (mean, middle) = (samples.iter().sum::<f64>() / n, 0.5 * (n - 1.0));
    let of = |i: usize| STEP * (i as f64 - middle);
    let slope = samples.iter().enumerate().map(|(i, x)| of(i) * x).sum::<f64>() / lever(samples.len());
    let left = samples.iter().enumerate().map(|(i, x)| (x - mean - slope * of(i)).powi(2)).sum();
    (slope, left)
}

/// Sum of the squared distances from the mean.
fn spread(samples: &[f64]) -> f64 {
    let mean = samples.iter().sum::<f64>() / samples.len() as f64;
    samples.iter().map(|x| (x - mean).powi(2)).sum()
}

fn problem<'a>(case: &'a Case, records: &'a [Record], pieces: usize) -> (Problem<'a>, Noise) {
    let noise = vec![vec![ColumnNoise { additive: SIGMA, relative: 0.0 }; case.system.states.len()]];
    (Problem::new(&case.system, &[], &[&records[0]], &[pieces]).unwrap(), noise)
}

/// The first record is to validate: it moves nothing. What is left of the second one is noise, or a wave
/// beside it that makes its samples count as few.
#[test]
fn a_line_is_calibrated_by_regression() {
    let wave = line().iter().enumerate().map(|(i, x)| x + 0.3 * (0.5 * STEP * i as f64).sin()).collect();
    let other: Vec<f64> = (0..SAMPLES).map(|i| -0.2 * STEP * i as f64).collect();
    let noise = [vec![7.0], vec![SIGMA]];
    for (samples, white) in [(line(), true), (wave, false)] {
        let (case, records) = records(LINE, &[(Role::Validate, other.clone()), (Role::Fit, samples.clone())]);
        let (slope, left) = regression(&samples);
        for effort in [Effort::Plain, Effort::Thorough, Effort::Errors] {
            let found = calibrate(&case.system, &records, &records, &noise, effort).unwrap();
            assert_relative_eq!(found.chi2, left / (SIGMA * SIGMA), max_relative = 1e-6);
            assert_eq!((found.samples, found.moved, found.segments), (SAMPLES, 1, 1));
            let part = found.effective / SAMPLES as f64;
            assert!(part <= 1.0 && if white { part > 0.6 } else { part < 0.5 }, "{part}");
            let Estimate { value, std_error, ci95 } = found.parameters[0].estimate;
            assert_relative_eq!(value, slope, max_relative = 1e-6);
            if effort == Effort::Errors {
                // Sandwich: each sample counts by what a line without it leaves of it.
                let (n, middle) = (SAMPLES as f64, 0.5 * (SAMPLES - 1) as f64);
                let mean = samples.iter().sum::<f64>() / n;
                let of = |i: usize| STEP * (i as f64 - middle);
                let left = |(i, x): (usize, &f64)| (x - mean - slope * of(i)) / (1.0 - leverage(i, SAMPLES));
                let meat = |s: (usize, &f64)| (of(s.0) * left(s)).powi(2);
                let error = samples.iter().enumerate().map(meat).sum::<f64>().sqrt() / lever(SAMPLES);
                let stretch = crate::trajectory::tally::inflation(SAMPLES, found.effective);
                assert_relative_eq!(std_error, error * stretch.sqrt(), max_relative = 1e-4);
                assert_relative_eq!(ci95.0, value - 1.96 * std_error, max_relative = 1e-3);
                assert_relative_eq!(ci95.1, value + 1.96 * std_error, max_relative = 1e-3);
            } else {
                assert!(std_error.is_nan());
                assert_eq!(ci95, (-9.0, 9.0));
            }
            let roles: Vec<Role> = found.records.iter().map(|r| r.role).collect();
            assert_eq!(roles, [Role::Validate, Role::Fit]);
            let nrmse = (left / spread(&samples)).sqrt();
            assert_relative_eq!(found.records[1].nrmse[0].1, nrmse, max_relative = 1e-6);
        }
    }
}

/// A start for each of twenty segments and one slope for all of them; for single runs one start.
#[test]
fn a_look_counts_what_it_looked_at() {
    let still = r#"states: {"x": ""}, known: {"x": "0"}, unknown: {}"#;
    let (case, records) =
        records(still, &[(Role::Fit, line()), (Role::Validate, line()), (Role::Fit, line())]);
    let noise = vec![vec![SIGMA]; 3];
    let pieces: Vec<f64> = line().chunks(10).map(spread).collect();
    for stride in [1, 2, 3] {
        // Of both records, one after the other.
        let seen: Vec<f64> = pieces.iter().chain(&pieces).copied().step_by(stride).collect();
        let due = seen.iter().sum::<f64>() / (SIGMA * SIGMA * 10.0 * seen.len() as f64);
        let found = segment_cost(&case.system, &records, &records, &noise, stride).unwrap();
        assert_relative_eq!(found, due, max_relative = 1e-6);
    }
    assert_eq!(
        segment_cost(&case.system, &records, &records, &noise, 0),
        segment_cost(&case.system, &records, &records, &noise, 1)
    );
    let found = single_run_cost(&case.system, &records, &records, &noise).unwrap();
    assert_relative_eq!(found, spread(&line()) / (SIGMA * SIGMA * SAMPLES as f64), max_relative = 1e-6);
}

/// A growth of `e^2` in a second: no single run of twenty, but pieces of four. What grows a thousand times as
/// fast is refused.
#[test]
fn what_no_single_run_can_follow_is_calibrated_in_pieces() {
    for (growth, pieces) in [("2*x", Some(5)), ("2000*x", None)] {
        let text = format!(r#"states: {{"x": ""}}, known: {{"x": "{growth}"}}, unknown: {{}}"#);
        let (case, records) = records(&text, &[(Role::Fit, line())]);
        let noise = [vec![SIGMA]];
        for effort in [Effort::Plain, Effort::Thorough, Effort::Errors] {
            let found = calibrate(&case.system, &records, &records, &noise, effort);
            assert_eq!(found.as_ref().ok().map(|f| f.segments), pieces);
            assert!(found.is_ok_and(|f| f.chi2 > 0.0) || pieces.is_none());
        }
        assert_eq!(segment_cost(&case.system, &records, &records, &noise, 1).is_some(), pieces.is_some());
        assert_eq!(single_run_cost(&case.system, &records, &records, &noise), None);
    }
}

#[test]
fn a_model_with_memory_gets_fewer_steps() {
    let steps = |states: &str, known: &str, pieces: usize| {
        let text = format!(r#"states: {{{states}}}, known: {{{known}}}, unknown: {{}}"#);
        let (case, records) = records(&text, &[(Role::Fit, line())]);
        budget(&problem(&case, &records, pieces).0)
    };
    // A place and its speed; with a memory of the speed beside them; a place alone.
    let (swing, known) = (r#""x": "", "v": """#, r#""x": "v", "v": "-x""#);
    assert_eq!(steps(swing, known, 1), 1_000 + 12 * SAMPLES);
    assert_eq!(steps(swing, known, 3), 1_000 + 12 * 67);
    assert_eq!(
        steps(&format!(r#"{swing}, "z": """#), &format!(r#"{known}, "z": "v - z""#), 1),
        1_000 + 4 * SAMPLES
    );
    assert_eq!(steps(r#""x": """#, r#""x": "1""#, 1), 1_000 + 12 * SAMPLES);
}

#[test]
fn a_simulation_is_small_against_the_noise_that_is_least() {
    let (case, records) = records(LINE, &[(Role::Fit, line())]);
    let (mut problem, _) = problem(&case, &records, 1);
    problem.scale = vec![5.0];
    let noise = |additive: f64| vec![vec![ColumnNoise { additive, relative: 0.0 }]];
    let of = |additive: f64| rough_tolerance(&problem, &noise(additive));
    assert_relative_eq!(of(0.1), 0.5 * 0.1 / 5.0 / SAMPLES as f64, max_relative = 1e-12);
    assert_eq!((of(1e-9), of(1e9)), (TOLERANCE, 1e-3));
}

/// Twice the error, that of the misfit, for the first two starts, four times for the next ones; not all
/// unknowns the same way.
#[test]
fn another_start_is_as_far_as_the_errors() {
    let spec = r#"constants: {"c": (value: 0.3, within: (-9.0, 9.0)), "e": (value: 0.0, within: (-9.0, 1e-4))},
                  states: {"x": "", "z": ""}, known: {"x": "c + e*t", "z": "0"}, unknown: {}"#;
    let (case, records) = records(spec, &[(Role::Fit, line())]);
    let (problem, noise) = problem(&case, &records, 1);
    let weights = problem.weights(&noise, None);
    let at = |offset: f64| [0.5, 0.0, 2.0 + offset, 3.0];
    let x = at(0.2);
    let normal = problem.normal(&x, &weights).unwrap();
    let ratio = normal.cost / SAMPLES as f64;
    let cov = covariance(&normal.matrix);
    let mut ways = vec![];
    for attempt in 0..4 {
        let start = nearby(&problem, &x, &weights, SAMPLES, attempt).unwrap();
        for k in 0..3 {
            let reach = f64::from(2 + 2 * (attempt / 2)) * (cov[(k, k)] * ratio).sqrt();
            let (low, high) = problem.bounds[k];
            let due = [x[k] - reach, x[k] + reach].map(|v| v.clamp(low, high));
            assert!(due.iter().any(|v| (v - start[k]).abs() < 1e-9), "{k}: {} of {due:?}", start[k]);
        }
        // Nothing shows where this one is.
        assert_eq!(start[3], 3.0);
        ways.push(start.iter().zip(&x).map(|(a, b)| a > b).collect::<Vec<_>>());
    }
    assert!(ways.iter().any(|way| way[..3].contains(&true) && way[..3].contains(&false)), "{ways:?}");
    assert!((0..3).all(|k| ways.iter().any(|way| way[k]) && ways.iter().any(|way| !way[k])), "{ways:?}");
    // Nothing but noise, and hopelessly wrong.
    assert_eq!(nearby(&problem, &at(0.0), &weights, SAMPLES, 0), None);
    assert_eq!(nearby(&problem, &at(0.9), &weights, SAMPLES, 0), None);
}

/// A rate `c^2 + c/5` of 1.2 is met at 1; on the other side the bound is reached at 0.8.
#[test]
fn the_better_of_two_ends_is_kept() {
    let spec = r#"constants: {"c": (value: 1.0, within: (-1.0, 3.0))}, states: {"x": ""}, known: {"x": "c^2 + 0.2*c"}, unknown: {}"#;
    let samples: Vec<f64> =
        scatter(SAMPLES).iter().enumerate().map(|(i, e)| 1.2 * STEP * i as f64 + SIGMA * e).collect();
    let (case, records) = records(spec, &[(Role::Fit, samples)]);
    let (problem, noise) = problem(&case, &records, 1);
    let weights = problem.weights(&noise, None);
    let cost = |x: &[f64]| problem.normal(x, &weights).unwrap().cost;
    let after = |from: [f64; 2], start: [f64; 2]| {
        let (x, cost, most) = (from.to_vec(), cost(&from), f64::INFINITY);
        let mut best = Best { problem: &problem, weights: &weights, samples: SAMPLES, most, x, cost };
        best.try_start(start.to_vec());
        best.x
    };
    let found = after([0.9, 0.0], [0.95, 0.1]);
    assert!((found[0] - 1.0).abs() < 0.01 && cost(&found) < SAMPLES as f64, "{found:?}");
    // The far end is better than a bad start, and worse than a good one.
    assert_eq!(after([0.6, 0.0], [-0.9, 0.0])[0], -1.0);
    assert_eq!(after([0.93, 0.0], [-0.9, 0.0]), [0.93, 0.0]);
    // What costs too much is not tried, nor is anything where there is only noise.
    let now = [1.0, 0.3];
    let (near, beyond) = ([1.0, 1.5], [1.0, 1.9]);
    assert!(cost(&near) < RESTART_PROMISE * cost(&now) && RESTART_PROMISE * cost(&now) < cost(&beyond));
    assert!((after(now, near)[1]).abs() < 0.1);
    assert_eq!(after(now, beyond), now);
    assert_eq!(after([1.0, 0.0], near), [1.0, 0.0]);
}

#[test]
fn a_run_that_starts_astray_is_put_on_the_data() {
    let text = r#"(states: { "x": "m", "v": "m/s" }, constants: { "k": (4.0, "1/s^2") }, known: { "x": "v", "v": "-k*x" }, unknown: {},
        data: [ Synthetic(truth: {}, start: { "x": 2.0, "v": 0.5 }, duration: 5.0, step: 0.01, noise: Additive(0), seed: 1) ])"#;
    let (case, records) = common::load_text(text, &[]);
    let Setup { fitted, noise, smooth, .. } = Setup::new(&records, &records, &[vec![0.01, 0.01]]);
    let problem = Problem::new(&case.system, &[], &fitted, &[1]).expect("a problem");
    assert_eq!(on_the_data(&problem, &[2.03, 0.47], &noise, &smooth), None);
    for elsewhere in [[2.05, 0.5], [2.0, 0.4]] {
        let start = on_the_data(&problem, &elsewhere, &noise, &smooth).expect("another start");
        assert!((start[0] - 2.0).abs() < 1e-3 && (start[1] - 0.5).abs() < 1e-3, "{start:?}");
    }
}

/// A line has the slope of a parabola nowhere but at one place: segments tell so, and a few steps tell how
/// far behind it is. What segments do not rule out is fitted as ever, and from where segments ended too.
#[test]
fn a_rival_that_segments_rule_out_is_given_up() {
    let parabola = line().iter().enumerate().map(|(i, x)| x + 4e-4 * (i as f64 - 100.0).powi(2)).collect();
    let noise = [vec![SIGMA]];
    for (samples, hopeless) in [(line(), false), (parabola, true)] {
        let (case, records) = records(LINE, &[(Role::Fit, samples)]);
        let of = |effort: Effort| calibrate(&case.system, &records, &records, &noise, effort).unwrap();
        let (plain, rival) = (of(Effort::Plain), of(Effort::Rival { most: 2.0, runs: true }));
        assert_eq!((plain.hopeless, rival.hopeless), (false, hopeless));
        assert_relative_eq!(plain.chi2, rival.chi2, max_relative = 1e-6);
        let segments = segment_fit(&case.system, &records, &records, &noise, 1);
        let from = calibrate_from(
            segments.as_ref(),
            &case.system,
            &records,
            &records,
            &noise,
            Effort::Plain,
            &Stop::default(),
        );
        assert_relative_eq!(plain.chi2, from.unwrap().chi2, max_relative = 1e-6);
    }
}
