//! Error bars of a fit: the sandwich covariance, stretched where residuals are correlated, and intervals by
//! profile likelihood.

use crate::decisions::STAGES;
use crate::linear::covariance;
use crate::result::estimate::Estimate;
use crate::trajectory::fit::Fit;
use crate::trajectory::profile::interval;
use faer::Mat;

/// The error bars of a fit.
pub(crate) struct ErrorBars<'a> {
    fit: &'a Fit<'a>,
    /// Covariance of all unknowns, for residuals that are independent; infinite on the diagonal for what the
    /// data do not determine.
    pub(crate) sandwich: Mat<f64>,
    /// The inverse of the cost's curvature.
    curvature: Mat<f64>,
    /// Factor on variances for correlated residuals.
    inflation: f64,
}

impl<'a> ErrorBars<'a> {
    /// Of a fit at its minimum.
    pub(crate) fn new(fit: &'a Fit<'a>) -> ErrorBars<'a> {
        ErrorBars {
            fit,
            sandwich: robust_covariance(fit),
            curvature: covariance(&fit.normal.matrix),
            inflation: fit.inflation(),
        }
    }

    /// The standard error of an unknown.
    pub(crate) fn error(&self, k: usize) -> f64 {
        (self.sandwich[(k, k)] * self.inflation).sqrt()
    }

    /// An unknown with its interval by profile likelihood.
    pub(crate) fn estimate(&self, k: usize) -> Estimate {
        // Over short segments a run is nearly linear in its numbers, and a profile would fit all their starts anew.
        if self.fit.most_pieces() > STAGES[0] {
            return self.quadratic(k);
        }
        let (error, curvature) = (self.error(k), self.curvature[(k, k)].sqrt());
        Estimate { value: self.fit.x[k], std_error: error, ci95: interval(self.fit, k, error, curvature) }
    }

    /// An unknown with the interval of a normal distribution.
    pub(crate) fn quadratic(&self, k: usize) -> Estimate {
        Estimate::normal(self.fit.x[k], self.error(k))
    }

    /// The covariance of some unknowns.
    pub(crate) fn covariance(&self, of: &[usize]) -> Vec<Vec<f64>> {
        of.iter().map(|&a| of.iter().map(|&b| self.sandwich[(a, b)] * self.inflation).collect()).collect()
    }
}

/// The sandwich `A^-1 B A^-1`: curvature `A` of the cost, scatter `B` of its gradient. Where the noise model
/// holds it is `A^-1`; directions that the data do not see stay infinite.
pub(crate) fn robust_covariance(fit: &Fit<'_>) -> Mat<f64> {
    let bread = covariance(&fit.normal.matrix);
    let Ok(meat) = fit.problem.meat(&fit.x, &fit.weights) else { return bread };
    let n = bread.nrows();
    let seen: Vec<usize> = (0..n).filter(|&k| bread[(k, k)].is_finite()).collect();
    let pick = |m: &Mat<f64>| Mat::from_fn(seen.len(), seen.len(), |i, j| m[(seen[i], seen[j])]);
    let small = pick(&bread);
    let sandwich = &small * &pick(&meat) * &small;
    // Small-sample correction of the sandwich (HC1).
    let stretch = fit.samples as f64 / fit.samples.saturating_sub(seen.len()).max(1) as f64;
    let mut out = Mat::from_fn(n, n, |i, j| if i == j { f64::INFINITY } else { 0.0 });
    for (i, &a) in seen.iter().enumerate() {
        for (j, &b) in seen.iter().enumerate() {
            out[(a, b)] = sandwich[(i, j)] * stretch;
        }
    }
    out
}
