//! Motion that forgets its start: how fast, and what a model of it can be judged by.
//!
//! Where a disturbance outgrows the motion within the record, no run from a fitted start follows it, however
//! right the model is. What remains: each segment of the chain is predicted from its own start, and what the
//! motion keeps, its mean and its size, is that of a free run too.

use crate::decisions::{CHAOTIC_MEAN, CHAOTIC_SIZE, WORST_NRMSE};
use crate::result::record_fit::RecordFit;
use crate::result::warning::Chaos;
use crate::trajectory::fit::Fit;
use crate::trajectory::problem::{Noise, Problem};
use crate::trajectory::validated_chain::ValidatedChain;
use phisindy_signal::{effective_samples, standard_deviation};

impl Chaos {
    /// Of a chain of fitted records; `None` for single runs, and where no start grows. `fits` are their free
    /// runs.
    pub(crate) fn of_fit(fit: &Fit<'_>, fits: &[&RecordFit]) -> Option<Chaos> {
        if !fit.problem.chained || fit.most_pieces() == 1 {
            return None;
        }
        Chaos::of(&fit.problem, &fit.x, &fit.noise, fits)
    }

    /// Of the chain of a Validate record and its free run.
    pub(crate) fn of_validated(chain: &ValidatedChain<'_>, free: &RecordFit) -> Option<Chaos> {
        Chaos::of(&chain.problem, &chain.x, &chain.noise, &[free])
    }

    fn of(problem: &Problem<'_>, x: &[f64], noise: &Noise, fits: &[&RecordFit]) -> Option<Chaos> {
        let exponent = exponent(problem, x).filter(|e| *e > 0.0)?;
        let residuals = problem.residuals(x).ok()?;
        let pieces = |r: usize| problem.segments.iter().filter(|s| s.record == r).count();
        let pieces = (0..fits.len()).map(pieces).max()?;
        let mut out = Chaos { pieces, exponent, nrmse: 0.0, noise: 0.0, mean: 0.0, size: 1.0 };
        for (r, free) in fits.iter().enumerate() {
            free.run.as_ref()?;
            for (k, column) in problem.records[r].columns.iter().enumerate() {
                let Some(column) = column else { continue };
                let deviation = problem.deviations[r][k];
                let noise = noise[r][k].variance(deviation).sqrt();
                let left = &residuals[r][k].residual;
                let nrmse = (left.iter().map(|e| e * e).sum::<f64>() / left.len() as f64).sqrt() / deviation;
                if nrmse > out.nrmse {
                    (out.nrmse, out.noise) = (nrmse, noise / deviation);
                }
                let column = problem.records[r].own_times.of(k, column);
                let run: Vec<f64> =
                    column.iter().zip(free.own_residual(k).iter()).map(|(x, e)| x - e).collect();
                out.mean = out.mean.max(distance_of_means(&column, &run));
                let size = (standard_deviation(&run).powi(2) + noise * noise).sqrt() / deviation;
                out.size = out.size.max(size).max(1.0 / size);
            }
        }
        Some(out)
    }

    /// The worse of two in each number.
    pub(crate) fn worse(self, other: Chaos) -> Chaos {
        let worst = if other.nrmse > self.nrmse { &other } else { &self };
        Chaos {
            pieces: self.pieces.max(other.pieces),
            exponent: self.exponent.max(other.exponent),
            nrmse: worst.nrmse,
            noise: worst.noise,
            mean: self.mean.max(other.mean),
            size: self.size.max(other.size),
        }
    }

    /// Whether the model is one of the motion.
    pub(crate) fn holds(&self) -> bool {
        self.nrmse < WORST_NRMSE && self.mean < CHAOTIC_MEAN && self.size < CHAOTIC_SIZE
    }
}

/// The difference of the means of two motions, in its standard errors: neighbouring samples are one.
fn distance_of_means(a: &[f64], b: &[f64]) -> f64 {
    let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
    let error = |x: &[f64]| {
        let centre = mean(x);
        let rest: Vec<f64> = x.iter().map(|v| v - centre).collect();
        standard_deviation(x).powi(2) / effective_samples(&rest).max(1.0)
    };
    (mean(a) - mean(b)).abs() / (error(a) + error(b)).sqrt().max(f64::MIN_POSITIVE)
}

/// The largest Lyapunov exponent: the mean rate at which a disturbance grows along the chain (Benettin et
/// al., Meccanica 15 (1980) 9-20). `None` where a segment cannot be simulated.
fn exponent(problem: &Problem<'_>, x: &[f64]) -> Option<f64> {
    let n = problem.system.states.len();
    let (mut logarithm, mut time) = (0.0, 0.0);
    let mut disturbance: Vec<f64> = problem.scale.clone();
    for segment in &problem.segments {
        let record = problem.records[segment.record];
        let (first, last) = segment.samples;
        if first == 0 {
            disturbance.clone_from(&problem.scale);
        }
        if problem.next(segment).is_none() {
            continue;
        }
        let run = problem.run(segment, x, true).ok()?.run;
        let i = last - first;
        let grown: Vec<f64> = (0..n)
            .map(|k| (0..n).map(|j| run.sensitivities[(i * run.n + k) * run.m + j] * disturbance[j]).sum())
            .collect();
        let size = |d: &[f64]| d.iter().zip(&problem.scale).map(|(d, s)| (d / s).powi(2)).sum::<f64>().sqrt();
        let factor = size(&grown) / size(&disturbance);
        logarithm += factor.ln();
        time += record.time[last] - record.time[first];
        disturbance = grown.iter().map(|g| g / size(&grown)).collect();
    }
    (time > 0.0).then(|| logarithm / time).filter(|e| e.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::line_models::scatter;

    #[test]
    fn means_are_as_far_apart_as_their_errors_allow() {
        let a = scatter(4000);
        assert!(distance_of_means(&a, &a) < 1e-12);
        let deviation = standard_deviation(&a);
        let apart: Vec<f64> = a.iter().map(|x| x + 10.0 * deviation * (2.0 / 4000.0_f64).sqrt()).collect();
        let found = distance_of_means(&a, &apart);
        assert!((found - 10.0).abs() < 2.0, "{found}");
        // Samples that are held for twenty count as few.
        let held = |x: &[f64]| (0..4000).map(|i| x[i / 20 * 20]).collect::<Vec<f64>>();
        assert!(distance_of_means(&held(&a), &held(&apart)) < 0.5 * found);
    }

    #[test]
    fn another_motion_is_not_the_one_of_the_data() {
        let right = Chaos { pieces: 100, exponent: 0.9, nrmse: 0.2, noise: 0.2, mean: 2.0, size: 1.1 };
        assert!(right.holds());
        assert!(!Chaos { nrmse: 0.6, ..right.clone() }.holds());
        assert!(!Chaos { mean: 7.0, ..right.clone() }.holds());
        assert!(!Chaos { size: 2.5, ..right }.holds());
    }
}
