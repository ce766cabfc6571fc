//! The cost of a trajectory problem and its derivatives, from simulations of all segments.

use crate::decisions::ROUGH_MINIMUM;
use crate::least_squares::{Limits, Normal, minimise_by};
use crate::trajectory::delayed_samples::SampledRun;
use crate::trajectory::jumps::Miss;
use crate::trajectory::layout::{Segment, SensorSlots, Source};
use crate::trajectory::problem::Problem;
use crate::trajectory::products::Products;
use crate::trajectory::window_means::Window;
use faer::Mat;
use phisindy_phys::SensorPart;
use phisindy_sim::SimError;
use rayon::prelude::*;
use std::ops::Range;

/// Samples of a segment that one thread takes at a time.
const PART: usize = 256;
/// Samples of a part of the gradient.
const STRETCH: usize = 4;

/// The contribution of one segment to the normal equations: the unknowns that it depends on, and its normal
/// equations in those (upper triangle).
struct Share {
    cost: f64,
    at: Vec<usize>,
    matrix: Mat<f64>,
    gradient: Vec<f64>,
}

/// Which rows of `J` are gathered, and how.
#[derive(Clone, Copy)]
struct Rows<'m> {
    /// Each multiplied by its residual: the meat of the sandwich.
    meat: bool,
    /// For the meat: the inverse of the whole `J^T J`, if leverages count.
    inverse: Option<&'m Mat<f64>>,
    /// Those of the joints of segments too.
    joints: bool,
    /// Samples over which outputs are averaged; 1 for single samples.
    window: usize,
}

impl Rows<'_> {
    const ALL: Rows<'static> = Rows { meat: false, inverse: None, joints: true, window: 1 };
}

