//! Fit records that ask for different numbers: each record alone, with a noise and a force of its own, beside each
//! other one. A common fit would take the difference for noise of all records but one.

use crate::decisions::{OTHER_MACHINE, RARE};
use crate::result::quantity::{ParameterId, ParameterOf, Quantity, TermId};
use crate::result::verdict::Contradiction;
use crate::trajectory::error_bars::ErrorBars;
use crate::trajectory::fit::{Fit, settled_alone};
use crate::trajectory::layout::Source;
use crate::trajectory::problem::{Meaning, Problem};
use phisindy_phys::unit::Unit;
use rayon::prelude::*;

/// A shared number as one record alone asks for it, and its standard error.
type Alone = Vec<(f64, f64)>;

/// The two records that are furthest apart in a shared number, beyond chance and beyond what one machine may differ
/// by from run to run.
pub(crate) fn contradiction(fit: &Fit<'_>) -> Option<Contradiction> {
    let (problem, system) = (&fit.problem, fit.problem.system);
    if problem.records.len() < 2 || problem.chained {
        return None;
    }
    let meanings = problem.meanings();
    let shared: Vec<usize> = (0..meanings.len())
        .filter(|&k| matches!(meanings[k], Meaning::Coefficient(_) | Meaning::Parameter(_, None)))
        .collect();
    if shared.is_empty() {
        return None;
    }
    let all: Vec<Option<Alone>> =
        (0..problem.records.len()).into_par_iter().map(|r| alone(fit, r, shared.len())).collect();
    let mut worst: Option<(f64, usize, usize, usize)> = None;
    for a in 0..all.len() {
        for b in a + 1..all.len() {
            let (Some(one), Some(other)) = (&all[a], &all[b]) else { continue };
            for k in 0..shared.len() {
                let ((x, dx), (y, dy)) = (one[k], other[k]);
                let (apart, error) = ((x - y).abs(), dx.hypot(dy));
                let far = apart > OTHER_MACHINE * x.abs().max(y.abs());
                if error.is_finite() && error > 0.0 && far && apart / error > worst.map_or(RARE, |w| w.0) {
                    worst = Some((apart / error, k, a, b));
                }
            }
        }
    }
    let (errors, k, a, b) = worst?;
    let (number, factor) = match meanings[shared[k]] {
        Meaning::Parameter(index, _) => {
            let p = &system.parameters[index];
            let of = ParameterOf::Constant { index, name: p.name.clone() };
            let factor = Unit::parse(&p.unit).map_or(1.0, |u| u.factor);
            (Quantity::Parameter(ParameterId { of, owner: None }), factor)
        }
        _ => (Quantity::Coefficient(TermId::new(system, problem.terms[shared[k]])), 1.0),
    };
    let value = |r: usize| all[r].as_ref().map_or(f64::NAN, |of| of[k].0 / factor);
    let name = |r: usize| problem.records[r].name.clone();
    Some(Contradiction { number, records: [name(a), name(b)], values: [value(a), value(b)], errors })
}

/// The shared numbers of a fit, fitted to one of its records.
fn alone(fit: &Fit<'_>, r: usize, shared: usize) -> Option<Alone> {
    let from = &fit.problem;
    let record = from.records[r];
    let pieces = from.segments.iter().filter(|s| s.record == r).count();
    let mut problem = Problem::new(from.system, &from.terms, &[record], &[pieces]).ok()?;
    let mut x = vec![0.0; problem.unknowns];
    let value = |source: Source| match source {
        Source::Unknown(k) => fit.x[k],
        Source::Number(v) => v,
    };
    let sensors = problem.sensors[0].iter().flatten().zip(from.sensors[r].iter().flatten());
    let numbers = problem.model[0].iter().zip(&from.model[r]).chain(sensors);
    for (to, of) in numbers {
        if let Source::Unknown(k) = *to {
            x[k] = value(*of);
        }
    }
    let n = from.system.states.len();
    for (to, of) in problem.segments.iter().zip(from.segments.iter().filter(|s| s.record == r)) {
        x[to.start..to.start + n].copy_from_slice(&fit.x[of.start..of.start + n]);
    }
    problem.continuity = from.continuity.clone();
    let found = settled_alone(problem, x, (r, fit))?;
    let bars = ErrorBars::new(&found);
    let of = |k: usize| (found.x[k], bars.error(k));
    Some((0..shared).map(of).collect())
}
