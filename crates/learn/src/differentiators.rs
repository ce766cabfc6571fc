//! Whether a result depends on how columns were differentiated: by how much the numbers would move with another differentiator, by one
//! Gauss-Newton step from where they are.

use crate::fit::Fit;
use crate::least_squares::Normal;
use crate::linear::solve_damped;
use crate::problem::Problem;
use phisindy_phys::{Differentiator, Record};

/// Half of a 95 % interval in standard errors.
const REACH: f64 = 1.959_963_984_540_054;

/// A number of the result: its index among the unknowns, its name, its standard error.
pub(crate) type Number = (usize, String, f64);

/// The warning, if a number would move out of its interval. `normal` gives the normal equations at the solution with columns differentiated
/// otherwise; `here` are those of the solution itself.
pub(crate) fn dependence(
    numbers: &[Number],
    here: &Normal,
    normal: impl Fn(Differentiator) -> Option<Normal>,
) -> Option<String> {
    let mut worst: Option<(f64, &str, Differentiator)> = None;
    for how in Differentiator::ALL {
        let Some(step) = normal(how).and_then(|there| step(here, &there)) else { continue };
        for (k, name, error) in numbers {
            let far = step[*k].abs() / (REACH * error);
            if far > 1.0 && worst.is_none_or(|(most, ..)| far > most) {
                worst = Some((far, name, how));
            }
        }
    }
    worst.map(|(far, name, how)| {
        format!(
            "the result depends on how columns are differentiated: with {} {name} would move by {far:.1} times the half of its interval; measure the \
             derivative, or choose by what is known of the motion (Spectral: smooth, SavitzkyGolay: with stops, Spline: any grid)",
            how.name()
        )
    })
}

/// From one minimum to the other.
fn step(here: &Normal, there: &Normal) -> Option<Vec<f64>> {
    let right: Vec<f64> = here.gradient.iter().zip(&there.gradient).map(|(a, b)| a - b).collect();
    solve_damped(&there.matrix, &right, 1e-12)
}

/// The normal equations of a trajectory fit with its inputs differentiated otherwise; `None` where none was derived.
pub(crate) fn otherwise(fit: &Fit<'_>, how: Differentiator) -> Option<Normal> {
    let problem = &fit.problem;
    if problem.records.iter().all(|r| r.derivations.is_empty()) {
        return None;
    }
    let records: Vec<Record> = problem.records.iter().map(|r| r.rederived(how)).collect::<Option<_>>()?;
    let records: Vec<&Record> = records.iter().collect();
    let mut other = Problem::new(problem.system, &problem.terms, &records, &fit.pieces).ok()?;
    (other.continuity, other.belief) = (problem.continuity.clone(), problem.belief);
    other.normal(&fit.x, &fit.weights).ok()
}
