//! Agreement of records. The coefficients and shared constants of a fit are fitted again to each Validate
//! record alone. A wrong model puts its error into these numbers, so another motion gives other numbers. What
//! they differ by beyond their errors is the scatter between records (R. DerSimonian and N. Laird, Controlled
//! Clinical Trials 7 (1986) 177-188): an error that no fit to one record shows.

use crate::decisions::{AGREEMENT_DAMPING, AGREEMENT_MINIMUM, DENSE, RARE};
use crate::least_squares::{Limits, Normal};
use crate::linear::{covariance, inverse_block, solve_damped};
use crate::result::quantity::{ParameterId, ParameterOf, Quantity, TermId};
use crate::result::record_fit::RecordFit;
use crate::result::warning::Warning;
use crate::trajectory::fit::Fit;
use crate::trajectory::free_run::Solution;
use crate::trajectory::problem::{Meaning, Noise, Problem};
use crate::trajectory::tally::{inflation, tally, weighed};
use crate::trajectory::validated_chain::ValidatedChain;
use faer::Mat;
use phisindy_phys::spec::Role;
use phisindy_phys::unit::Unit;
use phisindy_phys::{Record, System};

/// What the Validate records say of the numbers of a fit.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Agreement {
    /// One for each record that differs by more than chance.
    pub(crate) warnings: Vec<Warning>,
    /// For the first unknowns of the fit, coefficients and shared constants, the variance between records
    /// where any differs by more than chance; empty where none does.
    pub(crate) scatter: Vec<f64>,
}

/// A Validate record beside the fit.
struct Compared {
    /// Of each number, what the record alone puts it off by, and the variance of that.
    apart: Vec<(f64, f64)>,
    warning: Option<Warning>,
}

