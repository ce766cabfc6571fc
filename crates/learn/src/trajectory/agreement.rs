//! Agreement of records. The terms of a fit are fitted again to each Validate record alone. A wrong model puts
//! its error into the coefficients, so another motion gives other coefficients.

use crate::decisions::{AGREEMENT_DAMPING, AGREEMENT_MINIMUM, DENSE, RARE};
use crate::least_squares::Limits;
use crate::linear::{covariance, inverse_block, solve_damped};
use crate::result::quantity::TermId;
use crate::result::record_fit::RecordFit;
use crate::result::warning::Warning;
use crate::trajectory::fit::Fit;
use crate::trajectory::free_run::Solution;
use crate::trajectory::problem::{Meaning, Problem};
use crate::trajectory::tally::{inflation, tally};
use faer::Mat;
use phisindy_phys::Record;
use phisindy_phys::spec::Role;

/// Compares the coefficients of the fit with those of each Validate record: one warning for each record that
/// differs by more than chance. `cov` is the covariance of the unknowns of the fit.
pub(crate) fn disagreements(
    fit: &Fit<'_>,
    cov: &Mat<f64>,
    solution: &Solution,
    records: &[Record],
    filled: &[Record],
    runs: &[RecordFit],
) -> Vec<Warning> {
    let validated =
        (0..records.len()).filter(|&r| records[r].role == Role::Validate && runs[r].run.is_some());
    validated
        .filter_map(|r| disagreement(fit, cov, solution, &records[r], &filled[r..=r], &runs[r], r))
        .collect()
}

fn disagreement(
    fit: &Fit<'_>,
    cov: &Mat<f64>,
    solution: &Solution,
    record: &Record,
    filled: &[Record],
    run: &RecordFit,
    r: usize,
) -> Option<Warning> {
    let (system, terms) = (fit.problem.system, &fit.problem.terms);
    let t = terms.len();
    if t == 0 {
        return None;
    }
    // Cut like the fit: of a plant that drifts a single run says nothing about its coefficients.
    let fitted: usize = fit.problem.records.iter().map(|r| r.len()).sum();
    let pieces =
        if fit.most_pieces() == 1 { 1 } else { (fit.problem.segments.len() * record.len()).div_ceil(fitted) };
    let mut problem = Problem::new(system, terms, &[record], &[pieces]).ok()?;
    let mut x = problem.guess(&solution.coefficients, Some(&solution.parameters[r]), filled);
    let start = problem.segments[0].start;
    x[start..start + run.start.len()].copy_from_slice(&run.start);
    // Coefficients and the start state move; everything else is fixed.
    let mut moving: Vec<usize> = Vec::new();
    for (k, meaning) in problem.meanings().into_iter().enumerate() {
        match meaning {
            Meaning::Coefficient(_) | Meaning::Start => moving.push(k),
            Meaning::Sensor(_, state, which) => x[k] = solution.sensors[r][state][which],
            Meaning::Parameter(..) => {}
        }
        if moving.last() != Some(&k) {
            problem.bounds[k] = (x[k], x[k]);
        }
    }
    let noise = vec![fit.noise.first()?.clone()];
    let weights = problem.weights(&noise, problem.residuals(&x).ok().as_deref());
    let normal = problem.minimise(&mut x, &weights, Limits::of(AGREEMENT_MINIMUM)).ok()?;
    let told = tally(&noise, &problem.residuals(&x).ok()?);
    let inflation = inflation(told.samples, told.effective);
    let curvature = Mat::from_fn(moving.len(), moving.len(), |i, j| normal.matrix[(moving[i], moving[j])]);
    let own = if moving.len() > DENSE { inverse_block(&curvature, t)? } else { covariance(&curvature) };
    // The coefficients are the first unknowns of both.
    let both = Mat::from_fn(t, t, |i, j| cov[(i, j)] * fit.inflation() + own[(i, j)] * inflation);
    if (0..t).any(|k| !both[(k, k)].is_finite()) {
        return None;
    }
    let apart: Vec<f64> = (0..t).map(|k| x[k] - fit.x[k]).collect();
    let distance: f64 =
        solve_damped(&both, &apart, AGREEMENT_DAMPING)?.iter().zip(&apart).map(|(a, b)| a * b).sum();
    // Wilson and Hilferty's quantile of chi square.
    let spread = 2.0 / (9.0 * t as f64);
    if distance <= t as f64 * (1.0 - spread + RARE * spread.sqrt()).powi(3) {
        return None;
    }
    let errors = |k: usize| apart[k].abs() / both[(k, k)].sqrt();
    let worst = (0..t).max_by(|&a, &b| errors(a).total_cmp(&errors(b)))?;
    Some(Warning::Disagreement {
        term: TermId::new(system, terms[worst]),
        record: record.name.clone(),
        alone: x[worst],
        fitted: fit.x[worst],
        errors: errors(worst),
    })
}

#[cfg(test)]
mod tests;
