//! The loss over one step. What does not depend on the coefficients is evaluated once, when the loss is laid
//! out: the tapes run on the border between data and coefficients, in blocks that stay in the first cache.

use crate::step::lanes::{LANES, Lane, accumulate, in_order};
use crate::step::onestep::OneStep;
use crate::step::windows::{step_length, step_row};
use phisindy_expr::{Cost, Id, Scratch, Tape, wide};
use phisindy_phys::Record;
use rayon::prelude::*;
use std::sync::Mutex;

/// Blocks of one sum: partial sums are added in the order of the data.
const CHUNK: usize = 8;

/// Inputs of the tapes: columns that vary, columns that are one number in each sequence, parameters.
pub(crate) struct Single {
    sequences: Vec<StepSequence>,
    varying: usize,
    loss: Evaluator,
    jacobian: Evaluator,
    states: usize,
    parameters: usize,
}

/// The steps of a record in one direction.
struct StepSequence {
    /// Lanes of the varying columns, block by block; the last block repeats its last step.
    lanes: Vec<Lane>,
    /// The columns that are one number here.
    uniform: Vec<f64>,
    steps: usize,
}

impl StepSequence {
    /// Lanes of a block that are steps, the others are repetitions.
    fn live(&self, block: usize) -> usize {
        (self.steps - block * LANES).min(LANES)
    }
}

/// A tape and a scratch for each thread, kept from epoch to epoch.
struct Evaluator {
    tape: Tape,
    scratches: Vec<Mutex<Scratch<LANES>>>,
}

impl Evaluator {
    fn new(tape: Tape) -> Evaluator {
        let scratches = (0..rayon::current_num_threads()).map(|_| Mutex::new(Scratch::new(&tape))).collect();
        Evaluator { tape, scratches }
    }

    /// The scratch of this thread; nobody else wants it, so that the lock is free.
    fn with<R>(&self, work: impl FnOnce(&mut Scratch<LANES>) -> R) -> R {
        let mine = rayon::current_thread_index().unwrap_or(0) % self.scratches.len();
        work(&mut self.scratches[mine].lock().unwrap_or_else(|poisoned| poisoned.into_inner()))
    }
}

impl Single {
    /// Lays out the data; `weights` multiply the error of each state, `starts` are the first samples of the
    /// steps of each record, and the first `free` parameters of the step are the coefficients and movable
    /// constants.
    pub(crate) fn new(
        step: &OneStep,
        free: usize,
        records: &[&Record],
        starts: &[Vec<usize>],
        weights: &[f64],
    ) -> Single {
        let mut step = step.clone();
        let (errors, targets) = step.residuals(weights);
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
        let mut prologue = Scratch::new(&step.compile(&inputs, &border));
        let mut sequences = Vec::new();
        for (record, starts) in records.iter().zip(starts).filter(|(_, starts)| !starts.is_empty()) {
            for backward in [false, true] {
                sequences.push(sequence(record, starts, backward, &mut prologue, border.len()));
            }
        }
        // Columns that are one number in every sequence are written once for each of them, not read for each
        // step.
        let uniform: Vec<bool> = (0..border.len())
            .map(|k| {
                sequences.iter().all(|c| {
                    c.lanes.iter().skip(k).step_by(border.len()).all(|l| *l == [c.lanes[k][0]; LANES])
                })
            })
            .collect();
        for sequence in &mut sequences {
            sequence.uniform =
                (0..border.len()).filter(|&k| uniform[k]).map(|k| sequence.lanes[k][0]).collect();
            let mut k = 0;
            sequence.lanes.retain(|_| {
                k += 1;
                !uniform[(k - 1) % border.len()]
            });
        }
        let of =
            |which: bool| border.iter().zip(&uniform).filter(move |(_, u)| **u == which).map(|(id, _)| *id);
        let rest: Vec<Id> = of(false).chain(of(true)).chain(free.iter().copied()).collect();
        Single {
            sequences,
            varying: of(false).count(),
            loss: Evaluator::new(step.compile(&rest, &outputs)),
            jacobian: Evaluator::new(step.compile(&rest, &matrix)),
            states: weights.len(),
            parameters: free.len(),
        }
    }

    /// What the loss tape costs per sample and direction.
    pub(crate) fn cost(&self) -> Cost {
        self.loss.tape.cost()
    }

    /// `[loss, gradient]`
    pub(crate) fn loss(&self, parameters: &[f64]) -> Vec<f64> {
        let p = self.parameters;
        self.sum(&self.loss, &parameters[..p], 1 + p, |scratch, sums| {
            for (k, sum) in sums.iter_mut().enumerate() {
                let out = scratch.output(k);
                (0..LANES).for_each(|l| sum[l] += out[l]);
            }
        })
    }

    /// `[loss, triangle of J^T J, J^T e]`
    pub(crate) fn normal(&self, parameters: &[f64]) -> Vec<f64> {
        let p = self.parameters;
        let size = 1 + p * (p + 1) / 2 + p;
        self.sum(&self.jacobian, &parameters[..p], size, |scratch, sums| {
            for i in 0..self.states {
                let column = |k: usize| scratch.output(self.states + i * p + k);
                accumulate(scratch.output(i), column, p, sums);
            }
        })
    }

    /// Runs a tape over all blocks and sums what `add` takes from each: threads take fixed chunks, chunks are
    /// summed in order.
    fn sum(
        &self,
        evaluator: &Evaluator,
        parameters: &[f64],
        size: usize,
        add: impl Fn(&Scratch<LANES>, &mut [Lane]) + Sync,
    ) -> Vec<f64> {
        let chunks: Vec<(&StepSequence, usize)> = self
            .sequences
            .iter()
            .flat_map(|c| (0..c.steps.div_ceil(LANES)).step_by(CHUNK).map(move |first| (c, first)))
            .collect();
        let chunk = |&(sequence, first): &(&StepSequence, usize)| {
            evaluator.with(|scratch| {
                let numbers = sequence.uniform.iter().chain(parameters);
                numbers.enumerate().for_each(|(k, &value)| *scratch.input(self.varying + k) = [value; LANES]);
                let mut sums = vec![[0.0; LANES]; size];
                for block in first..(first + CHUNK).min(sequence.steps.div_ceil(LANES)) {
                    scratch.run_on(&sequence.lanes[block * self.varying..][..self.varying]);
                    let live = sequence.live(block);
                    let before = if live < LANES { sums.clone() } else { vec![] };
                    wide(
                        #[inline(always)]
                        || add(scratch, &mut sums),
                    );
                    // Remove what the repeated lanes added.
                    sums.iter_mut()
                        .zip(before)
                        .for_each(|(sum, before)| sum[live..].copy_from_slice(&before[live..]));
                }
                sums.iter().map(|lane| lane.iter().sum()).collect()
            })
        };
        // As few tasks as there are threads: each finds its part of the data in its own cache, epoch after
        // epoch.
        let share = chunks.len().div_ceil(rayon::current_num_threads()).max(1);
        in_order(chunks.par_iter().with_min_len(share).map(chunk).collect(), size)
    }
}

/// The steps of a record in one direction, with every column of the border.
fn sequence(
    record: &Record,
    starts: &[usize],
    backward: bool,
    prologue: &mut Scratch<LANES>,
    border: usize,
) -> StepSequence {
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
    StepSequence { lanes, uniform: vec![], steps: starts.len() }
}
