//! Dependence of a result on how columns were differentiated: by how much the numbers would move with another
//! differentiator, estimated by one Gauss-Newton step.

use crate::decisions::{DIFFERENTIATOR_DAMPING, HALF_WIDTH_95};
use crate::least_squares::Normal;
use crate::linear::solve_damped;
use crate::result::quantity::Quantity;
use crate::result::warning::Warning;
use phisindy_signal::Differentiator;

/// A number of the result: its index among the unknowns, what it is, its standard error.
pub(crate) type Number = (usize, Quantity, f64);

/// The warning, if a number would move out of its interval. `normal` gives the normal equations at the
/// solution with columns differentiated otherwise; `here` are those of the solution itself.
pub(crate) fn dependence(
    numbers: &[Number],
    here: &Normal,
    normal: impl Fn(Differentiator) -> Option<Normal>,
) -> Option<Warning> {
    let mut worst: Option<(f64, &Quantity, Differentiator)> = None;
    for how in Differentiator::ALL {
        let Some(step) = normal(how).and_then(|there| step(here, &there)) else { continue };
        for (k, number, error) in numbers {
            let far = step[*k].abs() / (HALF_WIDTH_95 * error);
            if far > 1.0 && worst.is_none_or(|(most, ..)| far > most) {
                worst = Some((far, number, how));
            }
        }
    }
    worst.map(|(half_widths, number, with)| Warning::Differentiator {
        number: number.clone(),
        with,
        half_widths,
    })
}

/// The step from one minimum to the other.
pub(crate) fn step(here: &Normal, there: &Normal) -> Option<Vec<f64>> {
    let right: Vec<f64> = here.gradient.iter().zip(&there.gradient).map(|(a, b)| a - b).collect();
    solve_damped(&there.matrix, &right, DIFFERENTIATOR_DAMPING)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::result::quantity::{ParameterId, ParameterOf};
    use faer::Mat;

    fn named(name: &str) -> Quantity {
        Quantity::Parameter(ParameterId {
            of: ParameterOf::Constant { index: 0, name: name.into() },
            owner: None,
        })
    }

    /// Curvatures 4 and 9: another slope of 8 and 9 moves the minimum by 2 and 1.
    #[test]
    fn the_number_that_moves_farthest_out_of_its_interval_is_named() {
        let of = |gradient: [f64; 2]| Normal {
            cost: 0.0,
            matrix: Mat::from_fn(2, 2, |i, j| if i == j { [4.0, 9.0][i] } else { 0.0 }),
            gradient: gradient.to_vec(),
        };
        let here = of([1.0, 1.0]);
        let told = |errors: [f64; 2], how: Differentiator, there: [f64; 2]| {
            let numbers: Vec<Number> = (0..2).map(|k| (k, named(["a", "b"][k]), errors[k])).collect();
            dependence(&numbers, &here, |other| (other == how).then(|| of(there))).map(|w| w.to_string())
        };
        for how in Differentiator::ALL {
            let says = told([1.0, 0.2], how, [-7.0, -8.0]).expect("b moves by five errors");
            assert!(says.contains(&format!("with {} b would move by 2.6 half-widths", how.name())), "{says}");
            let says = told([0.25, 10.0], how, [9.0, 1.0]).expect("a moves by eight errors");
            assert!(says.contains("a would move by 4.1 half-widths"), "{says}");
        }
        assert_eq!(told([1.03, 0.52], Differentiator::Spline, [-7.0, -8.0]), None);
        assert_eq!(dependence(&[(0, named("a"), 1e-9)], &here, |_| None), None);
    }
}
