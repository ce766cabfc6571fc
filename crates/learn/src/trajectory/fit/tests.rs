//! On a line a fit is a regression, whatever it is cut into; the counts of what is left are sums.

use super::*;
use crate::line_models::{STEP, fitted_terms, lever, records, scatter};
use crate::trajectory::noise::ColumnNoise;
use crate::trajectory::problem::ColumnResidual;
use approx::assert_relative_eq;
use phisindy_phys::Case;
use phisindy_phys::spec::Role;
use phisindy_signal::effective_samples;
use phisindy_signal::standard_deviation;

/// A level and a slope of the rate of `x`.
const LINE: &str =
    r#"states: {"x": ""}, known: {"x": "0"}, unknown: {"x": (factor: "1", candidates: ["1", "2*t"])}"#;
const SAMPLES: usize = 100;
const SIGMA: f64 = 0.1;

fn line(slope: f64) -> Vec<f64> {
    scatter(SAMPLES).iter().enumerate().map(|(i, e)| 2.0 + slope * STEP * i as f64 + SIGMA * e).collect()
}

fn context<'a>(case: &'a Case, records: &'a [Record], segments: SegmentsSpec) -> Context<'a> {
    Context {
        system: &case.system,
        records: records.iter().collect(),
        smooth: records.to_vec(),
        segments,
        stop: Stop::default(),
    }
}

/// Slope, and the mean square of what is left.
fn regression(samples: &[f64]) -> (f64, f64) {
    let (n, mean) = (samples.len() as f64, samples.iter().sum::<f64>() / samples.len() as f64);
    let of = |i: usize| STEP * (i as f64 - 0.5 * (n - 1.0));
    let slope = samples.iter().enumerate().map(|(i, x)| of(i) * x).sum::<f64>() / lever(samples.len());
    let left = samples.iter().enumerate().map(|(i, x)| (x - mean - slope * of(i)).powi(2)).sum::<f64>();
    (slope, left / n)
}

#[test]
fn correlated_residuals_stretch_an_error_and_a_little_does_not() {
    assert_eq!((inflation(100, 80.0), inflation(100, 50.0), inflation(100, 0.1)), (1.0, 2.0, 100.0));
    assert_eq!(inflation(130, 100.0), 1.3);
}

#[test]
fn residuals_are_counted_in_units_of_their_noise() {
    let column = |residual: &[f64]| ColumnResidual {
        residual: residual.to_vec(),
        prediction: (0..residual.len()).map(|i| i as f64).collect(),
    };
    let slow: Vec<f64> = (0..64).map(|i| (0.2 * f64::from(i)).sin()).collect();
    let residuals = vec![vec![column(&[3.0, 4.0, -10.0]), column(&[])], vec![column(&slow), column(&[6.0])]];
    let one = |additive, relative| ColumnNoise { additive, relative };
    let noise = vec![vec![one(1.0, 2.0), one(1.0, 0.0)], vec![one(0.5, 0.0), one(3.0, 0.0)]];
    let Tally { samples, effective, power } = tally(&noise, &residuals);
    // Variances 1, 5 and 17; 0.25; 9.
    let slow_power = slow.iter().map(|e| 4.0 * e * e).sum::<f64>();
    assert_relative_eq!(power, 9.0 + 16.0 / 5.0 + 100.0 / 17.0 + slow_power + 4.0, max_relative = 1e-12);
    assert_eq!(samples, 3 + 64 + 1);
    assert_relative_eq!(effective, 3.0 + effective_samples(&slow) + 1.0, max_relative = 1e-12);
}

