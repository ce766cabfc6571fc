//! One trajectory fit: from a first guess to the minimum, with the noise estimated along the way.
//!
//! Far from the truth the cost of a whole record has local minima, so the horizon grows: first many short
//! segments, whose start states come from the data, then few, then one. A record whose single run is much
//! worse than its segments (it drifts or is unstable) stays segmented.

use crate::decisions::{
    BUDGET_BASE, BUDGET_FACTOR, CHAIN_MINIMUM, DRIFT, FINE_MINIMUM, HOP_GAIN, HOPELESS, HOPS,
    LIKELIHOOD_GAIN, REFIT_ITERATIONS, ROUGH_MINIMUM, SPOILED, STAGES, START_GAIN, STRAIGHT_PROMISE,
    TIGHTENING, TRIAL_MINIMUM, WHITE_EXCESS, WHITE_PART,
};
use crate::least_squares::{Limits, Normal};
use crate::trajectory::problem::{Meaning, Noise, Problem};
use crate::trajectory::random_force::RandomForce;
use crate::trajectory::tally::{Tally, inflation, tally, weighed, whitened, whitened_by};
use phisindy_phys::spec::SegmentsSpec;
use phisindy_phys::{Record, System};
use phisindy_signal::{noise_level, whiteness_p_value};
use phisindy_sim::Stop;

/// A fitted model.
pub(crate) struct Fit<'a> {
    pub(crate) problem: Problem<'a>,
    /// The unknowns at the minimum.
    pub(crate) x: Vec<f64>,
    pub(crate) noise: Noise,
    /// Weights of all samples.
    pub(crate) weights: Vec<Vec<Vec<f64>>>,
    pub(crate) normal: Normal,
    /// Number of residuals.
    pub(crate) samples: usize,
    /// Number of independent residuals (effective sample size).
    pub(crate) effective: f64,
    /// Variance of the residuals over that of their white part (by the spectrum above the motion).
    pub(crate) excess: f64,
    /// Segments of each record.
    pub(crate) pieces: Vec<usize>,
    /// The forces that are left; `None` where free runs leave only noise.
    pub(crate) force: Option<RandomForce>,
}

/// What all fits of a case share.
pub(crate) struct Context<'a> {
    pub(crate) system: &'a System,
    pub(crate) records: Vec<&'a Record>,
    /// Smoothed records, to start from.
    pub(crate) smooth: Vec<Record>,
    pub(crate) segments: SegmentsSpec,
    /// Ends minimisations where they are.
    pub(crate) stop: Stop,
}

