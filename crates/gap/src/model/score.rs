//! The score of a fitted model: all numbers that the search and its end decide on.

use super::occam_factor::OccamFactor;
use crate::decisions::{
    CHANCE, EARLY_PRICE, EXPLAINED, FAR_OFF, INDEPENDENT, INPUT_PRICE, NOT_WHITE, SENSOR_PRICE, SURE,
};

/// How well a model follows the records, and what it costs.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Score {
    /// The gap: rms of residual / noise over all columns and samples of the Fit records.
    pub(crate) fit: f64,
    /// The same for the Validate records, if there are any.
    pub(crate) validate: Option<f64>,
    /// The gap on Validate records after allowing for the errors of the fitted parameters, where that was
    /// computed; otherwise equal to `validate`.
    pub(crate) predictive: Option<f64>,
    /// The gap below which the error of the simulation is all that is left.
    pub(crate) least: f64,
    /// The largest whiteness score of any column; see [`crate::whiteness`].
    pub(crate) whiteness: f64,
    /// Samples of the Fit records.
    pub(crate) samples: usize,
    /// Samples of the records on which the gap for decisions is measured.
    pub(crate) judged: usize,
    /// Effective number of independent samples.
    pub(crate) effective: f64,
    /// Number of effects.
    pub(crate) effects: usize,
    /// Parameters of all effects.
    pub(crate) parameters: usize,
    /// What these cost.
    pub(crate) occam: OccamFactor,
    /// Number of effects that are properties of sensors.
    pub(crate) sensors: usize,
    /// Number of effects that are properties of inputs.
    pub(crate) inputs: usize,
    /// Number of sensor properties that are negative delays.
    pub(crate) early: usize,
}

impl Score {
    /// The score where so many numbers more leave this mean square of so many independent samples.
    pub(crate) fn of_samples(&self, left: f64, samples: usize, numbers: usize) -> Score {
        let (effective, occam) = (samples as f64, OccamFactor::new(numbers, samples as f64));
        let fit = left.sqrt();
        Score { fit, validate: None, predictive: None, samples, effective, occam, ..self.clone() }
    }

    /// The gap used for decisions: on Validate records, with the errors of the parameters allowed for, if
    /// there are any; else on Fit records.
    pub(crate) fn gap(&self) -> f64 {
        self.predictive.unwrap_or(self.fit)
    }

    /// Whether the residual is white.
    pub(crate) fn is_white(&self) -> bool {
        self.whiteness < NOT_WHITE
    }

    /// Whether the error of the simulation is all that is left.
    pub(crate) fn is_exact(&self) -> bool {
        self.fit.max(self.gap()) <= self.least
    }

    /// Whether the residual is white and the gap is at the noise level, on Validate records too.
    pub(crate) fn explains(&self) -> bool {
        self.is_white() && self.gap() < self.at_noise()
    }

    /// The largest gap of a model that leaves noise alone: what is no force that matters, or what chance makes of the
    /// mean square of so few samples.
    fn at_noise(&self) -> f64 {
        EXPLAINED.max((1.0 + CHANCE * (2.0 / self.judged.max(1) as f64).sqrt()).sqrt())
    }

    /// The criterion, smaller is better: twice the negative log-likelihood plus a price for what was added.
    /// `candidates` is the number of effects that were available, `independent` the fraction of samples that
    /// counts.
    ///
    /// Far from the noise a rich law adapts to the Fit records whatever is missing, so the gap on the
    /// Validate records replaces the one on Fit records.
    ///
    /// The misfit itself sets the scatter. A real rig leaves many times its sensor noise, and a law that removes one per cent
    /// of that explains nothing. A column with few samples in a period gives too large a noise, which must hide no law.
    pub(crate) fn criterion(&self, candidates: usize, independent: f64) -> f64 {
        let n = self.samples as f64;
        // The misfit of the free run: segments with their own start states would flatter a model that cannot
        // be simulated.
        let ratio = match self.validate {
            Some(validate) if self.fit > FAR_OFF => validate.max(FAR_OFF).powi(2),
            _ => self.fit.powi(2),
        };
        let scatter = ratio.max(self.least.powi(2));
        let cost = n * (scatter.ln() + ratio / scatter);
        cost * independent + self.price(candidates, independent)
    }

    /// What was added costs so much of the criterion.
    pub(crate) fn price(&self, candidates: usize, independent: f64) -> f64 {
        let numbers = self.occam.price(self.part(independent));
        // A late sensor is plausible, an early one is not. In an autonomous motion the two are
        // indistinguishable.
        let odd = SENSOR_PRICE * self.sensors as f64
            + INPUT_PRICE * self.inputs as f64
            + EARLY_PRICE * self.early as f64;
        numbers + 2.0 * ln_choose(candidates, self.effects) + odd
    }

    /// What counts of the samples in units of the noise, where the misfit itself sets the scatter.
    pub(crate) fn part(&self, independent: f64) -> f64 {
        independent / self.fit.max(self.least).powi(2)
    }

    /// The fraction of samples that counts as independent.
    pub(crate) fn independent(&self) -> f64 {
        let part = self.effective / self.samples.max(1) as f64;
        if part > INDEPENDENT || self.is_white() { 1.0 } else { part }
    }
}