impl Problem<'_> {
    /// Minimises the cost from `x` within the bounds. Returns the normal equations at the end.
    ///
    /// # Errors
    /// The model cannot be simulated at `x`.
    pub(crate) fn minimise(
        &self,
        x: &mut [f64],
        weights: &[Vec<Vec<f64>>],
        limits: Limits,
    ) -> Result<Normal, SimError> {
        self.minimise_within(&self.bounds, x, weights, limits)
    }

    /// As [`Problem::minimise`], within other bounds.
    pub(crate) fn minimise_within(
        &self,
        bounds: &[(f64, f64)],
        x: &mut [f64],
        weights: &[Vec<Vec<f64>>],
        limits: Limits,
    ) -> Result<Normal, SimError> {
        self.minimise_means(bounds, x, weights, limits, 1)
    }

    /// As [`Problem::minimise`], through means of outputs that jump, see [`super::window_means`].
    pub(crate) fn minimise_from_means(
        &self,
        x: &mut [f64],
        weights: &[Vec<Vec<f64>>],
        limits: Limits,
    ) -> Result<Normal, SimError> {
        let start = x.to_vec();
        for window in self.windows(x) {
            self.minimise_means(&self.bounds, x, weights, Limits::of(ROUGH_MINIMUM), window)?;
        }
        let end = self.minimise(x, weights, limits)?;
        if start != *x && self.cost(&start, weights)? < end.cost {
            x.copy_from_slice(&start);
            return self.minimise(x, weights, limits);
        }
        Ok(end)
    }

    /// As [`Problem::minimise_within`] for outputs averaged over windows of so many samples.
    fn minimise_means(
        &self,
        bounds: &[(f64, f64)],
        x: &mut [f64],
        weights: &[Vec<Vec<f64>>],
        limits: Limits,
        window: usize,
    ) -> Result<Normal, SimError> {
        let (mut failure, mut begun) = (None, false);
        // Tight joints would damp steps along the chain that the data ask for.
        let metric = match self.chained {
            true => Some(self.gathered(x, weights, Rows { joints: false, window, ..Rows::ALL })?.matrix),
            false => None,
        };
        let metric: Option<Vec<f64>> = metric.map(|m| (0..x.len()).map(|k| m[(k, k)]).collect());
        let correct = |from: &[f64], to: &mut [f64]| self.stop_at_rest(from, to);
        let end = minimise_by(metric.as_deref(), correct, x, bounds, limits, |x, ceiling| {
            if std::mem::replace(&mut begun, true) && self.stop.requested() {
                return None;
            }
            // A step that is likely to fail is tried without derivatives, which are most of the work.
            if ceiling.is_finite() && self.cost_of_means(x, weights, window).ok()? > ceiling {
                return None;
            }
            self.normal_of_means(x, weights, window).map_err(|e| failure = Some(e)).ok()
        });
        end.ok_or_else(|| failure.expect("a minimum without an end has failed at its start"))
    }

    /// The cost alone, bit for bit that of [`Problem::normal`].
    pub(crate) fn cost(&self, x: &[f64], weights: &[Vec<Vec<f64>>]) -> Result<f64, SimError> {
        self.cost_of_means(x, weights, 1)
    }

    /// The cost with outputs averaged over windows of so many samples.
    pub(crate) fn cost_of_means(
        &self,
        x: &[f64],
        weights: &[Vec<Vec<f64>>],
        window: usize,
    ) -> Result<f64, SimError> {
        let cost = |s| self.cost_along(s, x, weights, window);
        let parts: Vec<f64> = self.segments.par_iter().map(cost).collect::<Result<_, _>>()?;
        let prior = |&(k, centre, sigma): &(usize, f64, f64)| {
            let r = (x[k] - centre) / sigma;
            self.belief * r * r
        };
        let all = parts.into_iter().chain(self.priors.iter().map(prior));
        Ok(all.fold(0.0, |sum, part| sum + part))
    }

    /// The cost of one segment.
    pub(crate) fn cost_along(
        &self,
        segment: &Segment,
        x: &[f64],
        weights: &[Vec<Vec<f64>>],
        window: usize,
    ) -> Result<f64, SimError> {
        let sampled = self.run(segment, x, false)?;
        let of = |part| sum_of_squares(&self.misses(segment, x, weights, &sampled, (part, window)));
        let parts = parts(segment).map(of).fold(0.0, |sum, part| sum + part);
        let means = self.window_means(segment, x, weights, &sampled, window);
        let means = means.iter().fold(0.0, |sum, mean| sum + mean.miss * mean.miss);
        Ok(parts + means + sum_of_squares(&self.joint_misses(segment, x, &sampled)))
    }

    /// The weighted residuals of some samples of a segment: one by one those of each measured column.
    fn misses(
        &self,
        segment: &Segment,
        x: &[f64],
        weights: &[Vec<Vec<f64>>],
        sampled: &SampledRun,
        (samples, window): (Range<usize>, usize),
    ) -> Vec<f64> {
        let record = self.records[segment.record];
        let single = |&k: &usize| record.columns[k].is_some() && !self.is_averaged(k, window);
        let measured: Vec<usize> = (0..record.columns.len()).filter(single).collect();
        let columns: Vec<(&[f64], &[f64])> = measured
            .iter()
            .map(|&k| {
                (record.columns[k].as_deref().unwrap_or_default(), weights[segment.record][k].as_slice())
            })
            .collect();
        let mut misses = Vec::with_capacity(samples.len() * measured.len());
        for sample in samples {
            let i = sample - segment.samples.0;
            for (&k, (column, weight)) in measured.iter().zip(&columns) {
                if !self.tells(segment.record, k, sample) {
                    misses.push(0.0);
                    continue;
                }
                let (prediction, _) = self.reading(segment.record, k, x, sampled.value(i, k).0);
                let (scale, miss) = (weight[sample].sqrt(), prediction - column[sample]);
                match self.beside_jumps(segment, x, sampled, (sample, k), 1.0 / scale) {
                    Some(beside) => {
                        let Miss { amplitude, timing } = beside.miss(miss);
                        misses.push(scale * amplitude);
                        misses.extend(timing.map(|(_, late)| late));
                    }
                    None => misses.push(scale * miss),
                }
            }
        }
        misses
    }

    /// The weighted jump of each state from a segment to the next, if they are joined.
    fn joint_misses(&self, segment: &Segment, x: &[f64], sampled: &SampledRun) -> Vec<f64> {
        let (Some(next), Some(tau)) = (self.next(segment), &self.continuity) else { return vec![] };
        let (first, last) = segment.samples;
        let (n, at) = (self.system.states.len(), (last - first) * sampled.run.n);
        let (states, rates) = (&sampled.run.states[at..], &sampled.run.rates[at..]);
        let late = sampled.end - self.records[segment.record].time[last];
        (0..n).map(|k| joint(tau[k]) * (states[k] - late * rates[k] - x[next.start + k])).collect()
    }

    /// Cost and normal equations, residuals weighted by the noise at `weights` (predictions of an earlier
    /// iterate, so that weights do not chase the fit).
    pub(crate) fn normal(&self, x: &[f64], weights: &[Vec<Vec<f64>>]) -> Result<Normal, SimError> {
        self.gathered(x, weights, Rows::ALL)
    }

    /// The same with outputs averaged over windows of so many samples.
    pub(crate) fn normal_of_means(
        &self,
        x: &[f64],
        weights: &[Vec<Vec<f64>>],
        window: usize,
    ) -> Result<Normal, SimError> {
        self.gathered(x, weights, Rows { window, ..Rows::ALL })
    }

    /// As [`Problem::normal`], but each row of `J` is multiplied by its weighted residual: the meat of the
    /// sandwich that makes error bars right where the noise model is not (White, Econometrica 48 (1980)
    /// 817-838). With the inverse of the matrix of [`Problem::normal`] leverages count, see
    /// [`Products::with_leverage`].
    pub(crate) fn meat(
        &self,
        x: &[f64],
        weights: &[Vec<Vec<f64>>],
        inverse: Option<&Mat<f64>>,
    ) -> Result<Mat<f64>, SimError> {
        self.gathered(x, weights, Rows { meat: true, inverse, ..Rows::ALL }).map(|n| n.matrix)
    }

    /// The gradient in parts: for each segment those of its stretches of [`STRETCH`] samples, in all unknowns.
    pub(crate) fn scores(
        &self,
        x: &[f64],
        weights: &[Vec<Vec<f64>>],
    ) -> Result<Vec<Vec<Vec<f64>>>, SimError> {
        let of_segment = |segment: &Segment| -> Result<Vec<Vec<f64>>, SimError> {
            let sampled = self.run(segment, x, true)?;
            let (at, sensor_slots) = self.unknowns_of(segment);
            let (first, last) = segment.samples;
            let of = |from: usize| {
                let part = from..(from + STRETCH).min(last);
                let mut products = Products::new(at.len(), false);
                let misses = self.misses(segment, x, weights, &sampled, (part.clone(), 1));
                self.gather((segment, part, 1), x, weights, (&sampled, &sensor_slots), misses, &mut products);
                let mut score = vec![0.0; self.unknowns];
                at.iter().zip(products.finish().1).for_each(|(&k, g)| score[k] += g);
                score
            };
            Ok((first..last).step_by(STRETCH).map(of).collect())
        };
        self.segments.par_iter().map(of_segment).collect()
    }

    fn gathered(&self, x: &[f64], weights: &[Vec<Vec<f64>>], rows: Rows<'_>) -> Result<Normal, SimError> {
        let d = self.unknowns;
        let parts: Vec<Share> = self
            .segments
            .par_iter()
            .map(|s| self.normal_of_segment(s, x, weights, rows))
            .collect::<Result<_, _>>()?;
        let mut total = Normal { cost: 0.0, matrix: Mat::zeros(d, d), gradient: vec![0.0; d] };
        for Share { cost, at, matrix, gradient } in parts {
            total.cost += cost;
            for (i, &row) in at.iter().enumerate() {
                total.gradient[row] += gradient[i];
                for (j, &col) in at.iter().enumerate() {
                    total.matrix[(row, col)] += matrix[(i.min(j), i.max(j))];
                }
            }
        }
        for &(k, centre, sigma) in &self.priors {
            let r = (x[k] - centre) / sigma;
            total.cost += self.belief * r * r;
            total.matrix[(k, k)] += self.belief / (sigma * sigma);
            total.gradient[k] += self.belief * r / sigma;
        }
        Ok(total)
    }

    /// The unknowns on which the run of a segment depends, and where those of the sensor of each column stand among them.
    pub(crate) fn unknowns_of(&self, segment: &Segment) -> (Vec<usize>, Vec<SensorSlots>) {
        let (n, r) = (self.system.states.len(), segment.record);
        // Columns of the sensitivities: start states, then the unknown ones among the model's parameters.
        let mut at: Vec<usize> = (segment.start..segment.start + n).collect();
        at.extend(self.sources(r).filter_map(|s| if let Source::Unknown(k) = s { Some(k) } else { None }));
        let columns = self.system.columns();
        let mut sensor_slots = vec![[usize::MAX; SensorPart::ALL.len()]; columns];
        for (k, sensor) in self.sensors[r][..columns].iter().enumerate() {
            for (which, source) in sensor.iter().enumerate() {
                if let Source::Unknown(unknown) = *source {
                    sensor_slots[k][which] = at.iter().position(|&u| u == unknown).unwrap_or(at.len());
                    if sensor_slots[k][which] == at.len() {
                        at.push(unknown);
                    }
                }
            }
        }
        (at, sensor_slots)
    }

    /// Which unknowns a segment depends on, its cost, and its normal equations in those (upper triangle).
    // Longer than 80 lines: `wide` must inline the whole loop over the samples to compile it for the widest
    // vectors.
    fn normal_of_segment(
        &self,
        segment: &Segment,
        x: &[f64],
        weights: &[Vec<Vec<f64>>],
        Rows { meat, inverse, joints: joined, window }: Rows<'_>,
    ) -> Result<Share, SimError> {
        let sampled = self.run(segment, x, true)?;
        let (mut at, sensor_slots) = self.unknowns_of(segment);
        let next = self.next(segment).filter(|_| joined);
        let (joints, n) = (at.len(), self.system.states.len());
        at.extend(next.iter().flat_map(|s| s.start..s.start + n));
        let width = at.len();
        // What the data do not see has no finite variance, and no leverage.
        let finite = |v: f64| if v.is_finite() { v } else { 0.0 };
        let inverse = inverse.map(|inverse| -> Vec<f64> {
            at.iter().flat_map(|&i| at.iter().map(move |&j| finite(inverse[(i, j)]))).collect()
        });
        let begun = || match &inverse {
            Some(inverse) => Products::new(width, meat).with_leverage(inverse.clone()),
            None => Products::new(width, meat),
        };
        // The parts are the same for any number of threads, and so are their sums.
        let of = |samples: Range<usize>| {
            let mut products = begun();
            let misses = self.misses(segment, x, weights, &sampled, (samples.clone(), window));
            let cost = sum_of_squares(&misses);
            let at = (segment, samples, window);
            self.gather(at, x, weights, (&sampled, &sensor_slots), misses, &mut products);
            (cost, products)
        };
        let parts: Vec<_> = parts(segment).collect();
        let parts: Vec<(f64, Products)> = parts.into_par_iter().map(of).collect();
        let sum = parts.into_iter().reduce(|(cost, mut products), (share, part)| {
            products.add(part);
            (cost + share, products)
        });
        let (mut cost, mut products) = sum.unwrap_or_else(|| (0.0, begun()));
        for mean in self.window_means(segment, x, weights, &sampled, window) {
            cost += mean.miss * mean.miss;
            self.gather_mean(segment, x, (&sampled, &sensor_slots), &mean, &mut products);
        }
        if let (Some(_), Some(tau)) = (next, &self.continuity) {
            let (run, i) = (&sampled.run, segment.samples.1 - segment.samples.0);
            let misses = self.joint_misses(segment, x, &sampled);
            cost += sum_of_squares(&misses);
            for (k, &e) in misses.iter().enumerate() {
                let weight = joint(tau[k]);
                let row = products.row(e);
                let s = &run.sensitivities[(i * run.n + k) * run.m..][..run.m];
                row.iter_mut().zip(s).for_each(|(j, s)| *j = weight * s);
                row[joints + k] = -weight;
            }
        }
        let (product, gradient) = products.finish();
        let matrix = Mat::from_fn(width, width, |a, b| if a <= b { product(a, b) } else { 0.0 });
        Ok(Share { cost, at, matrix, gradient: gradient.to_vec() })
    }

    /// Gathers the rows of `J` of some samples of a segment, whose residuals are the `misses`.
    fn gather(
        &self,
        (segment, samples, window): (&Segment, Range<usize>, usize),
        x: &[f64],
        weights: &[Vec<Vec<f64>>],
        (sampled, sensor_slots): (&SampledRun, &[SensorSlots]),
        misses: Vec<f64>,
        products: &mut Products,
    ) {
        let (run, r) = (&sampled.run, segment.record);
        let mut misses = misses.into_iter();
        for sample in samples {
            let i = sample - segment.samples.0;
            for (k, column) in self.records[r].columns.iter().enumerate() {
                let Some(column) = column.as_ref().filter(|_| !self.is_averaged(k, window)) else { continue };
                let e = misses.next().expect("one for each sample of each column");
                let (value, rate) = sampled.value(i, k);
                let (prediction, gain) = self.reading(r, k, x, value);
                let weight = weights[r][k][sample].sqrt();
                let row = products.row(e);
                if !self.tells(r, k, sample) {
                    continue;
                }
                let factor = weight * gain;
                row.iter_mut().zip(sampled.sensitivities(i, k)).for_each(|(j, s)| *j = factor * s);
                let age = self.records[r].time[sample] - self.records[r].sensors[k].since;
                let by = by_sensor(weight, gain, (value, rate, sampled.by_lag(i, k)), age);
                add_to(row, &sensor_slots[k], by);
                // Where the reading shows the other side of a jump, it tells the time of the event.
                let beside = self.beside_jumps(segment, x, sampled, (sample, k), 1.0 / weight);
                let miss = prediction - column[sample];
                let timing = beside.and_then(|at| Some((at.step, at.miss(miss).timing?)));
                if let Some((step, (jump, _))) = timing {
                    let e = misses.next().expect("one for each event that is told");
                    let per_second = 12f64.sqrt() / step;
                    let row = products.row(e);
                    let moves = &run.jumps[jump].moves;
                    row.iter_mut().zip(moves).for_each(|(j, s)| *j = per_second * s);
                    let by = [0.0, 0.0, per_second, -per_second * age, per_second];
                    add_to(row, &sensor_slots[k], by);
                }
            }
        }
    }
}

