//! A record prepared for the regression: the measured motion, the linear system and its response, rest at
//! each place.

use super::response::{Linear, shift};
use crate::decisions::{FORGETS_PER_PERIOD, RESTS, SHORT_REST};
use crate::drive::Drive;
use crate::evaluate::{evaluated, speed};
use crate::model::TrialModel;
use crate::motion::{Motion, rest_threshold, resting};
use crate::place::Site;
use crate::whiteness::lines;
use phisindy_expr::{Id, Tape};
use phisindy_learn::Calibration;
use phisindy_phys::System;

/// One record, prepared for the regression.
pub(super) struct RegressionData {
    pub(super) motion: Motion,
    /// The linear system that gives responses.
    pub(super) linear: Linear,
    /// Rates minus A x, samples x n: the input of the linear system.
    pub(super) bracket: Vec<f64>,
    /// Measured columns: state, value, weight.
    pub(super) rows: Vec<(usize, Vec<f64>, f64)>,
    /// Rate of every state at every sample. At rest, friction of the model balances the other forces.
    pub(super) rates: Vec<f64>,
    stride: usize,
    /// The response to the known rates, samples x n.
    pub(super) known: Vec<f64>,
    /// Rest at each place of a force.
    pub(super) still: Vec<PlaceAtRest>,
    /// The strongest spectral lines of the fitted model's residuals. In the smoothed motion noise of a few
    /// per cent hides them.
    pub(super) left: Vec<f64>,
    /// Frequencies of the drive of the base model (rad/s).
    pub(super) drive: Vec<f64>,
}

/// The samples at which the velocity of a place is at rest.
pub(super) struct PlaceAtRest {
    pub(super) at: String,
    pub(super) rests: Vec<bool>,
    /// The state that friction of the model holds there.
    pub(super) stuck_state: Option<usize>,
}

/// A tape of the known rates, their Jacobian and their derivatives by the parameters.
pub(super) struct Base {
    pub(super) tape: Tape,
    pub(super) n: usize,
    pub(super) parameters: usize,
}

impl Base {
    pub(super) fn new(system: &System) -> Option<Base> {
        let mut graph = system.graph.clone();
        let n = system.states.len();
        let states: Vec<Id> = system.states.iter().map(|s| s.node).collect();
        let parameters: Vec<Id> = system.parameters.iter().map(|p| p.node).collect();
        let mut outputs = system.known.clone();
        for row in 0..n {
            outputs.extend(graph.gradient(system.known[row], &states));
        }
        for row in 0..n {
            outputs.extend(graph.gradient(system.known[row], &parameters));
        }
        let one = graph.constant(1.0);
        outputs.extend(system.inertia.iter().map(|m| m.unwrap_or(one)));
        let tape = Tape::compile(&graph, &system.arguments(), &outputs).ok()?;
        Some(Base { tape, n, parameters: parameters.len() })
    }

    pub(super) fn data(
        &self,
        model: &TrialModel,
        record: usize,
        fitted: &Calibration,
        noise: &[Vec<f64>],
        stride: usize,
    ) -> Option<RegressionData> {
        let (n, system) = (self.n, &model.system);
        let data = &model.records[record];
        let motion = Motion::new(system, data, &model.smooth[record], record, fitted);
        let samples = motion.samples();
        let values = evaluated(&self.tape, &motion, &[], &[]);
        if values[..n + n * n].iter().flatten().any(|v| !v.is_finite()) {
            return None;
        }
        let mean = |column: &[f64]| column.iter().sum::<f64>() / samples as f64;
        let mut a: Vec<f64> = values[n..n + n * n].iter().map(|c| mean(c)).collect();
        let span = motion.time[samples - 1] - motion.time[0];
        let mut rates: Vec<f64> = vec![0.0; samples * n];
        (0..samples * n).for_each(|i| rates[i] = values[i % n][i / n]);
        // Rest of all places: friction is, or may be missing, there.
        let mut still: Vec<PlaceAtRest> = Vec::new();
        for place in model.places() {
            let Site::Force { acts, velocity, .. } = &place.site else { continue };
            let speed = speed(system, &motion, place)?;
            let least = ((SHORT_REST * motion.period / (span / samples as f64)) as usize).clamp(5, samples);
            let rests = resting(&speed, rest_threshold(&speed), least);
            // Friction of the model balances the other forces during rest.
            let own = system.contacts.iter().any(|c| c.node == velocity.node && system.rubs(c));
            if own {
                let inertia = |k: usize, i: usize| values[n + n * n + n * self.parameters + k][i];
                for i in (0..samples).filter(|&i| rests[i]) {
                    let (mut toward, mut give) = (0.0, 0.0);
                    for (j, &(k, sign)) in acts.iter().enumerate() {
                        let c = if j == 0 { 1.0 } else { -1.0 };
                        toward += c * rates[i * n + k];
                        give += c * sign / inertia(k, i);
                    }
                    for &(k, sign) in acts {
                        rates[i * n + k] -= toward / give * sign / inertia(k, i);
                    }
                }
            }
            let stuck_state = system.state(&place.at).filter(|_| own);
            still.push(PlaceAtRest { at: place.at.clone(), rests, stuck_state });
        }
        // A body at rest loses the memory of its motion. The linear system must decay as well, or it carries
        // errors from before a stop past it.
        let has_stops = still.iter().any(|s| s.rests.iter().filter(|r| **r).count() * RESTS > samples);
        let decay = shift(&a, n, span).max(if has_stops { FORGETS_PER_PERIOD / motion.period } else { 0.0 });
        (0..n).for_each(|k| a[k * n + k] -= decay);
        let bracket: Vec<f64> = (0..samples)
            .flat_map(|i| {
                let x = &motion.states[i * n..(i + 1) * n];
                let rates = &rates;
                let a = &a;
                (0..n).map(move |row| rates[i * n + row] - (0..n).map(|k| a[row * n + k] * x[k]).sum::<f64>())
            })
            .collect();
        let rows = (0..n)
            .filter_map(|k| {
                let column = data.columns[k].as_ref()?;
                Some((k, column.clone(), 1.0 / noise[record][k]))
            })
            .collect();
        let linear = Linear::new(&a, n, &motion.time);
        let known = linear.response(&bracket, &motion.states[..n]);
        let step = span / (samples - 1) as f64;
        let left = fitted.records[record].residuals.iter().flat_map(|e| lines(e, step, 4, 0)).collect();
        let bare = model.without_effects();
        let drive = Drive::new(&bare.system, &bare.records[record]).map_or(vec![], |mut d| d.lines());
        Some(RegressionData { motion, linear, known, bracket, rows, rates, stride, still, left, drive })
    }
}

