//! How long the segments are of a record that no single run follows.

use crate::decisions::FEWEST_SAMPLES;
use crate::trajectory::error_bars::ErrorBars;
use crate::trajectory::fit::{Context, Fit, transfer};
use crate::trajectory::problem::{Meaning, Problem};
use phisindy_phys::spec::SegmentsSpec;

impl<'a> Context<'a> {
    /// A fit that no single run follows, over the segments that tell its numbers best.
    ///
    /// What a plant without a spring is not told of the forces on it adds up: over a segment of length `T` an
    /// unknown force `f` moves a mass `m` by `f T^2/(2 m)`, and such a residual hangs together over the whole segment.
    /// Shorter segments drift less, but each has a start state to be found first. Their number is doubled as long as
    /// that shrinks the error bars, which know both: correlated samples count as few, and start states are unknowns.
    pub(crate) fn recut(&self, mut fit: Fit<'a>) -> Fit<'a> {
        if self.segments != SegmentsSpec::Auto || fit.pieces.iter().all(|&p| p == 1) {
            return fit;
        }
        let (mut blur, coarse) = (blur(&fit), fit.most_pieces());
        loop {
            let pieces: Vec<usize> = fit.pieces.iter().map(|p| 2 * p).collect();
            let samples = self.records.iter().zip(&pieces).map(|(r, p)| r.len() / p).min().unwrap_or(0);
            let finer = (samples >= FEWEST_SAMPLES).then(|| self.cut_into(&fit, &pieces)).flatten();
            match finer.map(|finer| (self::blur(&finer), finer)) {
                Some((less, finer)) if less < blur => (fit, blur) = (finer, less),
                _ if fit.most_pieces() > coarse => return self.resettle(fit),
                _ => return fit,
            }
        }
    }

    /// A fit with the same terms over other segments, whose start states are free.
    fn cut_into(&self, fit: &Fit<'a>, pieces: &[usize]) -> Option<Fit<'a>> {
        let terms = &fit.problem.terms;
        let problem = Problem::new(self.system, terms, &self.records, pieces).ok()?;
        let mut x = problem.guess(&fit.x[..terms.len()], None, &self.smooth);
        transfer(&fit.problem, &fit.x, &problem, &mut x);
        self.settle(problem, x, fit.noise.clone(), 1)
    }
}

/// How badly a fit knows its numbers: the mean logarithm of their standard errors.
fn blur(fit: &Fit<'_>) -> f64 {
    let bars = ErrorBars::new(fit);
    let meanings = fit.problem.meanings();
    let numbers = (0..meanings.len()).filter(|&k| meanings[k] != Meaning::Start);
    let errors: Vec<f64> = numbers.map(|k| bars.error(k).ln()).filter(|e| e.is_finite()).collect();
    errors.iter().sum::<f64>() / errors.len() as f64
}
