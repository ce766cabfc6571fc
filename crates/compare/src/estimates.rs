//! The numbers of a result with their covariance.

use serde::{Deserialize, Serialize};

/// Half the width of a 95 % interval in standard errors.
pub const HALF_WIDTH_95: f64 = 1.96;

/// What a number is of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Number {
    /// Its name, by which results are matched.
    pub name: String,
    /// Its unit, for people.
    pub unit: String,
    /// How many SI units that unit is.
    pub factor: f64,
}

/// The numbers of a result, in SI.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Estimates {
    /// What they are of.
    pub numbers: Vec<Number>,
    /// Their values.
    #[serde(with = "crate::json_numbers")]
    pub values: Vec<f64>,
    /// Their covariance, in the order of `numbers`.
    #[serde(with = "crate::json_numbers::rows")]
    pub covariance: Vec<Vec<f64>>,
}

impl Number {
    /// The name of a coefficient that was found.
    pub fn of_coefficient(candidate: &str, state: &str) -> String {
        format!("{candidate} in {state}'")
    }
}

impl Estimates {
    /// The standard error of a number.
    pub fn std_error(&self, k: usize) -> f64 {
        self.covariance[k][k].max(0.0).sqrt()
    }

    /// Where a number stands.
    pub fn position(&self, name: &str) -> Option<usize> {
        self.numbers.iter().position(|number| number.name == name)
    }

    /// Adds a number that is held, without an error, unless it is there.
    pub fn hold(&mut self, number: Number, value: f64) {
        if self.position(&number.name).is_none() {
            self.covariance.iter_mut().for_each(|row| row.push(0.0));
            self.covariance.push(vec![0.0; self.numbers.len() + 1]);
            self.numbers.push(number);
            self.values.push(value);
        }
    }

    /// Whether the 95 % interval of a number excludes zero.
    pub(crate) fn differs_from_zero(&self, k: usize) -> bool {
        self.values[k].abs() > HALF_WIDTH_95 * self.std_error(k)
    }

    /// Whether the data determine a number at all.
    pub(crate) fn knows(&self, k: usize) -> bool {
        self.values[k].is_finite() && self.covariance[k][k].is_finite() && self.covariance[k][k] > 0.0
    }
}
