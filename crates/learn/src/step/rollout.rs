//! The loss over several steps: forward storing the states, backward applying the adjoint of one step. The
//! tape does not grow with the horizon; memory is one state per step.

use crate::step::lanes::{LANES, Lane, accumulate, in_order};
use crate::step::onestep::{FIRST_STATE, OneStep};
use crate::step::windows::step_row;
use phisindy_expr::{Cost, Scratch, Tape};
use phisindy_phys::Record;
use rayon::prelude::*;

pub(crate) struct Rollout {
    /// Windows of `horizon + 1` rows each, forward and backward, as data of the steps.
    windows: Vec<Window>,
    weights: Vec<f64>,
    horizon: usize,
    free: usize,
    /// data, parameters -> next state
    next: Tape,
    /// data, parameters, cotangent -> cotangent of the states, of the free parameters
    adjoint: Tape,
    /// data, parameters -> d next / d state, d next / d free
    jacobian: Tape,
}

/// Data of the steps of one window (states of the first row only are used), and the measured state after each
/// step.
struct Window {
    rows: Vec<Vec<f64>>,
    targets: Vec<Vec<f64>>,
    constants: Vec<f64>,
}

impl Rollout {
    pub(crate) fn new(
        mut step: OneStep,
        free: usize,
        records: &[&Record],
        starts: &[Vec<usize>],
        weights: &[f64],
        horizon: usize,
    ) -> Rollout {
        let n = step.states.len();
        let seeds: Vec<_> = (0..n)
            .map(|i| {
                let s = step.names.intern(&format!("cotangent {i}"));
                step.graph.symbol(s)
            })
            .collect();
        let mut inputs = step.data.clone();
        inputs.extend(&step.parameters);
        let mut wrt = step.states.clone();
        wrt.extend(&step.parameters[..free]);
        let roots = step.next.clone();
        let adjoint = step.graph.vjp(&roots, &seeds, &wrt);
        let mut jacobian = Vec::new();
        roots.iter().for_each(|&r| jacobian.extend(step.graph.gradient(r, &wrt)));
        let mut with_seeds = inputs.clone();
        with_seeds.extend(&seeds);
        let mut windows = Vec::new();
        for (record, starts) in records.iter().zip(starts) {
            for &start in starts {
                for backward in [false, true] {
                    let at = |k: usize| if backward { start + horizon - k } else { start + k };
                    let state = |k: usize| -> Vec<f64> {
                        record.columns.iter().map(|c| c.as_ref().map_or(0.0, |c| c[k])).collect()
                    };
                    windows.push(Window {
                        rows: (0..horizon).map(|k| step_row(record, at(k), at(k + 1), None)).collect(),
                        targets: (1..=horizon).map(|k| state(at(k))).collect(),
                        constants: record.constants.clone(),
                    });
                }
            }
        }
        Rollout {
            windows,
            weights: weights.to_vec(),
            horizon,
            free,
            next: step.compile(&inputs, &step.next),
            adjoint: step.compile(&with_seeds, &adjoint),
            jacobian: step.compile(&inputs, &jacobian),
        }
    }

    pub(crate) fn cost(&self) -> Cost {
        self.next.cost().with(self.adjoint.cost(), self.horizon)
    }

    /// `[loss, gradient]`
    pub(crate) fn loss(&self, parameters: &[f64]) -> Vec<f64> {
        let (n, p) = (self.weights.len(), self.free);
        self.over_blocks(1 + p, |block, sums| {
            let mut next = Scratch::<LANES>::new(&self.next);
            let mut adjoint = Scratch::<LANES>::new(&self.adjoint);
            let states = self.forward(block, parameters, &mut next);
            let mut cotangent = vec![[0.0; LANES]; n];
            for k in (0..self.horizon).rev() {
                for (i, bar) in cotangent.iter_mut().enumerate() {
                    let error = self.error(block, &states, k, i);
                    (0..LANES).for_each(|l| sums[0][l] += error[l] * error[l]);
                    bar.iter_mut().zip(&error).for_each(|(bar, e)| *bar += 2.0 * self.weights[i] * e);
                }
                let data = self.load(block, k, &states[k], parameters, &mut adjoint);
                (0..n).for_each(|i| *adjoint.input(data + i) = cotangent[i]);
                adjoint.run();
                (0..n).for_each(|i| cotangent[i] = *adjoint.output(i));
                for (j, sum) in sums[1..].iter_mut().enumerate() {
                    let share = adjoint.output(n + j);
                    (0..LANES).for_each(|l| sum[l] += share[l]);
                }
            }
        })
    }

