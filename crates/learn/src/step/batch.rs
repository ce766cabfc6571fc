//! The one-step loss over all samples: data laid out once, evaluated many times, on all cores.
//!
//! What does not depend on the coefficients is evaluated once, when the batch is made: a loss tape then runs on the border between data and
//! coefficients, in blocks that stay in the first cache. Sums are kept for each lane and run over fixed blocks in a fixed order, so that
//! the number of threads does not change a bit.

use crate::step::onestep::OneStep;
use crate::step::train::StepOptions;
use phisindy_expr::{Cost, Id, Scratch, Tape, wide};
use phisindy_phys::spec::Crossings;
use phisindy_phys::{Record, System};
use phisindy_signal::standard_deviation;
use rayon::prelude::*;
use std::sync::Mutex;

/// Samples per block.
pub(crate) const LANES: usize = 64;
/// Blocks of one sum: partial sums are added in the order of the data.
const CHUNK: usize = 8;
/// Steps whose lengths differ by less than this part are of one length: clocks are not better.
const UNIFORM: f64 = 1e-9;

type Lane = [f64; LANES];

/// The loss of the paper: mean squared error of the forward and of the backward prediction, each state in units of its standard deviation,
/// over `horizon` steps.
pub(crate) struct Batch {
    kind: Kind,
    /// Number of coefficients and movable constants.
    pub(crate) parameters: usize,
    /// Number of residuals: samples times states times directions times horizon.
    pub(crate) residuals: usize,
}

enum Kind {
    /// One step: what depends on data alone is evaluated once.
    Single(Box<Single>),
    /// Several steps, rolled out.
    Rollout(Box<crate::step::rollout::Rollout>),
}

/// Inputs of the tapes: columns that vary, columns that are one number in each course, parameters.
struct Single {
    courses: Vec<Course>,
    varying: usize,
    loss: Bench,
    jacobian: Bench,
    states: usize,
}

/// The steps of a record in one direction.
struct Course {
    /// Lanes of the varying columns, block by block; the last block repeats its last step.
    lanes: Vec<Lane>,
    /// The columns that are one number here.
    uniform: Vec<f64>,
    steps: usize,
}

impl Course {
    /// Lanes of a block that are steps, the others are repetitions.
    fn live(&self, block: usize) -> usize {
        (self.steps - block * LANES).min(LANES)
    }
}

/// A tape and a scratch for each thread, kept from epoch to epoch.
struct Bench {
    tape: Tape,
    scratches: Vec<Mutex<Scratch<LANES>>>,
}

impl Bench {
    fn new(tape: Tape) -> Bench {
        let scratches = (0..rayon::current_num_threads()).map(|_| Mutex::new(Scratch::new(&tape))).collect();
        Bench { tape, scratches }
    }

    /// The scratch of this thread; nobody else wants it, so that the lock is free.
    fn with<R>(&self, work: impl FnOnce(&mut Scratch<LANES>) -> R) -> R {
        let mine = rayon::current_thread_index().unwrap_or(0) % self.scratches.len();
        work(&mut self.scratches[mine].lock().unwrap_or_else(|poisoned| poisoned.into_inner()))
    }
}

/// Standard deviation of each state over all records: the unit of its error.
pub(crate) fn deviations(system: &System, records: &[&Record]) -> Vec<f64> {
    (0..system.states.len())
        .map(|k| {
            let all: Vec<f64> =
                records.iter().filter_map(|r| r.columns[k].as_ref()).flatten().copied().collect();
            let deviation = standard_deviation(&all);
            if deviation > 0.0 { deviation } else { 1.0 }
        })
        .collect()
}

/// The length of a record's steps, if it is one.
fn step_length(record: &Record) -> Option<f64> {
    let n = record.len();
    let mean = (record.time[n - 1] - record.time[0]) / (n.max(2) - 1) as f64;
    record.time.windows(2).all(|t| (t[1] - t[0] - mean).abs() < UNIFORM * mean).then_some(mean)
}

