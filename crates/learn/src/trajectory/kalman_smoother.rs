//! States that no column shows, estimated from the outputs of a record: where a fit starts, and the motion on
//! which laws are ranked. No result rests on it.
//!
//! The known rates hold but for an unknown force on every state that is not driven by another state alone.
//! The force is a random walk that returns to zero, so it takes the shape of whatever the model lacks. Where
//! no state is measured it has nothing below the lowest frequency of the outputs: an accelerometer does not
//! show a slow drift of a displacement. Friction of the model counts as such a force, for its sign jumps
//! where the estimate is uncertain. States and forces follow from an extended Kalman filter and the smoother
//! of Rauch, Tung and Striebel (AIAA J. 3 (1965) 1445-1450). Strength and memory of the walk are those of the
//! largest likelihood. An estimate whose outputs are further from the columns than those of a system at rest
//! is none.

use crate::decisions::{COVARIANCE_RIDGE, DIFFUSE, LIKELIHOOD_SAMPLES, WALK_DECADES, WALK_MEMORIES};
use faer::Mat;
use faer::linalg::solvers::Solve;
use phisindy_expr::{Graph, Id, Node, Scratch, Tape, Unary};
use phisindy_phys::{Record, System};
use phisindy_signal::{Interpolation, lowest_frequency};
use rayon::prelude::*;
use std::collections::HashMap;

/// Samples of each state. `None` where the known rates are not finite along the record, or it has no outputs.
pub(crate) fn estimated_states(system: &System, record: &Record) -> Option<Vec<Vec<f64>>> {
    if !reads_outputs(system, record) {
        return None;
    }
    let filter = Filter::new(system, record)?;
    let span = record.time[record.len() - 1] - record.time[0];
    // A few decades of strength, three by three and then one by one; memories of a third of the record down
    // to a thousandth.
    let best = |trials: Vec<Walk>| -> Option<Walk> {
        let likelihood = |walk: Walk| {
            let run = filter.forward(walk, LIKELIHOOD_SAMPLES);
            (run.map_or(f64::NEG_INFINITY, |f| f.likelihood), walk)
        };
        let all: Vec<(f64, Walk)> = trials.into_par_iter().map(likelihood).collect();
        all.into_iter().max_by(|a, b| a.0.total_cmp(&b.0)).filter(|b| b.0.is_finite()).map(|b| b.1)
    };
    let [least, most] = WALK_DECADES;
    let walk = |decade: i32, memory: f64| Walk { decade, memory };
    let coarse =
        (least..=most).step_by(3).flat_map(|d| WALK_MEMORIES.map(|part| walk(d, span * part))).collect();
    let near = best(coarse)?;
    let likeliest = best((near.decade - 2..=near.decade + 2).map(|d| walk(d, near.memory)).collect())?;
    // A linearisation at rest may lead anywhere.
    let all = filter.smoothed(likeliest).filter(|all| filter.is_near(all))?;
    Some((0..filter.n).map(|k| all.iter().map(|x| x[(k, 0)]).collect()).collect())
}

/// Whether a record has states of which outputs tell.
pub fn reads_outputs(system: &System, record: &Record) -> bool {
    !system.states.is_empty() && (system.states.len()..system.columns()).any(|k| record.columns[k].is_some())
}

/// States of the filter for each unknown force.
const STAGES: usize = 3;

/// The unknown forces: a random walk with this power per second that forgets within a memory (s).
#[derive(Clone, Copy)]
struct Walk {
    /// Power of ten of its power per second.
    decade: i32,
    memory: f64,
}

impl Walk {
    fn power(&self) -> f64 {
        10f64.powi(self.decade)
    }
}