/// Parameters and sensors keep their meaning where terms come and go and records are cut otherwise;
/// coefficients and starts are left alone.
#[test]
fn what_means_the_same_is_carried_over() {
    let (case, mut records) = records(
        r#"constants: {"c": (value: 0.3, within: (-9.0, 9.0)), "e": (value: 0.0, within: (-9.0, 9.0), each: true)},
           states: {"x": ""}, known: {"x": "c + e"}, unknown: {"x": (factor: "1", candidates: ["1", "2*t"])}"#,
        &[(Role::Fit, line(0.5)), (Role::Fit, line(0.5))],
    );
    records[1].sensors[0].gain.within = Some((0.5, 2.0));
    let both: Vec<&Record> = records.iter().collect();
    let from = Problem::new(&case.system, &[0, 1], &both, &[2, 1]).unwrap();
    let to = Problem::new(&case.system, &[1], &both, &[1, 3]).unwrap();
    // Two coefficients, c, e and two starts of the first, e, gain and a start of the second record.
    let x: Vec<f64> = (0..9).map(|k| 10.0 + f64::from(k)).collect();
    let mut y = vec![-1.0; to.unknowns];
    transfer(&from, &x, &to, &mut y);
    assert_eq!(y, [-1.0, 12.0, 13.0, -1.0, 16.0, 17.0, -1.0, -1.0, -1.0]);
}

#[test]
fn a_fit_is_the_regression_and_its_noise_what_is_left() {
    let (case, records) = records(LINE, &[(Role::Fit, line(0.5)), (Role::Fit, line(0.5))]);
    let (slope, left) = regression(&line(0.5));
    let level = noise_level(&scatter(SAMPLES).iter().map(|e| SIGMA * e).collect::<Vec<_>>());
    for segments in [SegmentsSpec::Auto, SegmentsSpec::Count(1)] {
        let context = context(&case, &records, segments);
        let fit = context.fresh_fit(&[0], &[0.1]).unwrap();
        assert_eq!(fit.pieces, [1, 1]);
        assert_relative_eq!(fit.x[0], slope, max_relative = 1e-6);
        for noise in &fit.noise {
            // A relative part explains a little of what is left by chance.
            assert_relative_eq!(noise[0].additive, left.sqrt(), max_relative = 0.1);
        }
        assert_eq!(fit.samples, 2 * SAMPLES);
        assert!(fit.is_white() && fit.inflation() == 1.0 && fit.effective <= fit.samples as f64);
        assert_relative_eq!(fit.excess, left / level.powi(2), max_relative = 0.1);
        assert!(fit.chance_of_noise() > 0.05);
        let size = standard_deviation(&line(0.5));
        assert_relative_eq!(context.misfit(&fit).unwrap(), left.sqrt() / size, max_relative = 1e-5);
        // A rate that grows is the regression of the same data on a parabola, with a noise of its own.
        let other = context.refit(&fit, &[1]).unwrap();
        assert_eq!((other.x.len(), other.samples, &other.pieces), (3, fit.samples, &fit.pieces));
        assert_eq!(other.noise, fit.noise);
        assert!(other.normal.cost > 5.0 * fit.normal.cost && !context.resettle(other).is_white());
    }
    let cut = context(&case, &records, SegmentsSpec::Count(4)).fresh_fit(&[0], &[0.1]).unwrap();
    assert_eq!((cut.pieces.clone(), cut.most_pieces()), (vec![4, 4], 4));
}