/// One row of data for a step: time, length, its half, third and sixth, states, inputs at start, middle, end. `from` and `to` are neighbouring samples; going backward
/// the length is negative. Between samples an input is what its interpolation says (`Linear` is the paper's average of the two).
pub(crate) fn step_row(record: &Record, from: usize, to: usize, length: Option<f64>) -> Vec<f64> {
    let exact = record.time[to] - record.time[from];
    let h = length.map_or(exact, |length| length.copysign(exact));
    let mut row = vec![record.time[from], h, 0.5 * h, h / 3.0, h / 6.0];
    row.extend(record.columns.iter().map(|c| c.as_ref().map_or(0.0, |c| c[from])));
    row.extend(record.inputs.iter().map(|u| u.values()[from]));
    let middle = 0.5 * (record.time[from] + record.time[to]);
    row.extend(record.inputs.iter().map(|u| u.value(middle)));
    row.extend(record.inputs.iter().map(|u| u.values()[to]));
    row
}

impl Batch {
    /// Lays out the data of all records. Every record must have samples of every state; `constants[r]` are the record constants.
    pub(crate) fn new(
        step: &OneStep,
        free: usize,
        records: &[&Record],
        deviations: &[f64],
        options: &StepOptions,
    ) -> Batch {
        let horizon = options.horizon;
        let n = step.states.len();
        let starts: Vec<Vec<usize>> =
            records.iter().map(|r| window_starts(&step_contacts(step, free, r), r.len(), options)).collect();
        let steps: usize = starts.iter().map(Vec::len).sum();
        let residuals = 2 * n * steps * horizon;
        let weight = (1.0 / (n * horizon * steps.max(1)) as f64).sqrt();
        let weights: Vec<f64> = deviations.iter().map(|d| weight / d).collect();
        if horizon > 1 {
            let rollout =
                crate::step::rollout::Rollout::new(step.clone(), free, records, &starts, &weights, horizon);
            return Batch { kind: Kind::Rollout(Box::new(rollout)), parameters: free, residuals };
        }
        let mut step = step.clone();
        let (errors, targets) = step.residuals(&weights);
        let graph = &mut step.graph;
        let (free, given) = step.parameters.split_at(free);
        let mut total = graph.constant(0.0);
        for &e in &errors {
            let square = graph.mul(e, e);
            total = graph.add(total, square);
        }
        let mut outputs = vec![total];
        outputs.extend(graph.gradient(total, free));
        let mut matrix = errors.clone();
        errors.iter().for_each(|&e| matrix.extend(graph.gradient(e, free)));

        let mut all = outputs.clone();
        all.extend(&matrix);
        let border = graph.border(&all, free);
        let mut inputs = step.data.clone();
        inputs.extend(given);
        inputs.extend(&targets);
        let mut prologue = Scratch::new(&compile(&step, &inputs, &border));
        let mut courses = Vec::new();
        for (record, starts) in records.iter().zip(&starts).filter(|(_, starts)| !starts.is_empty()) {
            for backward in [false, true] {
                courses.push(course(record, starts, backward, &mut prologue, border.len()));
            }
        }
        // Columns that are one number in every course are written once for each of them, not read for each step.
        let uniform: Vec<bool> = (0..border.len())
            .map(|k| {
                courses.iter().all(|c| {
                    c.lanes.iter().skip(k).step_by(border.len()).all(|l| *l == [c.lanes[k][0]; LANES])
                })
            })
            .collect();
        for course in &mut courses {
            course.uniform = (0..border.len()).filter(|&k| uniform[k]).map(|k| course.lanes[k][0]).collect();
            let mut k = 0;
            course.lanes.retain(|_| {
                k += 1;
                !uniform[(k - 1) % border.len()]
            });
        }
        let of =
            |which: bool| border.iter().zip(&uniform).filter(move |(_, u)| **u == which).map(|(id, _)| *id);
        let rest: Vec<Id> = of(false).chain(of(true)).chain(free.iter().copied()).collect();
        let single = Single {
            courses,
            varying: of(false).count(),
            loss: Bench::new(compile(&step, &rest, &outputs)),
            jacobian: Bench::new(compile(&step, &rest, &matrix)),
            states: n,
        };
        Batch { kind: Kind::Single(Box::new(single)), parameters: free.len(), residuals }
    }