    /// `[loss, triangle of J^T J, J^T e]`
    pub(crate) fn normal(&self, parameters: &[f64]) -> Vec<f64> {
        let (n, p) = (self.weights.len(), self.free);
        self.over_blocks(1 + p * (p + 1) / 2 + p, |block, sums| {
            let mut next = Scratch::<LANES>::new(&self.next);
            let mut jacobian = Scratch::<LANES>::new(&self.jacobian);
            let states = self.forward(block, parameters, &mut next);
            let mut s = vec![[0.0; LANES]; n * p];
            for k in 0..self.horizon {
                self.load(block, k, &states[k], parameters, &mut jacobian);
                jacobian.run();
                let mut after = vec![[0.0; LANES]; n * p];
                for i in 0..n {
                    for j in 0..p {
                        let out = &mut after[i * p + j];
                        *out = *jacobian.output(i * (n + p) + n + j);
                        for m in 0..n {
                            let a = jacobian.output(i * (n + p) + m);
                            (0..LANES).for_each(|l| out[l] += a[l] * s[m * p + j][l]);
                        }
                    }
                }
                s = after;
                for i in 0..n {
                    let error = self.error(block, &states, k, i);
                    let live = block.len();
                    let scaled: Vec<Lane> = (0..p)
                        .map(|j| {
                            std::array::from_fn(|l| {
                                if l < live { self.weights[i] * s[i * p + j][l] } else { 0.0 }
                            })
                        })
                        .collect();
                    accumulate(&error, |j| &scaled[j], p, sums);
                }
            }
        })
    }

    /// States at the start and after each step; lanes beyond the block repeat its last window.
    fn forward(&self, block: &[Window], parameters: &[f64], next: &mut Scratch<LANES>) -> Vec<Vec<Lane>> {
        let n = self.weights.len();
        let first = (0..n)
            .map(|i| std::array::from_fn(|l| block[l.min(block.len() - 1)].rows[0][FIRST_STATE + i]))
            .collect();
        let mut states: Vec<Vec<Lane>> = vec![first];
        for k in 0..self.horizon {
            self.load(block, k, &states[k], parameters, next);
            next.run();
            states.push((0..n).map(|i| *next.output(i)).collect());
        }
        states
    }

    /// Writes data, states and parameters of step `k`; returns how many inputs that were.
    fn load(
        &self,
        block: &[Window],
        k: usize,
        states: &[Lane],
        parameters: &[f64],
        scratch: &mut Scratch<LANES>,
    ) -> usize {
        let n = self.weights.len();
        let width = block[0].rows[0].len();
        for at in 0..width {
            *scratch.input(at) = if (FIRST_STATE..FIRST_STATE + n).contains(&at) {
                states[at - FIRST_STATE]
            } else {
                std::array::from_fn(|l| block[l.min(block.len() - 1)].rows[k][at])
            };
        }
        for (j, &value) in parameters[..self.free].iter().enumerate() {
            *scratch.input(width + j) = [value; LANES];
        }
        for j in 0..block[0].constants.len() {
            *scratch.input(width + self.free + j) =
                std::array::from_fn(|l| block[l.min(block.len() - 1)].constants[j]);
        }
        width + self.free + block[0].constants.len()
    }

    fn error(&self, block: &[Window], states: &[Vec<Lane>], k: usize, i: usize) -> Lane {
        std::array::from_fn(|l| {
            block.get(l).map_or(0.0, |w| self.weights[i] * (states[k + 1][i][l] - w.targets[k][i]))
        })
    }

    fn over_blocks(&self, size: usize, each: impl Fn(&[Window], &mut [Lane]) + Sync) -> Vec<f64> {
        let partial: Vec<Vec<f64>> = self
            .windows
            .par_chunks(LANES)
            .map(|block| {
                let mut sums = vec![[0.0; LANES]; size];
                each(block, &mut sums);
                sums.iter().map(|lane| lane.iter().sum()).collect()
            })
            .collect();
        in_order(partial, size)
    }
}
