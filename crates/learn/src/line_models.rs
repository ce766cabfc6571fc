//! For tests: models whose motion is a line, fitted with known noise. Their fits are linear regressions.

use crate::least_squares::Limits;
use crate::step::onestep::tests::common;
use crate::trajectory::fit::Fit;
use crate::trajectory::noise::ColumnNoise;
use crate::trajectory::problem::Problem;
use phisindy_phys::spec::Role;
use phisindy_phys::{Case, Record};

/// Seconds between samples.
pub(crate) const STEP: f64 = 0.1;

/// The spec `text` without data, and a record of it for each role, with these samples of the first state and
/// none of the others.
pub(crate) fn records(text: &str, samples: &[(Role, Vec<f64>)]) -> (Case, Vec<Record>) {
    let states = text.split("states: {").nth(1).and_then(|s| s.split('}').next()).unwrap();
    let start = states.replace("\"\"", "0.0");
    let name = states.split('"').nth(1).unwrap();
    let record = |(k, (role, samples)): (usize, &(Role, Vec<f64>))| {
        format!(
            r#"Synthetic(name: "r{k}", truth: {{}}, start: {{{start}}}, duration: {:?}, step: {STEP:?}, noise: Relative(0), measure: ["{name}"], role: {role:?})"#,
            STEP * samples.len() as f64
        )
    };
    let data: Vec<String> = samples.iter().enumerate().map(record).collect();
    let (case, mut records) = common::load_text(&format!("({text}, data: [{}])", data.join(", ")), &[]);
    for (record, (_, samples)) in records.iter_mut().zip(samples) {
        assert_eq!(record.len(), samples.len());
        record.columns[0] = Some(samples.clone());
        record.start.fill(None);
    }
    (case, records)
}

/// All terms of the case fitted to its first record, whose samples are off by `sigma` as far as the fit
/// knows.
pub(crate) fn fitted<'a>(case: &'a Case, records: &'a [Record], sigma: f64) -> Fit<'a> {
    let terms: Vec<usize> = (0..case.system.terms.len()).collect();
    fitted_terms(case, records, sigma, &terms)
}

/// The same for some of the terms.
pub(crate) fn fitted_terms<'a>(
    case: &'a Case,
    records: &'a [Record],
    sigma: f64,
    terms: &[usize],
) -> Fit<'a> {
    let mut problem = Problem::new(&case.system, terms, &[&records[0]], &[1]).unwrap();
    problem.tolerance = 1e-11;
    let noise = vec![vec![ColumnNoise { additive: sigma, relative: 0.0 }; case.system.states.len()]];
    let mut x = problem.guess(&vec![0.0; terms.len()], None, &records[..1]);
    let weights = problem.weights(&noise, None);
    let normal = problem.minimise(&mut x, &weights, Limits::new(50, 1e-12)).unwrap();
    let samples = records[0].readings();
    let effective = samples as f64;
    Fit { problem, x, noise, weights, normal, samples, effective, excess: 1.0, pieces: vec![1], force: None }
}

/// Uncorrelated numbers of +1 and -1.
pub(crate) fn scatter(samples: usize) -> Vec<f64> {
    let hashed = |i: usize| (i as u32).wrapping_mul(2_654_435_769).count_ones().is_multiple_of(2);
    (0..samples).map(|i| if hashed(i) { 1.0 } else { -1.0 }).collect()
}

/// Sum of the squared distances of the sample times from their mean.
pub(crate) fn lever(samples: usize) -> f64 {
    let n = samples as f64;
    STEP * STEP * n * (n * n - 1.0) / 12.0
}

/// How much of its own value a sample of a line decides: by the mean of all, and by its distance from the
/// middle.
pub(crate) fn leverage(sample: usize, samples: usize) -> f64 {
    let n = samples as f64;
    1.0 / n + (STEP * (sample as f64 - 0.5 * (n - 1.0))).powi(2) / lever(samples)
}
