//! A model with a force that is left: its numbers, the intensity of the force and the noise of the sensors, all
//! from one likelihood of prediction errors.
//!
//! The intensities and the noise are those of the largest likelihood along the derivatives of the last run,
//! the numbers of the model minimise the prediction errors with the gains that follow, in turn. Where a free
//! run leaves only noise there is no force, and nothing of this is asked.

use crate::decisions::{
    FINE_MINIMUM, FORCE_DECADES, FORCE_GAIN, FORCE_GROUPED, FORCE_ROUNDS, FORCE_SEARCH, HALF_WIDTH_95,
    ROUGH_MINIMUM, SHARPEST_SENSOR,
};
use crate::least_squares::Limits;
use crate::trajectory::error_bars::ErrorBars;
use crate::trajectory::filter::{Filter, Gains, Group, Pass, driven};
use crate::trajectory::fit::{Context, Fit, transfer};
use crate::trajectory::kalman_smoother::reads_outputs;
use crate::trajectory::noise::{ColumnNoise, least_noise_of};
use crate::trajectory::problem::{Noise, Problem};
use crate::trajectory::remainder::remainders;
use crate::trajectory::tally::{Tally, weighed, whitened_by};
use phisindy_phys::spec::SegmentsSpec;
use phisindy_phys::{Record, System};
use phisindy_signal::{evidence_of_colour, lowest_point, mean_step};
use rayon::prelude::*;

/// White forces on the rates of states.
#[derive(Clone, Debug)]
pub(crate) struct RandomForce {
    /// States that share an intensity, each with its part of it.
    pub(crate) groups: Vec<Group>,
    /// For each record and group: the square of the unit of the rate, times seconds.
    pub(crate) intensities: Vec<Vec<f64>>,
}

/// Weights of all samples: by record, column, sample.
type Weights = Vec<Vec<Vec<f64>>>;

impl RandomForce {
    /// Of intensity zero. A large system has one intensity, in parts of the size of each rate.
    fn none(system: &System, smooth: &[Record]) -> RandomForce {
        let size = |b: usize| {
            let of = |r: &Record| rms_slope(&r.time, r.columns.get(b)?.as_ref()?);
            smooth.iter().filter_map(of).fold(0.0, f64::max)
        };
        let all: Vec<(usize, f64)> = driven(system).into_iter().map(|b| (b, size(b).powi(2))).collect();
        let acts = all.into_iter().filter(|(_, size)| *size > 0.0);
        let groups = if system.states.len() > FORCE_GROUPED {
            vec![acts.collect()]
        } else {
            acts.map(|of| vec![of]).collect()
        };
        let intensities = vec![vec![0.0; groups.len()]; smooth.len()];
        RandomForce { groups, intensities }
    }
}

/// Evidence that the columns of a fit have coloured noise.
fn colour_of(fit: &Fit<'_>) -> f64 {
    let residuals = fit.problem.residuals(&fit.x).unwrap_or_default();
    whitened_by(&fit.weights, &residuals).map(|column| evidence_of_colour(&column)).sum()
}

fn rms_slope(time: &[f64], column: &[f64]) -> Option<f64> {
    let slopes = time.windows(2).zip(column.windows(2)).map(|(t, x)| ((x[1] - x[0]) / (t[1] - t[0])).powi(2));
    let mean = slopes.sum::<f64>() / (time.len().max(2) - 1) as f64;
    mean.is_finite().then(|| mean.sqrt())
}

impl Problem<'_> {
    /// A pass of the filter along a record from its start at `x`, and the gains of it.
    pub(crate) fn filtered(
        &self,
        record: usize,
        x: &[f64],
        noise: &Noise,
        (groups, intensities): (&[Group], &[f64]),
    ) -> Option<(Pass, Gains)> {
        let segment = self.segments.iter().find(|s| s.record == record)?;
        let samples = self.delayed_samples(segment, x);
        let of = self.records[record];
        let mut due = samples.due(|k| of.columns[k].is_some());
        due.iter_mut().for_each(|due| due.retain(|read| of.own_times.has(read.column, read.sample)));
        let variance = |column: usize, read: f64| noise[record][column].variance(read);
        let place = (samples.times.clone(), due.clone());
        let mut filter = Filter::new(self, record, x, place, (groups, intensities), &variance);
        let start = (of.time[0], &x[segment.start..][..self.system.states.len()]);
        let options = self.options(segment, Some(vec![]));
        self.observed(record, x, start, &samples.times, &options, Some(&mut filter)).ok()?;
        let pass = filter.pass;
        let gains = pass.gains(&due, of.len());
        Some((pass, gains)).filter(|(pass, _)| pass.unlikelihood.is_finite())
    }

    /// Lets the runs of all records follow their readings with these forces and noises. Returns the weights of
    /// the innovations, and twice the negative logarithm of the likelihood.
    pub(crate) fn follow(&mut self, x: &[f64], noise: &Noise, force: &RandomForce) -> Option<(Weights, f64)> {
        let all: Vec<(Pass, Gains)> = (0..self.records.len())
            .into_par_iter()
            .map(|r| self.filtered(r, x, noise, (&force.groups, &force.intensities[r])))
            .collect::<Option<_>>()?;
        let unlikelihood = all.iter().map(|(pass, _)| pass.unlikelihood).sum();
        let gains: Vec<Gains> = all.into_iter().map(|(_, gains)| gains).collect();
        let inverse = |of: &Vec<f64>| of.iter().map(|v| 1.0 / v).collect();
        let weights = gains.iter().map(|g| g.variance.iter().map(inverse).collect()).collect();
        self.following = Some(gains);
        Some((weights, unlikelihood))
    }
}