impl Problem<'_> {
    /// Gathers the row of `J` of a mean over a window.
    fn gather_mean(
        &self,
        segment: &Segment,
        x: &[f64],
        (sampled, sensor_slots): (&SampledRun, &[SensorSlots]),
        mean: &Window<'_>,
        products: &mut Products,
    ) {
        let (k, r) = (mean.column, segment.record);
        let (_, gain) = self.reading(r, k, x, 0.0);
        let factor = mean.factor * gain;
        let row = products.row(mean.miss);
        let record = self.records[r];
        let age = |i: usize| record.time[segment.samples.0 + i] - record.sensors[k].since;
        for &i in mean.samples() {
            let (value, rate) = sampled.value(i, k);
            row.iter_mut().zip(sampled.sensitivities(i, k)).for_each(|(j, s)| *j += factor * s);
            let by = by_sensor(mean.factor, gain, (value, rate, sampled.by_lag(i, k)), age(i));
            add_to(row, &sensor_slots[k], by);
        }
        mean.add_events(row);
        let middle = mean.samples()[mean.samples().len() / 2];
        let loss = mean.loss();
        add_to(row, &sensor_slots[k], [0.0, 0.0, -loss, loss * age(middle), -loss]);
    }
}

/// How a reading of this weight and gain moves with the parameters of its sensor, in the order of [`SensorPart::ALL`], from
/// what it shows, its rate and its derivative by the lag, at this age of the sensor's clock.
pub(crate) fn by_sensor(
    weight: f64,
    gain: f64,
    (value, rate, by_lag): (f64, f64, f64),
    age: f64,
) -> [f64; SensorPart::ALL.len()] {
    let factor = weight * gain;
    [weight, weight * value, -(factor * rate), factor * rate * age, factor * by_lag]
}

/// Adds these derivatives to a row of `J` where they are of unknowns.
pub(crate) fn add_to(row: &mut [f64], slots: &SensorSlots, by: [f64; SensorPart::ALL.len()]) {
    for (&at, by) in slots.iter().zip(by).filter(|(at, _)| **at != usize::MAX) {
        row[at] += by;
    }
}

/// The samples of a segment in parts, each a task for one thread.
fn parts(segment: &Segment) -> impl Iterator<Item = Range<usize>> {
    let (first, last) = segment.samples;
    (first..last).step_by(PART).map(move |from| from..(from + PART).min(last))
}

/// The square root of the weight of a jump between segments whose standard deviation is `tau`.
fn joint(tau: f64) -> f64 {
    1.0 / tau.max(f64::MIN_POSITIVE)
}

fn sum_of_squares(misses: &[f64]) -> f64 {
    misses.iter().fold(0.0, |sum, e| sum + e * e)
}

#[cfg(test)]
mod tests;
