//! Warnings about covariances that are written down.

use super::*;
use crate::result::quantity::{ParameterId, ParameterOf};

fn texts(warnings: &[Warning]) -> Vec<String> {
    warnings.iter().map(ToString::to_string).collect()
}

fn named(name: &str) -> Quantity {
    let of = ParameterOf::Constant { index: 0, name: name.to_owned() };
    Quantity::Parameter(ParameterId { of, owner: None })
}

#[test]
fn what_trades_off_is_told_unless_both_are_known_well() {
    let names = [(0, named("a")), (2, named("b"))];
    // Errors of 0.1 of 1 and of 0.2 of 4; the third number is a start.
    let told = |correlation: f64, values: [f64; 2]| {
        let mut cov = Mat::zeros(3, 3);
        (cov[(0, 0)], cov[(2, 2)], cov[(1, 1)]) = (0.01, 0.04, f64::INFINITY);
        (cov[(0, 2)], cov[(2, 0)]) = (0.02 * correlation, 0.02 * correlation);
        texts(&inseparable(&cov, &names, &[values[0], 7.0, values[1]]))
    };
    for (correlation, known) in [(0.96, "difference"), (-0.97, "sum")] {
        for values in [[1.0, 4.0], [-1.0, 40.0], [10.0, 4.0]] {
            let says = format!(
                "a and b trade off (correlation {correlation:.3}): their {known} is known better than either"
            );
            assert!(told(correlation, values).concat().starts_with(&says));
        }
        assert_eq!(told(correlation, [10.0, 40.0]), [""; 0]);
    }
    assert_eq!(told(0.94, [1.0, 4.0]), [""; 0]);
}

#[test]
fn what_is_not_seen_is_told_by_its_name() {
    let names = [(0, named("a")), (1, named("b")), (2, named("c"))];
    let told = |open: &[usize]| {
        let mut cov: Mat<f64> = Mat::identity(3, 3);
        open.iter().for_each(|&k| cov[(k, k)] = f64::INFINITY);
        texts(&inseparable(&cov, &names, &[1.0; 3]))
    };
    assert_eq!(told(&[]), [""; 0]);
    assert_eq!(told(&[1]), ["the data say nothing about b: give it a value, or leave it out"]);
    assert!(told(&[0, 2]).concat().starts_with("the data do not tell a, c apart: "));
    assert_eq!(told(&[0, 1, 2]).len(), 1);
}