/// What a selection compares: the cost of other terms with the noise of the first fit.
#[test]
fn a_refit_of_other_terms_has_the_cost_of_their_regression() {
    let bent: Vec<f64> =
        line(0.5).iter().enumerate().map(|(i, x)| x + 0.02 * (STEP * i as f64).powi(2)).collect();
    let (case, records) = records(LINE, &[(Role::Fit, bent)]);
    let context = context(&case, &records, SegmentsSpec::Auto);
    let full = fitted_terms(&case, &records, SIGMA, &[0, 1]);
    let cost = |terms: &[usize]| fitted_terms(&case, &records, SIGMA, terms).normal.cost;
    for terms in [&[0][..], &[1], &[0, 1], &[]] {
        let refit = context.refit(&full, terms).unwrap();
        assert_relative_eq!(refit.normal.cost, cost(terms), max_relative = 1e-5);
        assert_eq!(refit.problem.terms, terms);
        // Ten times the cost is given up, and still seen to be too much.
        let trial_fit = context.trial_fit(&full, terms, &[]).unwrap();
        assert!(trial_fit.normal.cost >= refit.normal.cost * (1.0 - 1e-9));
    }
    let mut poor = context.refit(&full, &[0]).unwrap();
    let rich = context.richer(&poor, &[0, 1]).unwrap();
    assert_relative_eq!(rich.x[0], full.x[0], max_relative = 1e-3);
    assert_relative_eq!(rich.x[1], full.x[1], max_relative = 1e-3);
    // The noise is found anew: what is left scatters by it.
    assert_relative_eq!(rich.normal.cost, SAMPLES as f64, max_relative = 0.01);
    poor.x[0] += 0.05;
    let again = context.resettle(poor);
    assert_relative_eq!(again.normal.cost, SAMPLES as f64, max_relative = 0.05);
    // All of it is taken over: the cost is that of its unknowns and weights, the noise that of what is left.
    let cost = again.problem.normal(&again.x, &again.weights).unwrap().cost;
    assert_relative_eq!(again.normal.cost, cost, max_relative = 1e-12);
    let residuals = again.problem.residuals(&again.x).unwrap();
    let power = tally(&again.noise, &residuals).power;
    assert_relative_eq!(power, SAMPLES as f64, max_relative = 0.05);
}

/// Each of twenty pieces begins at its first sample.
#[test]
fn a_sketch_fits_nothing() {
    let (case, records) = records(LINE, &[(Role::Fit, line(0.5))]);
    let context = context(&case, &records, SegmentsSpec::Auto);
    let samples = line(0.5);
    let size = standard_deviation(&samples);
    for slope in [0.5, -0.2] {
        let miss = |i: usize| samples[i / 5 * 5] + slope * STEP * (i % 5) as f64 - samples[i];
        let due = ((0..SAMPLES).map(|i| miss(i).powi(2)).sum::<f64>() / SAMPLES as f64).sqrt() / size;
        assert_relative_eq!(context.misfit_of_guess(&[0], &[slope]).unwrap(), due, max_relative = 1e-6);
    }
}

/// Where the spec starts at the deepest of many minima, a fit that ended in another one goes back; where it
/// starts far away, not.
#[test]
fn a_known_model_never_ends_above_where_its_spec_starts() {
    let due = 30.0 / STEP / SAMPLES as f64;
    let wave = |i: usize| 2.0 + (due * STEP * i as f64).sin();
    let samples: Vec<f64> =
        scatter(SAMPLES).iter().enumerate().map(|(i, e)| wave(i) + 0.1 * SIGMA * e).collect();
    for (start, back) in [(due, true), (1.5 * due, false)] {
        let (case, records) = records(
            &format!(
                r#"constants: {{"w": (value: {start:?}, within: (0.1, 90.0))}}, states: {{"x": ""}}, known: {{"x": "w*cos(w*t)"}}, unknown: {{}}"#
            ),
            &[(Role::Fit, samples.clone())],
        );
        let auto = context(&case, &records, SegmentsSpec::Auto);
        let problem = Problem::new(&case.system, &[], &auto.records, &[1]).unwrap();
        let mut x = problem.guess(&[], None, &records);
        let w = problem
            .meanings()
            .iter()
            .position(|m| matches!(m, crate::trajectory::problem::Meaning::Parameter(..)))
            .unwrap();
        x[w] = 1.3 * due;
        let noise = problem.first_noise();
        let astray = auto.settle(problem, x, noise, 3).unwrap();
        assert!((astray.x[w] / due - 1.0).abs() > 0.05, "{}", astray.x[w] / due);
        let straight = auto.straight(&astray);
        assert_eq!(straight.is_some(), back);
        if let Some(fit) = straight {
            assert_relative_eq!(fit.x[w], due, max_relative = 1e-3);
        }
    }
}

