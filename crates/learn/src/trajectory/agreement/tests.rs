//! Lines, and parabolas: the distance between two fits is a quadratic form that can be written down, and the
//! threshold stands in tables of chi square.

use super::*;
use crate::line_models::{STEP, fitted, lever, records, scatter};
use crate::trajectory::free_run::free_runs;
use approx::assert_relative_eq;
use phisindy_phys::Case;
use phisindy_signal::effective_samples;

const SIGMA: f64 = 0.3;
const SAMPLES: usize = 120;

/// What chi square with so many degrees of freedom exceeds once in a hundred thousand times; the
/// approximation is up to 12 % above.
const TABLE: [f64; 3] = [19.511, 23.026, 25.902];

fn line(samples: &[(Role, Vec<f64>)]) -> (Case, Vec<Record>) {
    records(
        r#"states: {"x": ""}, known: {"x": "0"}, unknown: {"x": (factor: "1", candidates: ["1"])}"#,
        samples,
    )
}

fn sloped(slope: f64, noise: &[f64]) -> Vec<f64> {
    noise.iter().enumerate().map(|(i, e)| slope * STEP * i as f64 + SIGMA * e).collect()
}

/// What is said of all records beside a fit that found `found`, with the covariance `cov` and so many
/// effective samples.
fn texts(warnings: &[Warning]) -> Vec<String> {
    warnings.iter().map(ToString::to_string).collect()
}

fn said(case: &Case, records: &[Record], found: &[f64], cov: &Mat<f64>, effective: f64) -> Vec<String> {
    let mut fit = fitted(case, records, SIGMA);
    fit.x[..found.len()].copy_from_slice(found);
    fit.effective = effective;
    let parameters: Vec<f64> = case.system.parameters.iter().map(|p| p.start).collect();
    let mut solution = Solution::new(fit.problem.terms.clone(), found.to_vec(), &parameters, records);
    let runs = free_runs(&case.system, records, records, &mut solution);
    texts(&disagreements(&fit, cov, &solution, records, records, &runs, &[]).warnings)
}

/// The least-squares slope of samples.
fn slope(samples: &[f64]) -> f64 {
    let middle = 0.5 * (samples.len() - 1) as f64;
    samples.iter().enumerate().map(|(i, x)| STEP * (i as f64 - middle) * x).sum::<f64>()
        / lever(samples.len())
}

/// The variance of both fits counts, each with its own inflation.
#[test]
fn a_slope_is_told_of_where_chi_square_says_so() {
    let white = sloped(1.0, &scatter(SAMPLES));
    // Each number twice: half of the samples are independent.
    let pairs: Vec<f64> = scatter(SAMPLES).into_iter().flat_map(|e| [e, e]).take(SAMPLES).collect();
    let correlated = sloped(1.0, &pairs);
    for (validate, least) in [(white, 1.0), (correlated, 1.6)] {
        let (case, records) = line(&[(Role::Fit, vec![0.0; SAMPLES]), (Role::Validate, validate.clone())]);
        let best = slope(&validate);
        let middle = validate.iter().sum::<f64>() / SAMPLES as f64;
        let half = 0.5 * (SAMPLES - 1) as f64;
        let left: Vec<f64> =
            (0..SAMPLES).map(|i| validate[i] - middle - best * STEP * (i as f64 - half)).collect();
        let inflation = SAMPLES as f64 / effective_samples(&left);
        let inflation = if inflation < 1.3 { 1.0 } else { inflation };
        assert!((least..least + 1.0).contains(&inflation), "{inflation}");
        let own = inflation * SIGMA * SIGMA / lever(SAMPLES);
        // The fit's own variance, before its inflation of three.
        let fitted = 0.7 * own;
        let deviation = (3.0 * fitted + own).sqrt();
        let cov = Mat::from_fn(2, 2, |i, j| if i == j { fitted } else { 0.0 });
        let told = |distance: f64| {
            let found = best - distance.sqrt() * deviation;
            said(&case, &records, &[found], &cov, SAMPLES as f64 / 3.0)
        };
        assert_eq!(told(0.98 * TABLE[0]), Vec::<String>::new());
        assert_eq!(told(0.0), Vec::<String>::new());
        assert_eq!(told(1.13 * TABLE[0]).len(), 1);
        let text = &told(100.0)[0];
        assert!(text.starts_with(&format!("1 in x' is {best:.4} from r1 alone and ")), "{text}");
        assert!(text.contains(", 10 standard errors apart"), "{text}");
    }
}

