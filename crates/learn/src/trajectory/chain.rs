//! A record as a chain of short runs whose joints are tightened: the fit of motion that forgets its start.
//!
//! Where neighbouring motions diverge, the cost of one long run has a minimum in every ripple. Over a segment so short
//! that a disturbance hardly grows the motion is nearly linear in its start and in all coefficients, and a penalty on
//! the jumps between segments, tightened in steps, leads to the one run without leaving the basin (multiple shooting:
//! Bock, 1983; soft continuity: Ribeiro et al., Automatica 121 (2020) 109158). Start states couple to their neighbours
//! alone, so the work grows with their number.

use crate::decisions::{CHAIN_JOINTS, CHAIN_MINIMUM, CHAIN_SAMPLES, NOISE_FLOOR, START_GAIN};
use crate::least_squares::Limits;
use crate::trajectory::fit::{Context, Fit, transfer};
use crate::trajectory::initial::Regression;
use crate::trajectory::noise::ColumnNoise;
use crate::trajectory::problem::{Noise, Problem};
use crate::trajectory::chain_selection::select_on_chain;
use crate::trajectory::select::Selection;
use phisindy_signal::noise_level;

impl<'a> Context<'a> {
    /// The fit of a chain, its terms selected from the whole dictionary.
    pub(crate) fn chained(&self, regression: &Regression, all: &[usize]) -> Option<Selection<'a>> {
        let full = self.chain_of(all, &regression.solve(all))?;
        let mut found = select_on_chain(self, full);
        found.fit = self.resettle(found.fit);
        if let Some(single) = self.unchained(&found.fit) { found.fit = single; }
        eprintln!("chain selected {:?} cost {} white {}", found.fit.problem.terms, found.fit.normal.cost, found.fit.is_white());
        Some(found)
    }

    /// A chain as one run from where it starts; `None` if no single run follows it.
    fn unchained(&self, chain: &Fit<'a>) -> Option<Fit<'a>> {
        let terms = &chain.problem.terms;
        let problem = Problem::new(self.system, terms, &self.records, &vec![1; self.records.len()]).ok()?;
        let mut x = problem.guess(&chain.x[..terms.len()], None, &self.smooth);
        transfer(&chain.problem, &chain.x, &problem, &mut x);
        for segment in &problem.segments {
            let first = chain.problem.segments.iter().find(|s| s.record == segment.record)?;
            let n = self.system.states.len();
            x[segment.start..segment.start + n].copy_from_slice(&chain.x[first.start..first.start + n]);
        }
        let single = self.settle(problem, x, chain.noise.clone(), 3)?;
        eprintln!("single {:?} chain {:?}", self.misfit(&single), self.misfit(chain));
        (self.misfit(&single)? <= (1.0 + START_GAIN) * self.misfit(chain)?).then_some(single)
    }

    /// The fit of a chain with these terms.
    fn chain_of(&self, terms: &[usize], coefficients: &[f64]) -> Option<Fit<'a>> {
        let pieces: Vec<usize> = self.records.iter().map(|r| (r.len() / CHAIN_SAMPLES).max(1)).collect();
        let mut problem = Problem::new(self.system, terms, &self.records, &pieces).ok()?;
        problem.chained = true;
        let noise = self.spectral_noise(&problem);
        let loose: Vec<f64> = (0..self.system.states.len()).map(|k| free_jump(&problem, &noise, k)).collect();
        let weights = problem.weights(&noise, None);
        let mut x = problem.guess(coefficients, None, &self.smooth);
        for tight in CHAIN_JOINTS {
            problem.continuity = Some(loose.iter().map(|j| tight * j).collect());
            let t = std::time::Instant::now();
            let end = problem.minimise(&mut x, &weights, Limits::of(CHAIN_MINIMUM)).ok()?;
            let samples: usize = self.records.iter().map(|r| r.len() * 3).sum();
            eprintln!("joint {tight} cost per sample {:.4} in {:?}", end.cost / samples as f64, t.elapsed());
        }
        for (t, c) in terms.iter().zip(&x) { eprint!("{t}:{c:.3} "); }
        eprintln!();
        self.settle(problem, x, noise, 3)
    }

    /// The noise of each column from its spectrum above the motion.
    fn spectral_noise(&self, problem: &Problem<'_>) -> Noise {
        let of = |r: usize, k: usize| {
            let floor = NOISE_FLOOR * problem.deviations[r][k];
            let level = self.records[r].columns[k].as_ref().map_or(0.0, |c| noise_level(c));
            ColumnNoise { additive: level.max(floor).max(f64::MIN_POSITIVE), relative: 0.0 }
        };
        (0..self.records.len()).map(|r| (0..self.system.columns()).map(|k| of(r, k)).collect()).collect()
    }
}

/// How far a state may jump at a joint that is as uncertain as a reading; a hundredth of its size without a column.
fn free_jump(problem: &Problem<'_>, noise: &Noise, state: usize) -> f64 {
    let read = problem.records.iter().zip(noise).filter(|(r, _)| r.columns[state].is_some());
    let largest = read.map(|(_, noise)| noise[state].additive).fold(0.0, f64::max);
    if largest > 0.0 { largest } else { 0.01 * problem.scale[state] }
}
