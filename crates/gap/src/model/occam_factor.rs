//! The price of the numbers of a model: how much of what was believed before the records leave.
//!
//! The evidence of a model is its likelihood times the part of the prior that the records leave, the Occam factor:
//! `-2 ln Z = chi^2 + ln det(1 + S A S)` with the curvature `A` of the cost, start states and the constants of the model
//! eliminated, and the covariance `S S` of the prior (D. J. C. MacKay, Neural Computation 4 (1992) 415-447,
//! doi 10.1162/neco.1992.4.3.415).
//!
//! - A coefficient has the prior that moves the motion by as much as the model without effects misses it:
//!   `S S = g A^-1`, with the chi square that this model leaves for `g` (A. Zellner's g-prior with the `g` of the data:
//!   E. I. George and D. P. Foster, Biometrika 87 (2000) 731-747, doi 10.1093/biomet/87.4.731), and no less than one
//!   sample's worth, `g` = the number of samples (G. Schwarz 1978, doi 10.1214/aos/1176344136). It does not depend on
//!   units, on what a column is scaled by, or on how columns hang together.
//! - The logarithm of a positive number inside a law is uniform over the range from what a record resolves to its motion.
//!   Where the records do not see it, it costs nothing.
//! - Of two laws the one with a number less is twice as likely beforehand: the simplicity postulate of D. Wrinch and
//!   H. Jeffreys (Philosophical Magazine 42 (1921) 369-390, doi 10.1080/14786442108633773). A plain law shares with all its
//!   variants: were each as likely, ten of them would outweigh it whatever is measured.

use super::trial_model::{Applied, TrialModel};
use crate::decisions::INNER_RANGE;
use faer::{Mat, Side};
use phisindy_learn::Calibration;
use std::f64::consts::{LN_2, TAU};

/// What each number costs beforehand: it halves the probability.
const SIMPLICITY: f64 = 2.0 * LN_2;

/// The Occam factor of a model.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct OccamFactor {
    /// Coefficients.
    coefficients: usize,
    /// What the records see of one of them, in units of its prior.
    unit: f64,
    /// The same along each direction of the numbers inside the laws.
    inner: Vec<f64>,
}

impl OccamFactor {
    /// The price of all numbers, twice a negative logarithm, where so large a part of the samples counts.
    pub(crate) fn price(&self, part: f64) -> f64 {
        let inner: f64 = self.inner.iter().map(|seen| (part * seen).ln_1p() + SIMPLICITY).sum();
        self.coefficients as f64 * self.of_coefficient(part) + inner
    }

    /// The price of one coefficient.
    pub(crate) fn of_coefficient(&self, part: f64) -> f64 {
        (part * self.unit).max(2.0).ln() + SIMPLICITY
    }

    /// Of so many coefficients, whose prior is worth so many samples.
    pub(crate) fn new(coefficients: usize, unit: f64) -> OccamFactor {
        OccamFactor { coefficients, unit, inner: vec![] }
    }

    /// Of the effects of a fitted model.
    pub(crate) fn of(model: &TrialModel, cal: &Calibration) -> OccamFactor {
        let mut inner: Vec<(usize, f64)> =
            model.effects.iter().flat_map(|applied| inside(applied, cal)).collect();
        let coefficients = model.size() - inner.len();
        // What the records do not see at all costs nothing.
        inner.retain(|&(at, _)| cal.curvature[at][at].is_finite());
        // The relative variance that the records leave, in units of the prior.
        let left = Mat::from_fn(inner.len(), inner.len(), |i, j| {
            let ((i, a), (j, b)) = (inner[i], inner[j]);
            let values = cal.parameters[i].estimate.value * cal.parameters[j].estimate.value;
            cal.curvature[i][j] / values * TAU / (a * b)
        });
        let directions = if inner.is_empty() { None } else { left.self_adjoint_eigen(Side::Lower).ok() };
        let inner = directions.map_or(vec![], |eigen| {
            (0..inner.len()).map(|k| eigen.S()[k].max(f64::EPSILON).recip()).collect()
        });
        OccamFactor { coefficients, unit: model.missed.max(cal.samples as f64), inner }
    }
}

/// The positive numbers inside the law of an effect: their places among the parameters of a fit, each with the range of
/// its logarithm.
fn inside(applied: &Applied, cal: &Calibration) -> Vec<(usize, f64)> {
    let law = &applied.effect.entry.law;
    let linear = law.linear_parameters();
    let ranged = |k: usize| {
        let (low, high) = law.parameters[k].1.within;
        let inner = !linear.contains(&k) && !law.parameters[k].1.each && low > 0.0 && high > low;
        let at = cal.parameters.iter().position(|p| p.id.constant() == Some(applied.parameters[k]))?;
        (inner && cal.parameters[at].estimate.value > 0.0).then(|| (at, (high / low).min(INNER_RANGE).ln()))
    };
    (0..law.parameters.len()).filter_map(ranged).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_models::{effect, fitted, model};

    const STRIBECK: &str = include_str!("../../../phys/laws/stribeck.ron");

    /// A force that was missed by far has a wide prior, and costs more than one that was hardly missed. The same holds for
    /// what the records see of a number inside a law.
    #[test]
    fn a_number_costs_what_its_prior_held_open() {
        let of = |noise: &str| {
            let (base, noise) = model(
                &r#"(states: { "x": "m", "v": "m/s" }, constants: { "k": (1.0, "N/m"), "m": (1.0, "kg"), "c": (0.1, "N*s/m"), "F0": (1.0, "N"), "W": (0.7, "rad/s") },
                known: { "x": "v", "v": "(-k*x - c*v + F0*cos(W*t))/m" }, inertia: { "v": "m" }, unknown: {},
                data: [ Synthetic(truth: { "v": "-(0.1 + 0.1*exp(-(v/0.3)^2))*sgn(v)" }, start: { "x": 1.0, "v": 0.0 }, duration: 40.0, step: 0.05, noise: Additive(NOISE), seed: 1) ])"#
                    .replace("NOISE", noise),
            );
            let model = fitted(base, &noise).settled();
            let law = effect(&model, "stribeck", STRIBECK, "v", &[0.1, 0.2, 0.3]);
            fitted(model.with(&law).expect("a model"), &noise).score.occam
        };
        let (clean, noisy) = (of("0.001"), of("0.02"));
        assert_eq!((clean.coefficients, clean.inner.len()), (2, 1));
        assert!(clean.price(1.0) > noisy.price(1.0) + 5.0, "{clean:?} {noisy:?}");
        let part = |of: &OccamFactor| of.inner[0].ln_1p();
        assert!(part(&clean) > part(&noisy) && part(&noisy) > 0.0, "{clean:?} {noisy:?}");
        // One sample's worth at least.
        assert!(noisy.of_coefficient(1.0) >= 1600f64.ln());
    }
}