    /// What the loss tape costs per sample and direction.
    pub(crate) fn cost(&self) -> Cost {
        match &self.kind {
            Kind::Single(single) => single.loss.tape.cost(),
            Kind::Rollout(rollout) => rollout.cost(),
        }
    }

    /// The loss and its gradient.
    pub(crate) fn loss(&self, parameters: &[f64], gradient: &mut [f64]) -> f64 {
        let p = self.parameters;
        let sums = match &self.kind {
            Kind::Rollout(rollout) => rollout.loss(parameters),
            Kind::Single(single) => single.sum(&single.loss, &parameters[..p], 1 + p, |scratch, sums| {
                for (k, sum) in sums.iter_mut().enumerate() {
                    let out = scratch.output(k);
                    (0..LANES).for_each(|l| sum[l] += out[l]);
                }
            }),
        };
        gradient.copy_from_slice(&sums[1..]);
        sums[0]
    }

    /// The loss and the normal equations of its Gauss-Newton step: upper triangle of `J^T J` row by row, then `J^T e`.
    pub(crate) fn normal(&self, parameters: &[f64]) -> (f64, Vec<f64>, Vec<f64>) {
        let p = self.parameters;
        let size = 1 + p * (p + 1) / 2 + p;
        let sums = match &self.kind {
            Kind::Rollout(rollout) => rollout.normal(parameters),
            Kind::Single(single) => single.sum(&single.jacobian, &parameters[..p], size, |scratch, sums| {
                for i in 0..single.states {
                    let column = |k: usize| scratch.output(single.states + i * p + k);
                    accumulate(scratch.output(i), column, p, sums);
                }
            }),
        };
        let (triangle, right) = sums[1..].split_at(p * (p + 1) / 2);
        (sums[0], triangle.to_vec(), right.to_vec())
    }
}

impl Single {
    /// Runs a tape over all blocks and sums what `add` takes from each: threads take fixed chunks, chunks are summed in order.
    fn sum(
        &self,
        bench: &Bench,
        parameters: &[f64],
        size: usize,
        add: impl Fn(&Scratch<LANES>, &mut [Lane]) + Sync,
    ) -> Vec<f64> {
        let chunks: Vec<(&Course, usize)> = self
            .courses
            .iter()
            .flat_map(|c| (0..c.steps.div_ceil(LANES)).step_by(CHUNK).map(move |first| (c, first)))
            .collect();
        let chunk = |&(course, first): &(&Course, usize)| {
            bench.with(|scratch| {
                let numbers = course.uniform.iter().chain(parameters);
                numbers.enumerate().for_each(|(k, &value)| *scratch.input(self.varying + k) = [value; LANES]);
                let mut sums = vec![[0.0; LANES]; size];
                for block in first..(first + CHUNK).min(course.steps.div_ceil(LANES)) {
                    scratch.run_on(&course.lanes[block * self.varying..][..self.varying]);
                    let live = course.live(block);
                    let before = if live < LANES { sums.clone() } else { vec![] };
                    wide(
                        #[inline(always)]
                        || add(scratch, &mut sums),
                    );
                    // What the repetitions added is taken back.
                    sums.iter_mut()
                        .zip(before)
                        .for_each(|(sum, before)| sum[live..].copy_from_slice(&before[live..]));
                }
                sums.iter().map(|lane| lane.iter().sum()).collect()
            })
        };
        // As few tasks as there are threads: each finds its part of the data in its own cache, epoch after epoch.
        let share = chunks.len().div_ceil(rayon::current_num_threads()).max(1);
        in_order(chunks.par_iter().with_min_len(share).map(chunk).collect(), size)
    }
}

