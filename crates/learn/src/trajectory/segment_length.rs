//! How long the segments are of a record that no single run follows.

use crate::decisions::{SHORTEST_STRETCH, STAGES};
use crate::trajectory::error_bars::ErrorBars;
use crate::trajectory::fit::{Context, Fit, transfer};
use crate::trajectory::jacobian::Jacobian;
use crate::trajectory::problem::{Meaning, Problem};
use phisindy_phys::Record;
use phisindy_phys::spec::SegmentsSpec;

impl<'a> Context<'a> {
    /// The fit of a plant that drifts, over the segments that tell its numbers best.
    ///
    /// What a plant without a spring is not told of the forces on it adds up: over a segment of length `T` an
    /// unknown force `f` moves a mass `m` by `f T^2/(2 m)`, and such a residual hangs together over the whole
    /// segment. Shorter segments drift less, but each has a start state to be found first. Their number is
    /// doubled as long as that shrinks the error bars, which know both: correlated samples count as few, and
    /// start states are unknowns.
    pub(crate) fn resegmented(&self, mut fit: Fit<'a>) -> Fit<'a> {
        let single = fit.pieces.iter().all(|&p| p == 1);
        if fit.problem.chained
            || self.segments != SegmentsSpec::Auto
            || single && fit.is_white()
            || !self.drifts(&fit)
        {
            return fit;
        }
        let (mut blur, coarse) = (blur(&fit), fit.most_pieces());
        loop {
            let pieces: Vec<usize> =
                fit.pieces.iter().map(|&p| if p == 1 { STAGES[0] } else { 2 * p }).collect();
            let samples = self.records.iter().zip(&pieces).map(|(r, p)| r.len() / p).min().unwrap_or(0);
            let finer = (samples >= SHORTEST_STRETCH).then(|| self.cut_into(&fit, &pieces)).flatten();
            match finer.map(|finer| (self::blur(&finer), finer)) {
                Some((less, finer)) if less < blur => (fit, blur) = (finer, less),
                _ if fit.most_pieces() > coarse => return self.resettle(fit),
                _ => return fit,
            }
        }
    }

    /// Whether what disturbs the motion adds up over a record: a mode that neither swings nor fades within
    /// it, or one that grows. A carriage without a spring has one, an inverted pendulum too.
    fn drifts(&self, fit: &Fit<'a>) -> bool {
        let Some(slopes) = Jacobian::new(&fit.problem) else { return false };
        let drifts = |(r, record): (usize, &Record)| {
            let numbers = fit.problem.model_parameters(r, &fit.x);
            let modes = slopes.mean(record, &numbers).and_then(|mean| mean.eigenvalues().ok());
            let span = record.time[record.len() - 1] - record.time[0];
            let adds_up = |re: f64, im: f64| re * span > if im == 0.0 { -1.0 } else { 1.0 };
            modes.is_some_and(|modes| modes.iter().any(|mode| adds_up(mode.re, mode.im)))
        };
        self.smooth.iter().enumerate().any(drifts)
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
