//! Which numbers of a result the data do not tell apart.

use crate::decisions::{CORRELATED, VAGUE};
use crate::result::quantity::Quantity;
use crate::result::warning::Warning;
use faer::Mat;

/// Warnings for numbers that the data do not determine, and for pairs that trade off. `names` are the
/// unknowns of the result; `cov` and `values` are of all unknowns.
pub(crate) fn inseparable(cov: &Mat<f64>, names: &[(usize, Quantity)], values: &[f64]) -> Vec<Warning> {
    let mut out = Vec::new();
    let unseen = names.iter().filter(|(a, _)| !cov[(*a, *a)].is_finite()).map(|(_, name)| name.clone());
    let mut numbers: Vec<Quantity> = unseen.collect();
    match numbers.len() {
        0 => {}
        1 => out.push(Warning::Unseen { number: numbers.remove(0) }),
        // A common scale of several numbers is not determined: each may have any value if the others follow.
        _ => out.push(Warning::Inseparable { numbers }),
    }
    for (i, (a, name_a)) in names.iter().enumerate() {
        if !cov[(*a, *a)].is_finite() {
            continue;
        }
        for (b, name_b) in &names[..i] {
            let correlation = cov[(*a, *b)] / (cov[(*a, *a)] * cov[(*b, *b)]).sqrt();
            let vague = |k: usize| cov[(k, k)].sqrt() > VAGUE * values[k].abs();
            if correlation.abs() > CORRELATED && (vague(*a) || vague(*b)) {
                let (first, second) = (name_b.clone(), name_a.clone());
                out.push(Warning::Correlated { first, second, correlation });
            }
        }
    }
    out
}

#[cfg(test)]
mod tests;