/// `x = x0 + a t + b t^2 + c t^3`: the distance is the quadratic form of the normal matrix, less what the
/// start takes.
#[test]
fn three_coefficients_are_told_of_together() {
    let noise = sloped(0.4, &scatter(SAMPLES));
    let (case, records) = records(
        r#"states: {"x": ""}, known: {"x": "0"}, unknown: {"x": (factor: "1", candidates: ["1", "2*t", "3*t^2"])}"#,
        &[(Role::Fit, vec![0.0; SAMPLES]), (Role::Validate, noise)],
    );
    let best = {
        let (mine, validate) = (records.clone(), &records[1]);
        let mut alone = mine;
        alone[0].columns = validate.columns.clone();
        fitted(&case, &alone, SIGMA).x[..3].to_vec()
    };
    let power = |i: usize, k: usize| (STEP * i as f64).powi(k as i32 + 1);
    let mean = |k: usize| (0..SAMPLES).map(|i| power(i, k)).sum::<f64>() / SAMPLES as f64;
    let gram = Mat::from_fn(3, 3, |a, b| {
        let product = |i: usize| (power(i, a) - mean(a)) * (power(i, b) - mean(b));
        (0..SAMPLES).map(product).sum::<f64>() / (SIGMA * SIGMA)
    });
    // The fit knows as much as the other record does.
    let own = covariance(&gram);
    let cov = Mat::from_fn(4, 4, |i, j| if i < 3 && j < 3 { own[(i, j)] } else { 0.0 });
    for direction in [[1.0, 0.0, 0.0], [1.0, -0.3, 0.02], [0.0, 0.0, -1.0]] {
        let form: f64 =
            (0..9).map(|k| direction[k / 3] * gram[(k / 3, k % 3)] * direction[k % 3]).sum::<f64>() / 2.0;
        let told = |distance: f64| {
            let found: Vec<f64> =
                best.iter().zip(direction).map(|(x, d)| x - d * (distance / form).sqrt()).collect();
            said(&case, &records, &found, &cov, SAMPLES as f64)
        };
        assert_eq!(told(0.98 * TABLE[2]), Vec::<String>::new());
        let texts = told(1.13 * TABLE[2]);
        assert_eq!(texts.len(), 1);
        // Named is the one that is furthest off in units of its own error.
        let errors = |k: usize| direction[k].abs() / own[(k, k)].sqrt();
        let worst = (0..3).max_by(|&a, &b| errors(a).total_cmp(&errors(b))).unwrap();
        assert!(texts[0].starts_with(["1 in", "2*t in", "3*t^2 in"][worst]), "{}", texts[0]);
        let apart = errors(worst) * (1.13 * TABLE[2] / form).sqrt() / 2.0_f64.sqrt();
        assert!(texts[0].contains(&format!(", {apart:.0} standard errors apart")), "{apart}: {}", texts[0]);
    }
    assert_relative_eq!(best[0], 0.4, epsilon = 0.2);
}

/// The interval that a record contradicts holds what it says.
#[test]
fn the_scatter_between_records_is_in_the_error_bars() {
    let noise = scatter(SAMPLES);
    let (case, records) = line(&[(Role::Fit, sloped(1.0, &noise)), (Role::Validate, sloped(3.0, &noise))]);
    let fit = fitted(&case, &records, SIGMA);
    let own = SIGMA * SIGMA / lever(SAMPLES);
    let cov = Mat::from_fn(2, 2, |i, j| if i == j { own } else { 0.0 });
    let mut solution = Solution::new(vec![0], vec![fit.x[0]], &[], &records);
    let runs = free_runs(&case.system, &records, &records, &mut solution);
    let found = disagreements(&fit, &cov, &solution, &records, &records, &runs, &[]);
    // The variance of 1 and 3 round their mean is 2.
    assert_relative_eq!(found.scatter[0], 2.0, max_relative = 0.01);
    let mut slope = crate::Estimate::normal(fit.x[0], own.sqrt());
    slope.widen(found.scatter[0]);
    assert!(slope.ci95.1 > 3.0 && slope.ci95.0 < -1.0, "{slope:?}");
}