impl RandomForce {
    /// The force of one more record: as strong as in the mean of those that were fitted.
    pub(crate) fn of_another(&self) -> RandomForce {
        let count = self.intensities.len().max(1) as f64;
        let mean = |g: usize| self.intensities.iter().map(|of| of[g]).sum::<f64>() / count;
        RandomForce {
            groups: self.groups.clone(),
            intensities: vec![(0..self.groups.len()).map(mean).collect()],
        }
    }
}

impl<'a> Context<'a> {
    /// The noise of each column by its spectrum above the motion.
    fn noise_above_the_motion(&self, problem: &Problem<'_>) -> Noise {
        let of = |r: &Record, k: usize| {
            let level = r.noise_level(k).max(least_noise_of(r, k, SHARPEST_SENSOR));
            ColumnNoise { additive: level.max(f64::MIN_POSITIVE), relative: 0.0 }
        };
        let row = |r: &&Record| (0..r.columns.len()).map(|k| of(r, k)).collect();
        problem.records.iter().map(row).collect()
    }

    /// The fit with a random force on its bodies, where it leaves more than noise and the force explains it.
    pub(crate) fn with_random_force(&self, fit: Fit<'a>) -> Fit<'a> {
        let single = fit.most_pieces() == 1;
        let outputs = self.records.iter().any(|r| reads_outputs(self.system, r));
        if self.segments != SegmentsSpec::Auto || outputs || fit.problem.chained || single && fit.is_white() {
            return fit;
        }
        // A filter corrects states, and knows neither those that hold something nor on which side of a gap a body is.
        if self.system.jumps() {
            return fit;
        }
        // A force that is larger than the whole rate is none: beside stops that hang on a hair the derivatives are
        // too large for a filter, and free runs know better.
        let is_force = |forced: &Fit<'_>| remainders(forced).iter().all(|left| left.share < 1.0);
        // Nor is a force that could as well be one of the terms, which a single run tells from each other.
        let tells = |forced: &Fit<'_>| {
            let bars = ErrorBars::new(forced);
            let told = |k: usize| forced.x[k].abs() > HALF_WIDTH_95 * bars.error(k);
            (0..forced.problem.terms.len()).all(told)
        };
        match self.forced(&fit) {
            Some((forced, gain))
                if is_force(&forced) && (!single || gain > (fit.samples as f64).ln() && tells(&forced)) =>
            {
                forced
            }
            _ => fit,
        }
    }