/// The filter of one record.
struct Filter<'a> {
    record: &'a Record,
    /// Number of states, and with those of the unknown forces.
    n: usize,
    width: usize,
    /// Number of unknown forces.
    forces: usize,
    /// Below this frequency (rad/s) the forces have nothing; 0 where a state is measured.
    lowest: f64,
    /// The measured columns, each with its values (corrected for its sensor) and their variance.
    columns: Vec<(usize, Vec<f64>, f64)>,
    /// Rates of the states, their derivatives by states and forces, then outputs and theirs.
    tape: Tape,
    numbers: Vec<f64>,
}

/// The filter along a record: predicted and updated states with their covariances, and the steps.
struct Forward {
    predicted: Vec<(Mat<f64>, Mat<f64>)>,
    updated: Vec<(Mat<f64>, Mat<f64>)>,
    steps: Vec<Mat<f64>>,
    likelihood: f64,
}

impl<'a> Filter<'a> {
    fn new(system: &System, record: &'a Record) -> Option<Filter<'a>> {
        // The walk of a force follows no impulse.
        if !system.impacts.is_empty() {
            return None;
        }
        let mut graph = system.graph.clone();
        let mut names = system.names.clone();
        let n = system.states.len();
        let forced: Vec<usize> =
            (0..n).filter(|&k| system.states[k].velocity.is_none() && !system.states[k].hidden).collect();
        let mut rates = without_signs(&mut graph, &system.known);
        // Each force is a walk, less its slow part, less the slow part of what is left: three states of the
        // filter.
        let mut inner: [Vec<Id>; STAGES] = Default::default();
        for &k in &forced {
            let mut node = |graph: &mut Graph, stage: usize| {
                // A space keeps the name out of reach of any spec.
                let symbol = names.intern(&format!("unknown force {k} {stage}"));
                inner[stage].push(graph.symbol(symbol));
            };
            (0..STAGES).for_each(|stage| node(&mut graph, stage));
            let last = inner[0].len() - 1;
            let slow = graph.add(inner[1][last], inner[2][last]);
            let force = graph.sub(inner[0][last], slow);
            rates[k] = graph.add(rates[k], force);
        }
        let forces: Vec<Id> = inner.concat();
        let outputs = system.outputs_with(&mut graph, &rates);
        let outputs = without_signs(&mut graph, &outputs);
        let read: Vec<Id> = system.states.iter().map(|s| s.node).chain(outputs).collect();
        let measured: Vec<usize> = (0..read.len()).filter(|&k| record.columns[k].is_some()).collect();
        let columns = measured.iter().map(|&k| {
            let column = record.columns[k].clone().unwrap_or_default();
            let variance = (record.noise_level(k) / record.sensors[k].gain.start).powi(2);
            let column = record.sensors[k].corrected(&record.time, column, Interpolation::Cubic).ok()?;
            Some((k, column, variance.max(f64::MIN_POSITIVE)))
        });
        let columns: Vec<_> = columns.collect::<Option<_>>()?;
        let moving: Vec<Id> = system.states.iter().map(|s| s.node).chain(forces.iter().copied()).collect();
        let shown: Vec<Id> = measured.iter().map(|&k| read[k]).collect();
        let mut roots = rates.clone();
        for of in rates.iter().chain(&shown) {
            roots.extend(graph.gradient(*of, &moving));
        }
        roots.extend(&shown);
        let arguments: Vec<Id> = system.arguments().into_iter().chain(forces).collect();
        let tape = Tape::compile(&graph, &arguments, &roots).ok()?;
        let numbers: Vec<f64> = system.parameters.iter().map(|p| p.start).collect();
        let still = (0..n).any(|k| record.columns[k].is_some());
        let of = |k: usize| record.own_column(k).map(|(time, values)| lowest_frequency(&time, &values));
        let lowest = (n..record.columns.len()).filter_map(of).fold(f64::INFINITY, f64::min);
        let lowest = if still { 0.0 } else { lowest };
        let width = n + STAGES * forced.len();
        Some(Filter { record, n, width, forces: forced.len(), lowest, columns, tape, numbers })
    }

    /// The columns that have a sample there: the place, values and variance of each.
    fn sampled_at(&self, sample: usize) -> impl Iterator<Item = (usize, &[f64], f64)> {
        let all = self.columns.iter().enumerate();
        let own = all.filter(move |(_, (column, ..))| self.record.own_times.has(*column, sample));
        own.map(|(k, (_, values, variance))| (k, values.as_slice(), *variance))
    }

    /// Evaluates the tape at a sample.
    fn at(&self, scratch: &mut Scratch<1>, sample: usize, x: &Mat<f64>) -> Option<()> {
        let states = (0..self.n).map(|k| x[(k, 0)]);
        let arguments = self.record.arguments_at(sample, states, &self.numbers);
        scratch.at(arguments.chain((self.n..self.width).map(|k| x[(k, 0)])));
        (0..self.tape.outputs()).all(|k| scratch.output(k)[0].is_finite()).then_some(())
    }

    /// The filter over the first samples.
    fn forward(&self, walk: Walk, most: usize) -> Option<Forward> {
        let (n, w) = (self.n, self.width);
        let mut scratch = Scratch::<1>::new(&self.tape);
        let samples = self.record.len().min(most);
        let mut x = Mat::<f64>::zeros(w, 1);
        let start = |k: usize| match (k.checked_sub(n), k < n + self.forces) {
            (None, _) => DIFFUSE * DIFFUSE,
            (_, true) => 0.5 * walk.power() * walk.memory,
            _ => 0.0,
        };
        let mut p = Mat::from_fn(w, w, |i, j| if i == j { start(i) } else { 0.0 });
        let mut out = Forward { predicted: vec![], updated: vec![], steps: vec![], likelihood: 0.0 };
        for i in 0..samples {
            out.predicted.push((x.clone(), p.clone()));
            self.at(&mut scratch, i, &x)?;
            // One column after the other: their noise is independent.
            for (k, column, variance) in self.sampled_at(i) {
                let first = n + (n + self.columns.len()) * w;
                let row = Mat::from_fn(1, w, |_, j| scratch.output(n + (n + k) * w + j)[0]);
                let mut predicted = scratch.output(first + k)[0];
                let (before, _) = &out.predicted[i];
                predicted += (&row * (&x - before))[(0, 0)];
                let ph = &p * row.transpose();
                let s = (&row * &ph)[(0, 0)] + variance;
                let miss = column[i] - predicted;
                x += faer::Scale(miss / s) * &ph;
                // Joseph's form keeps the covariance positive.
                let keep = Mat::from_fn(w, w, |a, b| f64::from(a == b) - ph[(a, 0)] / s * row[(0, b)]);
                p = &keep * &p * keep.transpose() + faer::Scale(variance / (s * s)) * (&ph * ph.transpose());
                // While the start is unknown, a sample says nothing about the forces.
                if i >= w {
                    out.likelihood -= 0.5 * (s.ln() + miss * miss / s);
                }
            }
            out.updated.push((x.clone(), p.clone()));
            if i + 1 == samples {
                break;
            }
            let h = self.record.time[i + 1] - self.record.time[i];
            self.at(&mut scratch, i, &x)?;
            let walks = |r: usize, c: usize| self.walks(walk, r, c);
            let of = |r: usize, c: usize| if r < n { scratch.output(n + r * w + c)[0] } else { walks(r, c) };
            let a = Mat::from_fn(w, w, of);
            let walked = |x: &Mat<f64>, r: usize| -> f64 { (n..w).map(|c| walks(r, c) * x[(c, 0)]).sum() };
            let own = |r: usize| if r < n { scratch.output(r)[0] } else { walked(&x, r) };
            let rate = Mat::from_fn(w, 1, |r, _| own(r));
            let (step, weight) = exponential(&a, h);
            // x' = f + A dx, held over the step.
            let start = &weight * &rate;
            let mut there = Mat::<f64>::zeros(w, 1);
            there += &x + start;
            if self.at(&mut scratch, i + 1, &there).is_some() {
                // Half of what inputs and curvature add towards the end of the step.
                let own = |r: usize| if r < n { scratch.output(r)[0] } else { walked(&there, r) };
                let end = Mat::from_fn(w, 1, |r, _| own(r));
                let linear = &rate + &a * (&there - &x);
                there += faer::Scale(0.5 * h) * (end - linear);
            }
            x = there;
            p = &step * &p * step.transpose();
            for k in n..n + self.forces {
                p[(k, k)] += walk.power() * h;
            }
            out.steps.push(step);
        }
        out.likelihood.is_finite().then_some(out)
    }

    /// States and forces of each sample. `None` where the covariance becomes singular.
    fn smoothed(&self, walk: Walk) -> Option<Vec<Mat<f64>>> {
        let smooth = self.backward(&self.forward(walk, usize::MAX)?)?;
        let finite = |x: &Mat<f64>| (0..self.n).all(|k| x[(k, 0)].is_finite());
        smooth.iter().all(finite).then_some(smooth)
    }

    /// Whether the outputs of estimated states are as near to the columns as those of a system at rest.
    fn is_near(&self, all: &[Mat<f64>]) -> bool {
        let rest = vec![Mat::<f64>::zeros(self.width, 1); all.len()];
        self.misfit(all).is_some_and(|own| own <= self.misfit(&rest).unwrap_or(f64::INFINITY))
    }

    /// The weighted squares of what estimated states leave of the columns.
    fn misfit(&self, all: &[Mat<f64>]) -> Option<f64> {
        let mut scratch = Scratch::<1>::new(&self.tape);
        let first = self.n + (self.n + self.columns.len()) * self.width;
        let mut sum = 0.0;
        for (i, x) in all.iter().enumerate() {
            self.at(&mut scratch, i, x)?;
            for (k, column, variance) in self.sampled_at(i) {
                sum += (column[i] - scratch.output(first + k)[0]).powi(2) / variance;
            }
        }
        sum.is_finite().then_some(sum)
    }

    /// The linear rates of the forces' states: the walk, its slow part, the slow part of the rest.
    fn walks(&self, walk: Walk, r: usize, c: usize) -> f64 {
        let (stage, own) = ((r - self.n) / self.forces, (r - self.n) % self.forces);
        let Some(from) = c.checked_sub(self.n).filter(|c| c % self.forces == own) else { return 0.0 };
        match (stage, from / self.forces) {
            (0, 0) => -1.0 / walk.memory,
            (1, 0) | (2, 0) => self.lowest,
            (1, 1) | (2, 1 | 2) => -self.lowest,
            _ => 0.0,
        }
    }

    /// The smoother, from the end of the record to its start.
    fn backward(&self, forward: &Forward) -> Option<Vec<Mat<f64>>> {
        let samples = forward.updated.len();
        let mut all = vec![Mat::<f64>::zeros(self.width, 1); samples];
        all[samples - 1] = forward.updated[samples - 1].0.clone();
        for i in (0..samples - 1).rev() {
            let ((x, p), (next, ahead)) = (&forward.updated[i], &forward.predicted[i + 1]);
            let cross = &forward.steps[i] * p;
            // Rounding of the diffuse start must not make the covariance singular.
            let ridge = COVARIANCE_RIDGE[0] * (0..self.width).map(|k| ahead[(k, k)]).fold(0.0, f64::max);
            let ahead = Mat::from_fn(self.width, self.width, |a, b| {
                0.5 * (ahead[(a, b)] + ahead[(b, a)])
                    + if a == b { ridge.min(COVARIANCE_RIDGE[1] * ahead[(a, a)]) } else { 0.0 }
            });
            let gain = ahead.partial_piv_lu().solve(&cross);
            all[i] = x + gain.transpose() * (&all[i + 1] - next);
        }
        Some(all)
    }
}

/// The expressions without what jumps: the sign of anything that moves is zero.
fn without_signs(graph: &mut Graph, roots: &[Id]) -> Vec<Id> {
    let mut with = HashMap::new();
    for id in graph.reachable(roots) {
        match graph.node(id) {
            Node::Unary(Unary::Sgn | Unary::Rest, _) => with.insert(id, graph.constant(0.0)),
            Node::Unary(Unary::Step, _) => with.insert(id, graph.constant(0.5)),
            _ => None,
        };
    }
    graph.replace(roots, &with)
}

/// `exp(A h)` and its integral over the step, by a series after enough halvings.
fn exponential(a: &Mat<f64>, h: f64) -> (Mat<f64>, Mat<f64>) {
    let w = a.nrows();
    let size = (0..w).map(|i| (0..w).map(|j| (a[(i, j)] * h).abs()).sum::<f64>()).fold(0.0, f64::max);
    let halvings = if size > 0.1 { (size / 0.1).log2().ceil().min(40.0) as i32 } else { 0 };
    let h = h / 2f64.powi(halvings);
    let identity = Mat::<f64>::identity(w, w);
    // Four terms: the next one is below 1e-6 of the step.
    let ah = faer::Scale(h) * a;
    let square = &ah * &ah;
    let cube = &square * &ah;
    let mut weight = faer::Scale(h)
        * (&identity
            + faer::Scale(0.5) * &ah
            + faer::Scale(1.0 / 6.0) * &square
            + faer::Scale(1.0 / 24.0) * &cube);
    let mut step = &identity + a * &weight;
    for _ in 0..halvings {
        weight = &weight + &step * &weight;
        step = &step * &step;
    }
    (step, weight)
}

#[cfg(test)]
mod tests {
    use super::*;
    use phisindy_phys::{Origin, SourceId, check, spec};
    use phisindy_signal::standard_deviation;
    use phisindy_sim::synthesize;