/// A line in pieces is one line; one that jumps between them is not, and a spec that asks for pieces gets
/// them.
#[test]
fn pieces_are_joined_unless_the_run_drifts() {
    let lifted = |i: usize| if (i / 20).is_multiple_of(2) { 0.0 } else { 6.0 };
    let jumped = line(0.5).iter().enumerate().map(|(i, x)| x + lifted(i)).collect();
    for (samples, whole) in [(line(0.5), true), (jumped, false)] {
        let (case, records) = records(LINE, &[(Role::Fit, samples.clone())]);
        let auto = context(&case, &records, SegmentsSpec::Auto);
        let problem = Problem::new(&case.system, &[0], &auto.records, &[5]).unwrap();
        let x = problem.guess(&[0.4], None, &records);
        let noise = problem.first_noise();
        assert_relative_eq!(noise[0][0].additive, 0.1 * standard_deviation(&samples), max_relative = 1e-12);
        let cut = auto.settle(problem, x, noise, 3).unwrap();
        assert_eq!(cut.pieces, [5]);
        assert_relative_eq!(cut.x[0], 0.5, max_relative = 0.2);
        let joined = auto.joined(&cut);
        assert_eq!(joined.is_some(), whole);
        assert!(context(&case, &records, SegmentsSpec::Count(4)).joined(&cut).is_none());
        if let Some(joined) = joined {
            assert_eq!(joined.pieces, [1]);
            assert_relative_eq!(joined.x[0], regression(&samples).0, max_relative = 1e-4);
            assert!(auto.joined(&joined).is_none());
        }
        // From scratch the same: a run that drifts stays in its finest pieces, softly joined.
        let fresh = auto.fresh_fit(&[0], &[0.4]).unwrap();
        assert_eq!(
            (fresh.pieces[0], fresh.problem.continuity.is_some()),
            if whole { (1, false) } else { (20, true) }
        );
    }
}

#[test]
fn white_is_what_counts_or_has_no_power() {
    let (case, records) = records(LINE, &[(Role::Fit, line(0.5))]);
    let mut fit = fitted_terms(&case, &records, SIGMA, &[0]);
    for (part, excess, white) in [(0.7, 9.0, true), (0.5, 9.0, false), (0.5, 1.05, true), (0.5, 1.15, false)]
    {
        (fit.effective, fit.excess) = (part * SAMPLES as f64, excess);
        assert_eq!(fit.is_white(), white, "{part} {excess}");
    }
    // A parabola is left.
    let bent = line(0.5).iter().enumerate().map(|(i, x)| x + 0.02 * (STEP * i as f64).powi(2)).collect();
    let (case, records) = crate::line_models::records(LINE, &[(Role::Fit, bent)]);
    assert!(fitted_terms(&case, &records, SIGMA, &[0]).chance_of_noise() < 1e-6);
    assert!(fitted_terms(&case, &records, SIGMA, &[0, 1]).chance_of_noise() > 1e-3);
}

/// Friction of 0.5 stops a throw of 1.5 after three seconds; what is given up takes four times the steps, and
/// a thousand.
#[test]
fn a_throw_comes_to_rest() {
    let spec = r#"states: {"x": "", "v": ""}, known: {"x": "v", "v": "0"}, unknown: {"v": (factor: "-sgn(v)", candidates: ["1"])}, contacts: ["v"]"#;
    let place = |i: usize| (STEP * i as f64).min(3.0);
    let throw = |n: usize| (0..n).map(|i| 1.5 * place(i) - 0.25 * place(i).powi(2)).collect::<Vec<_>>();
    for (samples, rests) in [(60, true), (25, false)] {
        let (case, mut records) = records(spec, &[(Role::Fit, throw(samples))]);
        records[0].columns[1] = Some((0..samples).map(|i| 1.5 - 0.5 * place(i)).collect());
        let mut fit = fitted_terms(&case, &records, 0.01, &[0]);
        assert_relative_eq!(fit.x[0], 0.5, max_relative = 1e-4);
        assert_eq!(fit.comes_to_rest(), rests);
        assert_eq!(fit.budget(3), 1_000 + 12 * fit.problem.steps(&fit.x));
        fit.pieces = vec![2];
        assert!(!fit.comes_to_rest());
    }
}