/// Compares the numbers of the fit with those of each Validate record. `cov` is the covariance of the
/// unknowns of the fit, `chains` are those of records whose motion forgets its start.
pub(crate) fn disagreements(
    fit: &Fit<'_>,
    cov: &Mat<f64>,
    solution: &Solution,
    records: &[Record],
    filled: &[Record],
    runs: &[RecordFit],
    chains: &[Option<ValidatedChain<'_>>],
) -> Agreement {
    let validated =
        (0..records.len()).filter(|&r| records[r].role == Role::Validate && runs[r].run.is_some());
    let all: Vec<Compared> = validated
        .filter_map(|r| {
            if let Some(Some(chain)) = chains.get(r) {
                return of_chain(fit, cov, &records[r], chain);
            }
            // A record that continues another one has its sensors and its own numbers.
            let owner = records[r].continues.filter(|&j| runs[j].run.is_some()).unwrap_or(r);
            compared(fit, cov, solution, &records[r], &filled[r..=r], &runs[r], owner)
        })
        .collect();
    if all.iter().all(|c| c.warning.is_none()) {
        return Agreement::default();
    }
    // The variance of two numbers round their mean is half of their squared distance.
    let between = |k: usize| {
        let excess = |c: &Compared| c.apart.get(k).map_or(0.0, |(d, v)| 0.5 * (d * d - v));
        (all.iter().map(excess).sum::<f64>() / all.len() as f64).max(0.0)
    };
    let numbers = all.iter().map(|c| c.apart.len()).max().unwrap_or(0);
    let scatter = (0..numbers).map(between).collect();
    Agreement { warnings: all.into_iter().filter_map(|c| c.warning).collect(), scatter }
}

fn compared(
    fit: &Fit<'_>,
    cov: &Mat<f64>,
    solution: &Solution,
    record: &Record,
    filled: &[Record],
    run: &RecordFit,
    owner: usize,
) -> Option<Compared> {
    let (system, terms) = (fit.problem.system, &fit.problem.terms);
    // Coefficients and shared constants come first in both.
    let t = terms.len() + system.parameters.iter().filter(|p| !p.each).count();
    if t == 0 {
        return None;
    }
    // Cut like the fit: of a plant that drifts a single run says nothing about its coefficients.
    let fitted: usize = fit.problem.records.iter().map(|r| r.len()).sum();
    let pieces =
        if fit.most_pieces() == 1 { 1 } else { (fit.problem.segments.len() * record.len()).div_ceil(fitted) };
    let mut problem = Problem::new(system, terms, &[record], &[pieces]).ok()?;
    let mut x = solution.guess(&problem, owner, filled);
    let start = problem.segments[0].start;
    x[start..start + run.start.len()].copy_from_slice(&run.start);
    let noise = vec![fit.noise.first()?.clone()];
    let weights = match &fit.force {
        Some(force) => problem.follow(&x, &noise, &force.of_another())?.0,
        None => problem.weights(&noise, problem.residuals(&x).ok().as_deref()),
    };
    refitted(fit, cov, record, (problem, x), &noise, &weights)
}

/// As [`compared`], along a chain.
fn of_chain(fit: &Fit<'_>, cov: &Mat<f64>, record: &Record, chain: &ValidatedChain<'_>) -> Option<Compared> {
    let mut problem =
        Problem::new(chain.problem.system, &chain.problem.terms, &[record], &[chain.problem.segments.len()])
            .ok()?;
    (problem.continuity, problem.chained) = (chain.problem.continuity.clone(), true);
    refitted(fit, cov, record, (problem, chain.x.clone()), &chain.noise, &chain.weights)
}

/// Fits the numbers of a fit again from `x`, and compares.
fn refitted(
    fit: &Fit<'_>,
    cov: &Mat<f64>,
    record: &Record,
    (mut problem, mut x): (Problem<'_>, Vec<f64>),
    noise: &Noise,
    weights: &[Vec<Vec<f64>>],
) -> Option<Compared> {
    let (system, terms) = (fit.problem.system, &fit.problem.terms);
    let t = terms.len() + system.parameters.iter().filter(|p| !p.each).count();
    // The numbers that both records see and the start state move; everything else is fixed.
    let seen = |k: usize, normal: &Normal| {
        cov[(k, k)].is_finite() && normal.matrix[(k, k)] > 0.0 && problem.bounds[k].0 < problem.bounds[k].1
    };
    let here = problem.normal(&x, weights).ok()?;
    let meanings = problem.meanings();
    let moves = |k: &usize| match meanings[*k] {
        Meaning::Coefficient(_) | Meaning::Parameter(_, None) => seen(*k, &here),
        Meaning::Start => true,
        Meaning::Sensor(..) | Meaning::Parameter(_, Some(_)) => false,
    };
    let moving: Vec<usize> = (0..x.len()).filter(moves).collect();
    let compared = moving.iter().filter(|k| **k < t).count();
    if compared == 0 {
        return None;
    }
    for k in (0..x.len()).filter(|k| !moving.contains(k)) {
        problem.hold(k, x[k]);
    }
    let normal = problem.minimise(&mut x, weights, Limits::of(AGREEMENT_MINIMUM)).ok()?;
    let residuals = problem.residuals(&x).ok()?;
    let told =
        if problem.following.is_some() { weighed(weights, &residuals) } else { tally(noise, &residuals) };
    let inflation = inflation(told.samples, told.effective);
    let curvature = Mat::from_fn(moving.len(), moving.len(), |i, j| normal.matrix[(moving[i], moving[j])]);
    let own =
        if moving.len() > DENSE { inverse_block(&curvature, compared)? } else { covariance(&curvature) };
    // The covariance of a fit with forces knows the correlation.
    let stretch = if fit.force.is_some() { 1.0 } else { fit.inflation() };
    let both = Mat::from_fn(compared, compared, |i, j| {
        cov[(moving[i], moving[j])] * stretch + own[(i, j)] * inflation
    });
    if (0..compared).any(|k| !both[(k, k)].is_finite()) {
        return None;
    }
    let apart: Vec<f64> = moving[..compared].iter().map(|&k| x[k] - fit.x[k]).collect();
    let chance = by_chance(&both, &apart)?;
    let errors = |k: usize| apart[k].abs() / both[(k, k)].sqrt();
    let worst = (0..compared).max_by(|&a, &b| errors(a).total_cmp(&errors(b)))?;
    let warning = (!chance).then(|| {
        let k = moving[worst];
        let (number, factor) = shared_number(system, terms, &meanings[k], k);
        let (record, errors) = (record.name.clone(), errors(worst));
        Warning::Disagreement { number, record, alone: x[k] / factor, fitted: fit.x[k] / factor, errors }
    });
    let mut all = vec![(0.0, 0.0); t];
    for (i, &k) in moving[..compared].iter().enumerate() {
        all[k] = (apart[i], both[(i, i)]);
    }
    Some(Compared { apart: all, warning })
}

/// Whether numbers differ by no more than chance: the distance in their covariance `both` against chi square.
fn by_chance(both: &Mat<f64>, apart: &[f64]) -> Option<bool> {
    let steps = solve_damped(both, apart, AGREEMENT_DAMPING)?;
    let distance: f64 = steps.iter().zip(apart).map(|(a, b)| a * b).sum();
    // Wilson and Hilferty's quantile of chi square.
    let degrees = apart.len() as f64;
    let spread = 2.0 / (9.0 * degrees);
    Some(distance <= degrees * (1.0 - spread + RARE * spread.sqrt()).powi(3))
}

/// What a shared unknown is, and the factor of its unit.
fn shared_number(system: &System, terms: &[usize], meaning: &Meaning, k: usize) -> (Quantity, f64) {
    match *meaning {
        Meaning::Parameter(index, _) => {
            let of = ParameterOf::Constant { index, name: system.parameters[index].name.clone() };
            (Quantity::Parameter(ParameterId { of, owner: None }), factor(system, index))
        }
        _ => (Quantity::Coefficient(TermId::new(system, terms[k])), 1.0),
    }
}

/// Factor from the unit of a constant to SI.
fn factor(system: &System, parameter: usize) -> f64 {
    Unit::parse(&system.parameters[parameter].unit).map_or(1.0, |u| u.factor)
}

#[cfg(test)]
mod tests;