impl<'a> Context<'a> {
    /// A problem of these terms, each record cut into `pieces[r]` segments of equal length.
    pub(crate) fn cut(&self, terms: &[usize], pieces: &[usize]) -> Option<Problem<'a>> {
        let mut problem = Problem::new(self.system, terms, &self.records, pieces).ok()?;
        problem.stop = self.stop.clone();
        Some(problem)
    }

    /// A problem of these terms, each record cut into so many segments.
    pub(crate) fn evenly_cut(&self, terms: &[usize], pieces: usize) -> Option<Problem<'a>> {
        self.cut(terms, &vec![pieces; self.records.len()])
    }

    /// Fits `terms` from scratch. `None` if the model cannot be simulated from any start tried.
    pub(crate) fn fresh_fit(&self, terms: &[usize], coefficients: &[f64]) -> Option<Fit<'a>> {
        let fit = self.over_segments(terms, coefficients)?;
        Some(self.grown(&fit, coefficients).unwrap_or(fit))
    }

    /// Fits `terms` over fewer and fewer segments.
    fn over_segments(&self, terms: &[usize], coefficients: &[f64]) -> Option<Fit<'a>> {
        let mut values = coefficients.to_vec();
        let mut parameters: Option<Vec<f64>> = None;
        let mut before: Option<(f64, Fit<'a>)> = None;
        let mut finest: Option<Fit<'a>> = None;
        if let Some(fit) = self.at_once(terms, coefficients) {
            return Some(fit);
        }
        let stages: Vec<usize> = match self.segments {
            SegmentsSpec::Auto => STAGES.to_vec(),
            SegmentsSpec::Count(n) => {
                STAGES.iter().copied().filter(|&s| s > n as usize).chain([n as usize]).collect()
            }
        };
        for &pieces in &stages {
            let begun = |values: &[f64], parameters: Option<&[f64]>, from: Option<&Fit<'a>>| {
                let mut problem = self.evenly_cut(terms, pieces)?;
                problem.budget = from.map(|fit| fit.budget(fit.most_pieces().div_ceil(pieces)));
                let mut x = problem.guess(values, parameters, &self.smooth);
                if let Some(fit) = from {
                    transfer(&fit.problem, &fit.x, &problem, &mut x);
                }
                let noise = problem.first_noise();
                self.settle(problem, x, noise, 1)
            };
            let mut fit = begun(&values, parameters.as_deref(), before.as_ref().map(|(_, fit)| fit));
            if let Some(fine) = &finest {
                let size = |fit: &Option<Fit<'_>>| {
                    fit.as_ref().and_then(|fit| self.misfit(fit)).unwrap_or(f64::INFINITY)
                };
                if size(&fit) > SPOILED * self.misfit(fine)? {
                    let other = begun(&fine.x[..terms.len()], self.shared(fine).as_deref(), Some(fine));
                    if size(&other) < size(&fit) {
                        fit = other;
                    }
                }
            }
            let Some(fit) = fit else {
                if before.is_some() {
                    break;
                } else {
                    continue;
                };
            };
            // The noise estimate, and with it the weights, differ between stages: compare residuals in the
            // units of the columns.
            let size = self.misfit(&fit)?;
            if let Some((last, _)) = &before
                && pieces == 1
                && size > DRIFT * last
                && self.segments == SegmentsSpec::Auto
            {
                let straight = self.straight(&fit);
                if let Some(fit) =
                    straight.filter(|f| self.misfit(f).is_some_and(|size| size <= DRIFT * last))
                {
                    return Some(fit);
                }
                // Back to many segments, joined with the standard deviation of their jumps.
                let Fit { mut problem, x, noise, .. } = finest?;
                problem.continuity = problem.jumps(&x).ok();
                return self.settle(problem, x, noise, 3);
            }
            values = fit.x[..terms.len()].to_vec();
            parameters = self.shared(&fit);
            let last = before.replace((size, fit));
            finest = finest.or(last.map(|(_, fit)| fit));
        }
        let (_, fit) = before?;
        let Fit { problem, x, noise, .. } = fit;
        let fit = self.settle(problem, x, noise, 3).map(|fit| self.with_scaled_coefficients(fit))?;
        Some(self.straight(&fit).unwrap_or(fit))
    }

    /// A fit in one run of each record from the first guess, where that follows the records about as well as
    /// short segments do: then these would not lead to a better start. `None` if it drifts away or ends in a
    /// worse minimum.
    fn at_once(&self, terms: &[usize], coefficients: &[f64]) -> Option<Fit<'a>> {
        if self.segments != SegmentsSpec::Auto {
            return None;
        }
        let short = self.misfit_of_guess(terms, coefficients)?;
        let problem = self.evenly_cut(terms, 1)?;
        let x = problem.guess(coefficients, None, &self.smooth);
        if misfit(&problem, &x)? > DRIFT * short {
            return None;
        }
        let noise = problem.first_noise();
        let Fit { problem, x, noise, .. } = self.settle(problem, x, noise, 1)?;
        if misfit(&problem, &x)? > SPOILED * short {
            return None;
        }
        let fit = self.settle(problem, x, noise, 3).map(|fit| self.with_scaled_coefficients(fit))?;
        Some(self.straight(&fit).unwrap_or(fit))
    }

    /// A fit of a model without dictionary in one run from the start values of the spec, if it is better than
    /// `found`. After an earlier fit it is; with clearances the segments may end in a wrong minimum.
    fn straight(&self, found: &Fit<'a>) -> Option<Fit<'a>> {
        if !found.problem.terms.is_empty() || self.segments != SegmentsSpec::Auto {
            return None;
        }
        let problem = self.evenly_cut(&[], 1)?;
        let x = problem.guess(&[], None, &self.smooth);
        let least = self.misfit(found)?;
        if misfit(&problem, &x)? > STRAIGHT_PROMISE * least {
            return None;
        }
        let fit = self.settle(problem, x, found.noise.clone(), 3)?;
        (self.misfit(&fit)? < least).then_some(fit)
    }

    /// A motion that comes to rest has a local minimum for each number of swings before rest. Tries the
    /// coefficients times [`HOPS`], and keeps a clearly better minimum.
    fn with_scaled_coefficients(&self, mut fit: Fit<'a>) -> Fit<'a> {
        if fit.is_white() || !fit.comes_to_rest() {
            return fit;
        }
        let bounds = fit.problem.bounds.clone();
        let hop = |scale: f64| {
            let mut x = fit.x.clone();
            for k in 0..fit.problem.terms.len() {
                x[k] = (x[k] * scale).clamp(bounds[k].0, bounds[k].1);
            }
            let limits = Limits::of(TRIAL_MINIMUM);
            let end = fit.problem.minimise(&mut x, &fit.weights, limits).ok()?;
            Some((end.cost, x))
        };
        let best = HOPS.into_iter().filter_map(hop).min_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((_, x)) = best.filter(|(cost, _)| *cost < HOP_GAIN * fit.normal.cost) {
            fit.x = x;
            return self.resettle(fit);
        }
        fit
    }

    /// Whether a body that nearly rests at the start breaks away is a barrier of the cost, which start states
    /// that only outputs tell cannot cross. Tries the start of each single run at rest, and keeps a better
    /// minimum.
    pub(crate) fn with_starts_at_rest(&self, mut fit: Fit<'a>) -> Fit<'a> {
        let runs = fit.problem.segments.iter().filter(|s| fit.pieces[s.record] == 1);
        let starts: Vec<(usize, usize)> = runs.map(|s| (s.record, s.start)).collect();
        for (record, start) in starts {
            let columns = &self.records[record].columns;
            let mut x = fit.x.clone();
            for k in (0..self.system.states.len()).filter(|&k| columns[k].is_none()) {
                let (low, high) = fit.problem.bounds[start + k];
                x[start + k] = 0f64.clamp(low, high);
            }
            if x == fit.x {
                continue;
            }
            let limits = Limits::of(CHAIN_MINIMUM);
            let end = fit.problem.minimise(&mut x, &fit.weights, limits);
            if end.is_ok_and(|end| end.cost < fit.normal.cost) {
                fit = self.resettle(Fit { x, ..fit });
            }
        }
        fit
    }

    /// Fits segmented records as single runs. A model that lacks a term drifts and is segmented; with the
    /// term the segments only lose information. `None` if there is nothing to join, or the single run still
    /// drifts.
    pub(crate) fn joined(&self, cut: &Fit<'a>) -> Option<Fit<'a>> {
        if self.segments != SegmentsSpec::Auto || cut.pieces.iter().all(|&p| p == 1) {
            return None;
        }
        // The joints are tightened step by step: a run over many events has local minima, a chain of short
        // runs has few.
        let mut chain = self.problem(&cut.problem.terms, cut)?;
        let mut x = cut.x.clone();
        chain.continuity = None;
        let jumps = chain.jumps(&x).ok()?;
        for tighter in TIGHTENING {
            chain.continuity = Some(jumps.iter().map(|j| tighter * j).collect());
            let limits = Limits::of(CHAIN_MINIMUM);
            chain.minimise(&mut x, &cut.weights, limits).ok()?;
        }
        let mut single = self.evenly_cut(&cut.problem.terms, 1)?;
        let mut y = single.guess(&x[..cut.problem.terms.len()], None, &self.smooth);
        transfer(&chain, &x, &single, &mut y);
        for segment in &single.segments {
            let first = chain.segments.iter().find(|s| s.record == segment.record)?;
            for k in 0..self.system.states.len() {
                y[segment.start + k] = x[first.start + k];
            }
        }
        single.budget = Some(cut.budget(cut.most_pieces()));
        let joined = self.settle(single, y, cut.noise.clone(), 3)?;
        (self.misfit(&joined)? <= DRIFT * self.misfit(cut)?).then_some(joined)
    }

    /// A better minimum of single runs whose outputs jump, if the means of these lead to one.
    pub(crate) fn through_means(&self, fit: &Fit<'a>) -> Option<Fit<'a>> {
        if fit.problem.windows(&fit.x).is_empty() {
            return None;
        }
        let problem = self.problem(&fit.problem.terms, fit)?;
        let found = self.settle(problem, fit.x.clone(), fit.noise.clone(), 3)?;
        (self.misfit(&found)? < (1.0 - START_GAIN) * self.misfit(fit)?).then_some(found)
    }

    /// The misfit of a guess over many short segments, without a fit.
    pub(crate) fn misfit_of_guess(&self, terms: &[usize], coefficients: &[f64]) -> Option<f64> {
        let problem = self.evenly_cut(terms, STAGES[0])?;
        let x = problem.guess(coefficients, None, &self.smooth);
        misfit(&problem, &x)
    }

    /// Fits other terms from the solution of a fit, with its noise and segments: cost differences between
    /// such fits are what a selection needs.
    pub(crate) fn refit(&self, from: &Fit<'a>, terms: &[usize]) -> Option<Fit<'a>> {
        self.refit_with(from, terms, &[])
    }

    /// As [`Context::refit`]; new terms begin with these coefficients, and with 0 where none is said.
    pub(crate) fn refit_with(
        &self,
        from: &Fit<'a>,
        terms: &[usize],
        new: &[(usize, f64)],
    ) -> Option<Fit<'a>> {
        // A gain of a hundredth in the logarithm of the likelihood is none.
        let least = LIKELIHOOD_GAIN / from.samples.max(1) as f64;
        self.refit_within(from, (terms, new), Limits::new(REFIT_ITERATIONS, least))
    }

    /// As [`Context::refit`] with few iterations, and fewer still where the cost stays far above that of the
    /// fit.
    pub(crate) fn trial_fit(&self, from: &Fit<'a>, terms: &[usize], new: &[(usize, f64)]) -> Option<Fit<'a>> {
        let limits = Limits { hopeless: HOPELESS * from.normal.cost, ..Limits::of(TRIAL_MINIMUM) };
        self.refit_within(from, (terms, new), limits)
    }

    fn refit_within(
        &self,
        from: &Fit<'a>,
        (terms, new): (&[usize], &[(usize, f64)]),
        limits: Limits,
    ) -> Option<Fit<'a>> {
        let problem = self.problem(terms, from)?;
        let begun = |t: &usize| new.iter().find(|(n, _)| n == t).map_or(0.0, |(_, start)| *start);
        let coefficients: Vec<f64> = terms
            .iter()
            .map(|t| from.problem.terms.iter().position(|u| u == t).map_or_else(|| begun(t), |k| from.x[k]))
            .collect();
        let mut x = problem.guess(&coefficients, None, &self.smooth);
        transfer(&from.problem, &from.x, &problem, &mut x);
        // The segments are the same, and so are their start states.
        for (a, b) in from.problem.segments.iter().zip(&problem.segments) {
            for k in 0..self.system.states.len() {
                x[b.start + k] = from.x[a.start + k];
            }
        }
        let weights = from.weights.clone();
        let normal = problem.minimise(&mut x, &weights, limits).ok()?;
        Some(Fit {
            problem,
            x,
            noise: from.noise.clone(),
            weights,
            normal,
            samples: from.samples,
            effective: from.effective,
            excess: from.excess,
            pieces: from.pieces.clone(),
            force: from.force.clone(),
        })
    }

    /// The problem for other terms, cut and joined as that of a fit.
    pub(crate) fn problem(&self, terms: &[usize], like: &Fit<'a>) -> Option<Problem<'a>> {
        let mut problem = self.cut(terms, &like.pieces)?;
        problem.continuity = like.problem.continuity.clone();
        problem.chained = like.problem.chained;
        problem.following = like.problem.following.clone();
        problem.budget = Some(like.budget(1));
        Some(problem)
    }

    /// A fit with more terms, started from one with fewer, its noise estimated anew.
    pub(crate) fn richer(&self, from: &Fit<'a>, terms: &[usize]) -> Option<Fit<'a>> {
        let Fit { problem, x, noise, .. } = self.refit(from, terms)?;
        self.settle(problem, x, noise, 3)
    }

    /// Minimises and re-estimates the noise in turn. `None` if the model cannot be simulated from `x`.
    pub(crate) fn settle(
        &self,
        mut problem: Problem<'a>,
        mut x: Vec<f64>,
        mut noise: Noise,
        rounds: usize,
    ) -> Option<Fit<'a>> {
        let found = settled(&mut problem, &mut x, &mut noise, rounds)?;
        let pieces = (0..self.records.len())
            .map(|r| problem.segments.iter().filter(|s| s.record == r).count())
            .collect();
        let Settled { weights, normal, samples, effective, excess } = found;
        Some(Fit { problem, x, noise, weights, normal, samples, effective, excess, pieces, force: None })
    }

    /// A fit with its own noise estimate: after a selection it has that of the fit it started from.
    pub(crate) fn resettle(&self, mut fit: Fit<'a>) -> Fit<'a> {
        if fit.force.is_some() {
            return fit;
        }
        let (mut x, mut noise) = (fit.x.clone(), fit.noise.clone());
        match settled(&mut fit.problem, &mut x, &mut noise, 3) {
            Some(Settled { weights, normal, samples, effective, excess }) => {
                Fit { x, noise, weights, normal, samples, effective, excess, ..fit }
            }
            None => fit,
        }
    }

    /// Root mean square of all residuals in units of their columns.
    pub(crate) fn misfit(&self, fit: &Fit<'_>) -> Option<f64> {
        misfit(&fit.problem, &fit.x)
    }

    /// The shared parameters of a fit.
    fn shared(&self, fit: &Fit<'_>) -> Option<Vec<f64>> {
        let t = fit.problem.terms.len();
        Some(fit.problem.model_parameters(0, &fit.x)[t..t + self.system.parameters.len()].to_vec())
    }
}

/// Root mean square of all residuals in units of their columns.
pub(crate) fn misfit(problem: &Problem<'_>, x: &[f64]) -> Option<f64> {
    let residuals = problem.residuals(x).ok()?;
    let (mut sum, mut count) = (0.0, 0);
    for (r, columns) in residuals.iter().enumerate() {
        for (k, c) in columns.iter().enumerate() {
            let d = problem.deviations[r][k].max(f64::MIN_POSITIVE);
            sum += c.residual.iter().map(|e| (e / d).powi(2)).sum::<f64>();
            count += c.residual.len();
        }
    }
    Some((sum / count.max(1) as f64).sqrt())
}

/// The fit of one record of a fit from these unknowns, with a noise of its own; a force is as strong as it was.
pub(crate) fn settled_alone<'a>(
    mut problem: Problem<'a>,
    mut x: Vec<f64>,
    (record, of): (usize, &Fit<'_>),
) -> Option<Fit<'a>> {
    let mut noise = vec![of.noise[record].clone()];
    let pieces = vec![problem.segments.len()];
    // What is a force beside the numbers of other records may be none beside its own.
    let mut free = x.clone();
    let alone = settled(&mut problem, &mut free, &mut noise, 3);
    let white = |s: &Settled| s.effective > WHITE_PART * s.samples as f64 || s.excess < WHITE_EXCESS;
    if let Some(force) = of.force.as_ref().filter(|_| !alone.as_ref().is_some_and(white)) {
        let noise = vec![of.noise[record].clone()];
        let force = RandomForce { intensities: vec![force.intensities[record].clone()], ..force.clone() };
        let (weights, _) = problem.follow(&x, &noise, &force)?;
        let normal = problem.minimise(&mut x, &weights, Limits::of(FINE_MINIMUM)).ok()?;
        let Tally { samples, effective, .. } = weighed(&weights, &problem.residuals(&x).ok()?);
        let force = Some(force);
        return Some(Fit {
            problem,
            x,
            noise,
            weights,
            normal,
            samples,
            effective,
            excess: 1.0,
            pieces,
            force,
        });
    }
    let (Settled { weights, normal, samples, effective, excess }, x) = (alone?, free);
    Some(Fit { problem, x, noise, weights, normal, samples, effective, excess, pieces, force: None })
}

/// What [`settled`] returns beside the unknowns and the noise.
struct Settled {
    weights: Vec<Vec<Vec<f64>>>,
    normal: Normal,
    samples: usize,
    effective: f64,
    excess: f64,
}

fn settled(problem: &mut Problem<'_>, x: &mut [f64], noise: &mut Noise, rounds: usize) -> Option<Settled> {
    problem.look_from(x);
    let mut weights = problem.weights(noise, problem.residuals(x).ok().as_deref());
    let limits = Limits::of(if rounds == 1 { ROUGH_MINIMUM } else { FINE_MINIMUM });
    let mut normal = problem.minimise_from_means(x, &weights, limits).ok()?;
    for _ in 1..rounds {
        problem.look_from(x);
        let residuals = problem.residuals(x).ok()?;
        *noise = problem.noise(&residuals);
        weights = problem.weights(noise, Some(&residuals));
        if problem.has_priors() {
            let Tally { samples, effective, .. } = tally(noise, &residuals);
            problem.belief = inflation(samples, effective);
        }
        normal = problem.minimise(x, &weights, limits).ok()?;
    }
    let residuals = problem.residuals(x).ok()?;
    if rounds == 1 {
        *noise = problem.noise(&residuals);
    }
    let Tally { samples, effective, power } = tally(noise, &residuals);
    let white: f64 = whitened(noise, &residuals).map(|w| noise_level(&w).powi(2) * w.len() as f64).sum();
    let excess = if white > 0.0 { power / white } else { f64::INFINITY };
    Some(Settled { weights, normal, samples, effective, excess })
}

/// Copies parameters and sensor properties that occur in both problems; start states are left alone.
pub(crate) fn transfer(from: &Problem<'_>, x: &[f64], to: &Problem<'_>, y: &mut [f64]) {
    let known = from.meanings();
    for (k, meaning) in to.meanings().into_iter().enumerate() {
        if !matches!(meaning, Meaning::Parameter(..) | Meaning::Sensor(..)) {
            continue;
        }
        if let Some(j) = known.iter().position(|m| *m == meaning) {
            y[k] = x[j];
        }
    }
}

impl Fit<'_> {
    /// Whether nothing but noise is left.
    pub(crate) fn is_white(&self) -> bool {
        self.effective > WHITE_PART * self.samples as f64 || self.excess < WHITE_EXCESS
    }

    /// The p-value of the hypothesis that the residuals are white noise: that of the least white column,
    /// corrected for the number of columns.
    pub(crate) fn chance_of_noise(&self) -> f64 {
        let Ok(residuals) = self.problem.residuals(&self.x) else { return 0.0 };
        let columns: Vec<f64> = match self.force {
            Some(_) => whitened_by(&self.weights, &residuals).map(|w| whiteness_p_value(&w)).collect(),
            None => whitened(&self.noise, &residuals).map(|w| whiteness_p_value(&w)).collect(),
        };
        columns.iter().fold(1.0, |least: f64, p| least.min(p * columns.len() as f64))
    }

    /// Whether a single run ends with all contacts at rest.
    fn comes_to_rest(&self) -> bool {
        self.problem.segments.iter().filter(|s| self.pieces[s.record] == 1).any(|segment| {
            let Ok(sampled) = self.problem.trajectory(segment, &self.x) else { return false };
            let contacts = sampled.run.modes.len() / sampled.run.samples().max(1);
            contacts > 0 && sampled.run.modes.iter().rev().take(contacts).all(|mode| *mode == 0)
        })
    }

    /// Integration steps that a similar model may take over segments `long` times as long: one that takes
    /// many times the steps of a good model is bad.
    fn budget(&self, long: usize) -> usize {
        BUDGET_BASE + BUDGET_FACTOR * long * self.problem.steps(&self.x)
    }

    /// Segments of the record that has most.
    pub(crate) fn most_pieces(&self) -> usize {
        self.pieces.iter().copied().max().unwrap_or(1)
    }

    /// The normal equations at the solution, of other records in the place of its own.
    pub(crate) fn normal_of(&self, records: &[Record]) -> Option<Normal> {
        let (own, records) = (&self.problem, records.iter().collect::<Vec<_>>());
        let mut other = Problem::new(own.system, &own.terms, &records, &self.pieces).ok()?;
        (other.continuity, other.belief) = (own.continuity.clone(), own.belief);
        other.following = own.following.clone();
        other.normal(&self.x, &self.weights).ok()
    }

    /// Twice the negative logarithm of the likelihood but for a constant; `None` of a fit in segments. The fit assumes no noise
    /// below a floor: where it leaves less, the noise has the size of what is left.
    pub(crate) fn deviance(&self) -> Option<f64> {
        if self.most_pieces() > 1 {
            return None;
        }
        let weights = self.weights.iter().flatten().flatten().filter(|w| **w > 0.0);
        let (count, levels) = weights.fold((0.0, 0.0), |(count, sum), w| (count + 1.0, sum - w.ln()));
        let part = (self.normal.cost / count).clamp(f64::MIN_POSITIVE, 1.0);
        Some(self.normal.cost / part + count * part.ln() + levels)
    }

    /// Factor on variances for correlated residuals: 1 for white noise.
    pub(crate) fn inflation(&self) -> f64 {
        inflation(self.samples, self.effective)
    }
}

#[cfg(test)]
mod tests;