/// A fit that is stuck with too little friction: only where the motion rests, and something is left, is a
/// better one looked for.
#[test]
fn a_side_minimum_is_left_by_a_hop() {
    let spec = r#"states: {"x": "", "v": ""}, known: {"x": "v", "v": "0"}, unknown: {"v": (factor: "-sgn(v)", candidates: ["1"])}, contacts: ["v"]"#;
    let place = |i: usize| (STEP * i as f64).min(3.0);
    let throw = |n: usize| (0..n).map(|i| 1.5 * place(i) - 0.25 * place(i).powi(2)).collect::<Vec<_>>();
    for (samples, white, hops) in [(60, false, true), (60, true, false), (25, false, false)] {
        let (case, records) = records(spec, &[(Role::Fit, throw(samples))]);
        let context = context(&case, &records, SegmentsSpec::Auto);
        let mut stuck = fitted_terms(&case, &records, 0.01, &[0]);
        stuck.x.copy_from_slice(&[0.46, 0.0, 1.5]);
        stuck.normal = stuck.problem.normal(&stuck.x, &stuck.weights).unwrap();
        stuck.effective = if white { samples as f64 } else { 1.0 };
        stuck.excess = 9.0;
        let before = context.misfit(&stuck).unwrap();
        let found = context.with_scaled_coefficients(stuck);
        assert_eq!(found.x != [0.46, 0.0, 1.5], hops);
        if hops {
            assert_relative_eq!(found.x[0], 0.5, max_relative = 1e-3);
            assert!(context.misfit(&found).unwrap() < 0.01 * before);
        }
    }
}

/// What a hop gains by going on for some more steps is not worth it.
#[test]
fn a_minimum_that_is_not_at_the_side_is_kept() {
    let spec = r#"states: {"x": "", "v": ""}, known: {"x": "v", "v": "0"}, unknown: {"v": (factor: "-sgn(v)", candidates: ["1"])}, contacts: ["v"]"#;
    let place = |i: usize| (STEP * i as f64).min(3.0);
    let noise = scatter(60);
    let throw = (0..60).map(|i| 1.5 * place(i) - 0.25 * place(i).powi(2) + 0.01 * noise[i]).collect();
    let (case, records) = records(spec, &[(Role::Fit, throw)]);
    let mut fit = fitted_terms(&case, &records, 0.01, &[0]);
    (fit.effective, fit.excess) = (1.0, 9.0);
    let before = fit.x.clone();
    assert!(fit.comes_to_rest());
    assert_eq!(context(&case, &records, SegmentsSpec::Auto).with_scaled_coefficients(fit).x, before);
}

/// Level and bend of the rate: the one is a constant that may move, the other a term.
#[test]
fn a_parameter_is_fitted_beside_a_term() {
    let spec = r#"constants: {"c": (value: 0.1, within: (-9.0, 9.0))}, states: {"x": ""}, known: {"x": "c"}, unknown: {"x": (factor: "1", candidates: ["2*t"])}"#;
    let (case, records) = records(spec, &[(Role::Fit, line(0.5))]);
    let context = context(&case, &records, SegmentsSpec::Auto);
    let fit = context.fresh_fit(&[0], &[0.0]).unwrap();
    let terms =
        r#"states: {"x": ""}, known: {"x": "0"}, unknown: {"x": (factor: "1", candidates: ["2*t", "1"])}"#;
    let (case, records) = crate::line_models::records(terms, &[(Role::Fit, line(0.5))]);
    let due = fitted_terms(&case, &records, SIGMA, &[0, 1]);
    assert_eq!(context.shared(&fit), Some(vec![fit.x[1]]));
    assert_relative_eq!(fit.x[1], due.x[1], max_relative = 1e-2);
    assert_relative_eq!(fit.x[0], due.x[0], epsilon = 1e-3);
}