    /// How far the estimated states are from the true ones, by state, over the standard deviation.
    fn missed(truth: &str) -> Vec<f64> {
        let text = format!(
            r#"(states: {{ "x": "m", "v": "m/s" }}, inputs: {{ "f": "N" }}, outputs: {{ "a": (unit: "m/s^2", reads: "rate(v)") }},
                constants: {{ "m": (1.0, "kg"), "k": (400.0, "N/m"), "c": (1.0, "N*s/m") }},
                known: {{ "x": "v", "v": "(f - k*x - c*v)/m" }}, unknown: {{}},
                data: [ Synthetic(truth: {{ "v": "{truth}" }}, start: {{}}, duration: 10.0, step: 0.004, noise: Additive(0.01),
                    seed: 4, inputs: {{ "f": Multisine(amplitude: 8.0, band: (0.5, 6.0)) }}) ])"#
        );
        let (spec, _) = spec::read(&text, SourceId(0)).expect("a spec");
        let (case, _) = check(&spec, SourceId(0)).expect("a case");
        let Origin::Synthetic(made) = &case.records[0].origin else { panic!("a measured record") };
        let file = |_: &phisindy_phys::spec::InputSpec| Err("no files here".into());
        let (record, run) = synthesize(&case.records[0], made, &case.system, None, &file).expect("a record");
        let states = estimated_states(&case.system, &record).expect("states");
        let apart = |(k, x): (usize, &Vec<f64>)| {
            let truth = run.column(k);
            let apart: Vec<f64> = x.iter().zip(&truth).map(|(x, t)| x - t).collect();
            (apart.iter().map(|e| e * e).sum::<f64>() / apart.len() as f64).sqrt()
                / standard_deviation(&truth)
        };
        states.iter().enumerate().map(apart).collect()
    }

    #[test]
    fn an_accelerometer_tells_displacement_and_velocity() {
        // The last one triples the stiffness: no model of the filter holds it.
        for (truth, most) in [("0", 0.01), ("-1.5*sgn(v)/m", 0.1), ("-300000*x^3/m", 0.3)] {
            let missed = missed(truth);
            assert!(missed.iter().all(|part| *part < most), "{truth}: {missed:?}");
        }
    }
}