/// A constant that another record contradicts is told of as a coefficient is, also where nothing else is
/// sought.
#[test]
fn a_constant_that_does_not_carry_over_is_told() {
    let noise = scatter(SAMPLES);
    let (case, records) = records(
        r#"constants: {"q": (value: 0.9, within: (0.0, 9.0))}, states: {"x": ""}, known: {"x": "q"}, unknown: {}"#,
        &[(Role::Fit, sloped(1.0, &noise)), (Role::Validate, sloped(3.0, &noise))],
    );
    let fit = fitted(&case, &records, SIGMA);
    let own = SIGMA * SIGMA / lever(SAMPLES);
    let cov = Mat::from_fn(2, 2, |i, j| if i == j { own } else { 0.0 });
    let mut solution = Solution::new(vec![], vec![], &fit.x[..1], &records);
    let runs = free_runs(&case.system, &records, &records, &mut solution);
    let found = disagreements(&fit, &cov, &solution, &records, &records, &runs, &[]);
    let text = found.warnings[0].to_string();
    assert!(text.starts_with("q is 2.99") && text.contains("from r1 alone and 0.99"), "{text}");
}

/// Only a record that was held back and that runs has a say, and only of what is known at all.
#[test]
fn who_has_no_say() {
    let noise = scatter(SAMPLES);
    let (line_up, line_down) = (sloped(1.0, &noise), sloped(-1.0, &noise));
    let (case, records) =
        line(&[(Role::Fit, line_up.clone()), (Role::Fit, line_down.clone()), (Role::Validate, line_down)]);
    let cov = |variance: f64| Mat::from_fn(2, 2, |i, j| if i == j { variance } else { 0.0 });
    let texts = said(&case, &records, &[1.0], &cov(1e-6), SAMPLES as f64);
    assert_eq!(texts.len(), 1);
    assert!(texts[0].contains(" from r2 alone"), "{}", texts[0]);
    assert_eq!(said(&case, &records, &[1.0], &cov(f64::INFINITY), SAMPLES as f64), Vec::<String>::new());

    // A free run that failed is told of elsewhere.
    let fit = fitted(&case, &records, SIGMA);
    let mut solution = Solution::new(vec![0], vec![1.0], &[], &records);
    let mut runs = free_runs(&case.system, &records, &records, &mut solution);
    runs[2].run = None;
    let left = disagreements(&fit, &cov(1e-6), &solution, &records, &records, &runs, &[]);
    assert_eq!(left, Agreement::default());

    // No term, no coefficient.
    let (case, records) = crate::line_models::records(
        r#"states: {"x": ""}, known: {"x": "1"}, unknown: {}"#,
        &[(Role::Fit, line_up.clone()), (Role::Validate, line_up)],
    );
    assert_eq!(said(&case, &records, &[], &cov(1e-6), SAMPLES as f64), Vec::<String>::new());
}

/// A sensor's gain that was found for the record is not found again: with it the slope is right.
#[test]
fn sensors_stay_as_they_were_found() {
    let noise = scatter(SAMPLES);
    let (case, mut records) =
        line(&[(Role::Fit, sloped(1.0, &noise)), (Role::Validate, sloped(2.0, &noise))]);
    records[1].sensors[0].gain.within = Some((0.5, 3.0));
    let fit = fitted(&case, &records, SIGMA);
    let own = SIGMA * SIGMA / lever(SAMPLES);
    let cov = Mat::from_fn(2, 2, |i, j| if i == j { own } else { 0.0 });
    let with_gain = |gain: f64| {
        let mut solution = Solution::new(vec![0], vec![fit.x[0]], &[], &records);
        let runs = free_runs(&case.system, &records, &records, &mut solution);
        solution.sensors[1][0][1] = gain;
        texts(&disagreements(&fit, &cov, &solution, &records, &records, &runs, &[]).warnings)
    };
    assert_eq!(with_gain(2.0), Vec::<String>::new());
    assert_eq!(with_gain(1.0).len(), 1);
}