/// By how much the criteria of two models of one cause each may differ for what they cost beforehand alone.
pub(crate) fn most_apart_beforehand(candidates: usize) -> f64 {
    2.0 * ln_choose(candidates, 1) + SENSOR_PRICE.max(INPUT_PRICE)
}

/// ln of the binomial coefficient.
fn ln_choose(n: usize, k: usize) -> f64 {
    (0..k.min(n)).map(|i| ((n - i) as f64 / (i + 1) as f64).ln()).sum()
}

/// The terms of the criterion that all compared models share: the number of available effects and the
/// fraction of independent samples.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Measure {
    candidates: usize,
    independent: f64,
}

impl Measure {
    /// The measure for these models; the residual of the best one sets the fraction of independent samples.
    pub(crate) fn of<'s>(all: impl IntoIterator<Item = &'s Score>, candidates: usize) -> Measure {
        let best = all.into_iter().min_by(|a, b| a.fit.total_cmp(&b.fit));
        Measure { candidates, independent: best.map_or(1.0, Score::independent) }
    }

    /// The same where so many effects were available.
    pub(crate) fn among(self, candidates: usize) -> Measure {
        Measure { candidates, ..self }
    }

    /// The criterion of a model; smaller is better.
    pub(crate) fn criterion(self, of: &Score) -> f64 {
        of.criterion(self.candidates, self.independent)
    }
}

/// Whether what lowers the criterion by `gain` is sure beside rivals that lower it by so much.
pub(crate) fn is_sure(gain: f64, rivals: impl Iterator<Item = f64>) -> bool {
    probability_beside(rivals.map(|other| gain - other)) >= SURE
}

/// The probability of a model beside rivals whose criterion is so much higher.
pub(crate) fn probability_beside(rivals: impl Iterator<Item = f64>) -> f64 {
    let against: f64 = rivals.map(|behind| (-0.5 * behind).exp()).sum();
    (1.0 + against).recip()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A score with these gaps and one parameter for each effect; white where the gap is small.
    pub(crate) fn score(fit: f64, validate: Option<f64>, effects: usize) -> Score {
        Score {
            fit,
            validate,
            predictive: validate,
            least: 1e-3,
            whiteness: if fit < 1.05 { 1.0 } else { 50.0 },
            samples: 1000,
            judged: 1000,
            effective: 1000.0,
            effects,
            parameters: effects,
            occam: OccamFactor::new(effects, 1000.0),
            sensors: 0,
            inputs: 0,
            early: 0,
        }
    }

    #[test]
    fn a_short_record_may_leave_more_than_noise_by_chance() {
        let short = |judged: usize, fit: f64| Score { judged, ..score(fit, None, 1) };
        let white = |s: Score| Score { whiteness: 1.0, ..s };
        // Three standard deviations of the mean of 200 squares are 0.3 of it.
        assert!(white(short(200, 1.13)).explains() && !white(short(200, 1.15)).explains());
        assert!(!white(short(5000, 1.09)).explains() && white(short(5000, 1.07)).explains());
    }

    /// Two pushes of four numbers each: what they explain pays for them, or does not.
    #[test]
    fn numbers_of_some_samples_have_their_price() {
        let base = score(1.2, Some(9.0), 0);
        let of = |left: f64, numbers: usize| base.of_samples(left, 1000, numbers).criterion(30, 1.0);
        let gain = |left: f64| of(1.44, 0) - of(left, 8);
        assert!(gain(1.0) > 200.0 && gain(1.4) < 0.0, "{} {}", gain(1.0), gain(1.4));
    }

    #[test]
    fn the_criterion_prices_what_was_added() {
        let plain = score(1.0, None, 1);
        let dearer = [
            Score { parameters: 2, occam: OccamFactor::new(2, 1000.0), ..plain.clone() },
            Score { sensors: 1, ..plain.clone() },
            Score { fit: 1.1, ..plain.clone() },
            Score { effects: 2, ..plain.clone() },
        ];
        for other in dearer {
            assert!(other.criterion(30, 1.0) > plain.criterion(30, 1.0), "{other:?}");
        }
        // BIC's price of one parameter on a thousand samples, the half of Jeffreys, and the choice of one among thirty.
        let none = score(1.0, None, 0);
        let price = plain.criterion(30, 1.0) - none.criterion(30, 1.0);
        assert!((price - 4000_f64.ln() - 2.0 * 30_f64.ln()).abs() < 1e-9, "{price}");
        // Where the noise was taken too large the misfit tells models apart as it does above it, down to the error of the
        // simulation.
        let gain = |from, to| score(from, None, 1).criterion(30, 1.0) - score(to, None, 1).criterion(30, 1.0);
        let small = gain(0.2, 0.1);
        assert!((gain(8.0, 4.0) - small).abs() < 1e-9 && gain(4e-4, 2e-4) < 0.1 * small, "{small}");
        // Far from the noise Validate records count.
        let far = |fit, validate| score(fit, Some(validate), 0).criterion(30, 1.0);
        assert!(far(9.0, 8.0) < far(9.0, 10.0) && far(9.0, 10.0) == far(5.0, 10.0));
    }
}
