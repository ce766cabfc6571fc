//! How the numbers of a fit move with the constants that the spec holds.
//!
//! With the constants as unknowns beside the others, `(H, h)` are the columns of the normal equations of what was
//! estimated and of one constant `c`. The minimum moves by `d theta = -H^-1 h dc` (the implicit function theorem).

use crate::decisions::PROFILE_DAMPING;
use crate::linear::solve_damped;
use crate::result::held::HeldConstant;
use crate::result::quantity::Quantity;
use crate::trajectory::fit::Fit;
use crate::trajectory::problem::Problem;
use faer::Mat;
use phisindy_phys::System;

/// How each of the unknowns `numbers` moves with each constant; `freed` has these as parameters after its own.
/// Empty where the model cannot be run with one of them as a number; not a number for one that `near_zero` says is not
/// told from zero.
pub(crate) fn elasticities(
    freed: &System,
    fit: &Fit<'_>,
    numbers: &[(usize, Quantity)],
    near_zero: &dyn Fn(usize) -> bool,
) -> Vec<HeldConstant> {
    let own = &fit.problem;
    let Ok(mut problem) = Problem::new(freed, &own.terms, &own.records, &fit.pieces) else { return vec![] };
    (problem.continuity, problem.belief) = (own.continuity.clone(), own.belief);
    problem.following = own.following.clone();
    let held = &freed.parameters[own.system.parameters.len()..];
    // Shared parameters stand behind the coefficients, and the constants behind those.
    let first = own.terms.len() + own.system.parameters.iter().filter(|p| !p.each).count();
    let at = |k: usize| if k < first { k } else { k + held.len() };
    let mut x = vec![0.0; problem.unknowns];
    (0..own.unknowns).for_each(|k| x[at(k)] = fit.x[k]);
    held.iter().enumerate().for_each(|(j, p)| x[first + j] = p.start);
    let Ok(normal) = problem.normal(&x, &fit.weights) else { return vec![] };
    let n = own.unknowns;
    let free = |k: usize| fit.x[k] > own.bounds[k].0 && fit.x[k] < own.bounds[k].1;
    let matrix =
        Mat::from_fn(n, n, |i, j| if free(i) && free(j) { normal.matrix[(at(i), at(j))] } else { 0.0 });
    let of = |(j, p): (usize, &phisindy_phys::Parameter)| {
        let right: Vec<f64> =
            (0..n).map(|i| if free(i) { -normal.matrix[(at(i), first + j)] } else { 0.0 }).collect();
        let moved = solve_damped(&matrix, &right, PROFILE_DAMPING)?;
        let of = |(i, (k, number)): (usize, &(usize, Quantity))| {
            let part = if near_zero(i) { f64::NAN } else { moved[*k] * p.start / fit.x[*k] };
            (number.clone(), part)
        };
        let moves = numbers.iter().enumerate().map(of).collect();
        Some(HeldConstant { name: p.name.clone(), moves })
    };
    held.iter().enumerate().filter_map(of).collect()
}