impl RegressionData {
    /// The frequency resolution of the record (rad/s).
    pub(super) fn resolution(&self) -> f64 {
        let (time, samples) = (&self.motion.time, self.motion.samples());
        2.0 * std::f64::consts::PI * (samples - 1) as f64 / (samples as f64 * (time[samples - 1] - time[0]))
    }

    /// Number of rows of this record.
    pub(super) fn height(&self) -> usize {
        self.rows.len() * self.motion.samples().div_ceil(self.stride)
    }

    /// The measured columns as rows.
    pub(super) fn measured(&self) -> Vec<f64> {
        let mut out = Vec::with_capacity(self.height());
        for (_, column, weight) in &self.rows {
            out.extend(column.iter().step_by(self.stride).map(|y| y * weight));
        }
        out
    }

    /// A response of all states (samples x n) as the sensors read it. With `whole` the sensor offsets are
    /// included, which do not apply to the response of a single column.
    pub(super) fn read(&self, states: &[f64], whole: bool) -> Vec<f64> {
        let n = states.len() / self.motion.samples();
        let mut out = Vec::with_capacity(self.height());
        for (k, _, weight) in &self.rows {
            let (gain, offset) = self.motion.sensors[*k];
            let offset = if whole { offset } else { 0.0 };
            out.extend(
                (0..self.motion.samples())
                    .step_by(self.stride)
                    .map(|i| weight * (gain * states[i * n + k] + offset)),
            );
        }
        out
    }

    /// The derivative of the readings by a sensor parameter of some states: 0 offset, 1 gain, 2 delay.
    pub(super) fn sensor(&self, states: &[usize], which: usize) -> Vec<f64> {
        let n = self.rates.len() / self.motion.samples();
        let mut out = Vec::with_capacity(self.height());
        for (k, _, weight) in &self.rows {
            let on = states.contains(k);
            let gain = self.motion.sensors[*k].0;
            out.extend((0..self.motion.samples()).step_by(self.stride).map(|i| {
                let change = match which {
                    0 => 1.0,
                    // Proportional to the model's response; a column of the measured values themselves would
                    // explain everything.
                    1 => self.known[i * n + k],
                    _ => -gain * self.slope(i, *k, n),
                };
                if on { weight * change } else { 0.0 }
            }));
        }
        out
    }

    /// Time derivative of a state by central differences, which serve every state; a smoothed velocity exists
    /// for displacements only.
    pub(super) fn slope(&self, i: usize, k: usize, n: usize) -> f64 {
        let t = &self.motion.time;
        let (a, b) = (i.saturating_sub(1), (i + 1).min(t.len() - 1));
        (self.motion.states[b * n + k] - self.motion.states[a * n + k]) / (t[b] - t[a])
    }

    /// Zeroes a force on bodies that rest in a contact of the model.
    pub(super) fn zero_at_rest(&self, g: &mut [f64]) {
        let n = g.len() / self.motion.samples();
        for (k, rests) in self.still.iter().filter_map(|s| Some((s.stuck_state?, &s.rests))) {
            rests.iter().enumerate().filter(|(_, r)| **r).for_each(|(i, _)| g[i * n + k] = 0.0);
        }
    }
}