    /// The same terms with random forces, and by how much twice the logarithm of the likelihood is above that
    /// of single runs without, whose noise may have a colour.
    fn forced(&self, fit: &Fit<'a>) -> Option<(Fit<'a>, f64)> {
        let terms = &fit.problem.terms;
        let n = self.system.states.len();
        let mut problem = self.evenly_cut(terms, 1)?;
        let mut x = problem.guess(&fit.x[..terms.len()], None, &self.smooth);
        transfer(&fit.problem, &fit.x, &problem, &mut x);
        for segment in &problem.segments {
            let first = fit.problem.segments.iter().find(|s| s.record == segment.record)?;
            x[segment.start..][..n].copy_from_slice(&fit.x[first.start..][..n]);
        }
        let mut noise = self.noise_above_the_motion(&problem);
        let mut force = RandomForce::none(self.system, &self.smooth);
        if force.groups.is_empty() {
            return None;
        }
        for r in 0..self.records.len() {
            let step = mean_step(&self.records[r].time);
            let of_decade = |decade: i32| {
                let intensities = vec![step * 10f64.powi(decade); force.groups.len()];
                let (pass, _) = problem.filtered(r, &x, &noise, (&force.groups, &intensities))?;
                Some((pass.unlikelihood, intensities))
            };
            let all: Vec<_> = FORCE_DECADES.par_iter().map(|&decade| of_decade(decade)).collect();
            let best = all.into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0))?;
            force.intensities[r] = best.1;
        }
        let mut best: Option<(f64, Vec<f64>, Noise, RandomForce)> = None;
        for round in 0..FORCE_ROUNDS {
            self.likeliest(&problem, &x, &mut noise, &mut force)?;
            problem.following = None;
            let (weights, unlikelihood) = problem.follow(&x, &noise, &force)?;
            let gained = best.as_ref().is_none_or(|(least, ..)| unlikelihood < least - FORCE_GAIN);
            if best.as_ref().is_none_or(|(least, ..)| unlikelihood < *least) {
                best = Some((unlikelihood, x.clone(), noise.clone(), force.clone()));
            }
            if !gained {
                break;
            }
            let limits = if round < 2 { ROUGH_MINIMUM } else { FINE_MINIMUM };
            problem.minimise(&mut x, &weights, Limits::of(limits)).ok()?;
        }
        let (unlikelihood, mut x, noise, force) = best?;
        let (weights, _) = problem.follow(&x, &noise, &force)?;
        let normal = problem.minimise(&mut x, &weights, Limits::of(FINE_MINIMUM)).ok()?;
        let residuals = problem.residuals(&x).ok()?;
        let Tally { samples, effective, .. } = weighed(&weights, &residuals);
        let gain = fit.deviance().map_or(f64::INFINITY, |free| free - colour_of(fit) - unlikelihood);
        let pieces = vec![1; self.records.len()];
        let force = Some(force);
        Some((
            Fit { problem, x, noise, weights, normal, samples, effective, excess: 1.0, pieces, force },
            gain,
        ))
    }

    /// Moves the intensities and the noises to the largest likelihood along the derivatives at `x`.
    fn likeliest(
        &self,
        problem: &Problem<'_>,
        x: &[f64],
        noise: &mut Noise,
        force: &mut RandomForce,
    ) -> Option<()> {
        let of_record = |r: usize| {
            let (pass, _) = problem.filtered(r, x, noise, (&force.groups, &force.intensities[r]))?;
            let record = self.records[r];
            let measured: Vec<usize> =
                (0..record.columns.len()).filter(|&k| record.columns[k].is_some()).collect();
            let groups = force.groups.len();
            let mut at: Vec<f64> = force.intensities[r].iter().map(|q| q.ln()).collect();
            at.extend(measured.iter().map(|_| 0.0));
            // The likelihood has no bound where a sensor has no noise.
            let floor = |k: usize| {
                let least = least_noise_of(record, k, SHARPEST_SENSOR);
                (least.powi(2) / noise[r][k].variance(problem.deviations[r][k])).ln().min(0.0)
            };
            let lowest: Vec<f64> =
                (0..groups).map(|_| f64::NEG_INFINITY).chain(measured.iter().map(|&k| floor(k))).collect();
            let value = |at: &[f64]| {
                let q: Vec<f64> = at[..groups].iter().map(|v| v.exp()).collect();
                let mut factors = vec![1.0; record.columns.len()];
                measured.iter().zip(&at[groups..]).for_each(|(&k, v)| factors[k] = v.exp());
                pass.unlikelihood_with(&q, &factors)
            };
            for reach in FORCE_SEARCH {
                for k in 0..at.len() {
                    let along = |v: f64| {
                        let mut there = at.clone();
                        there[k] = v;
                        value(&there)
                    };
                    let low = (at[k] - reach).max(lowest[k]);
                    at[k] = lowest_point(low, at[k] + reach, 0.02, along);
                }
            }
            let intensities = at[..groups].iter().map(|v| v.exp()).collect::<Vec<f64>>();
            let factors: Vec<(usize, f64)> =
                measured.into_iter().zip(at[groups..].iter().map(|v| v.exp())).collect();
            Some((intensities, factors))
        };
        let all: Vec<_> = (0..self.records.len()).into_par_iter().map(of_record).collect::<Option<_>>()?;
        for (r, (intensities, factors)) in all.into_iter().enumerate() {
            force.intensities[r] = intensities;
            for (k, factor) in factors {
                let of = &mut noise[r][k];
                (of.additive, of.relative) = (of.additive * factor.sqrt(), of.relative * factor.sqrt());
            }
        }
        Some(())
    }
}