/// The steps of a record in one direction, with every column of the border.
fn course(
    record: &Record,
    starts: &[usize],
    backward: bool,
    prologue: &mut Scratch<LANES>,
    border: usize,
) -> Course {
    let length = step_length(record);
    let mut lanes = Vec::with_capacity(starts.len().div_ceil(LANES) * border);
    for block in starts.chunks(LANES) {
        for lane in 0..LANES {
            let start = block[lane.min(block.len() - 1)];
            let (from, to) = if backward { (start + 1, start) } else { (start, start + 1) };
            let mut row = step_row(record, from, to, length);
            row.extend(&record.constants);
            row.extend(record.columns.iter().map(|c| c.as_ref().map_or(0.0, |c| c[to])));
            row.iter().enumerate().for_each(|(k, &value)| prologue.input(k)[lane] = value);
        }
        prologue.run();
        lanes.extend((0..border).map(|k| *prologue.output(k)));
    }
    Course { lanes, uniform: vec![], steps: starts.len() }
}

/// Adds up what the threads summed, in the order of the data: the same bits for any number of threads.
pub(crate) fn in_order(partial: Vec<Vec<f64>>, size: usize) -> Vec<f64> {
    let mut total = vec![0.0; size];
    for sums in partial {
        total.iter_mut().zip(sums).for_each(|(t, s)| *t += s);
    }
    total
}

/// The velocity of every contact at every sample. Constants that move must be numbers in `step.contacts` already; those of the record are
/// the parameters beyond the `free` ones.
fn step_contacts(step: &OneStep, free: usize, record: &Record) -> Vec<Vec<f64>> {
    let mut inputs = step.data.clone();
    inputs.extend(&step.parameters[free..]);
    let tape = compile(step, &inputs, &step.contacts);
    let mut scratch = Scratch::<1>::new(&tape);
    let mut out = vec![Vec::with_capacity(record.len()); step.contacts.len()];
    for k in 0..record.len() {
        let row = step_row(record, k, k, None);
        scratch.at(row.into_iter().chain(record.constants.iter().copied()));
        out.iter_mut().enumerate().for_each(|(c, column)| column.push(scratch.output(c)[0]));
    }
    out
}

/// First samples of the windows that are used: all, or those in which no contact changes its direction.
fn window_starts(contacts: &[Vec<f64>], samples: usize, options: &StepOptions) -> Vec<usize> {
    let crosses = |k: usize| contacts.iter().any(|w| w[k] * w[k + 1] < 0.0);
    let keep = options.crossings == Crossings::Keep;
    (0..samples.saturating_sub(options.horizon))
        .filter(|&start| keep || !(start..start + options.horizon).any(crosses))
        .collect()
}

/// Adds one residual lane to `[loss, triangle of J^T J, J^T e]`, lane by lane.
#[inline(always)]
pub(crate) fn accumulate<'a>(error: &Lane, column: impl Fn(usize) -> &'a Lane, p: usize, sums: &mut [Lane]) {
    let dot = |a: &Lane, b: &Lane, sum: &mut Lane| (0..LANES).for_each(|l| sum[l] += a[l] * b[l]);
    dot(error, error, &mut sums[0]);
    let mut at = 1;
    for i in 0..p {
        for j in i..p {
            dot(column(i), column(j), &mut sums[at]);
            at += 1;
        }
    }
    for i in 0..p {
        dot(column(i), error, &mut sums[at + i]);
    }
}

/// Compiles what was built from inputs alone.
pub(crate) fn compile(step: &OneStep, inputs: &[Id], outputs: &[Id]) -> Tape {
    Tape::compile(&step.graph, inputs, outputs)
        .unwrap_or_else(|e| unreachable!("every symbol of a step is an input: {}", e.message(&step.names)))
}

#[cfg(test)]
mod tests;
