//! The internal states of laws, driven by a motion.

use crate::model::TrialModel;
use phisindy_expr::{Id, Scratch, Tape};
use phisindy_phys::{Record, System};

/// Internal states along a motion by exponential Euler steps, exact where a rate is linear in its state. A step ends
/// where the rate vanishes, if that lies on its way: with the motion held, no solution crosses such a point.
///
/// The tape gives their rates, then the derivative of each by its own state. They are its inputs `states.0` and the
/// next ones, `states.1` of them; `motion` sets the others for the step that begins at a sample.
pub(crate) fn internal_states(
    tape: &Tape,
    states: (usize, usize),
    time: &[f64],
    motion: &mut dyn FnMut(usize, &mut Scratch<1>),
) -> Vec<Vec<f64>> {
    let (first, count) = states;
    let mut scratch = Scratch::<1>::new(tape);
    let mut all = vec![vec![0.0; time.len()]; count];
    for i in 0..time.len().saturating_sub(1) {
        motion(i, &mut scratch);
        (0..count).for_each(|j| scratch.input(first + j)[0] = all[j][i]);
        scratch.run();
        let at: Vec<(f64, f64)> =
            (0..count).map(|j| (scratch.output(j)[0], scratch.output(count + j)[0])).collect();
        let h = time[i + 1] - time[i];
        for (j, (rate, slope)) in at.into_iter().enumerate() {
            let decay = slope * h;
            let factor = if decay.abs() < 1e-8 { h } else { decay.exp_m1() / slope };
            let now = all[j][i];
            let next = now + rate * factor;
            let next = if next.is_finite() { next } else { 0.0 };
            all[j][i + 1] = before_rest(&mut scratch, (first + j, j), (now, next), rate);
            scratch.input(first + j)[0] = now;
        }
    }
    all
}

/// The end of a step of an internal state from `now` to `next`, or the place between them where its rate vanishes.
/// The state is input `at.0` of the tape, its rate output `at.1`.
fn before_rest(scratch: &mut Scratch<1>, at: (usize, usize), (now, next): (f64, f64), rate: f64) -> f64 {
    let mut rate_at = |z: f64| {
        scratch.input(at.0)[0] = z;
        scratch.run();
        scratch.output(at.1)[0]
    };
    if rate == 0.0 || rate_at(next) * rate >= 0.0 {
        return next;
    }
    let (mut inside, mut outside) = (now, next);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (inside + outside);
        if rate_at(middle) * rate >= 0.0 { inside = middle } else { outside = middle }
    }
    inside
}

/// A step that would cross a point of rest is halved so often: to a millionth of itself.
const HALVINGS: usize = 20;

/// The last states of a system, `count` of them, along the smoothed motion of a record, with the model's numbers as they
/// start. `None` where the motion is not known, or their rates cannot be evaluated.
fn driven(system: &System, smooth: &Record, count: usize) -> Option<Vec<Vec<f64>>> {
    let (n, m) = (system.states.len(), system.inputs.len());
    let first = n - count;
    let mut graph = system.graph.clone();
    let rates = &system.known[first..];
    let own: Vec<Id> = system.states[first..].iter().map(|s| s.node).collect();
    let slopes: Vec<Id> = rates.iter().zip(&own).map(|(&r, &z)| graph.gradient(r, &[z])[0]).collect();
    let outputs: Vec<Id> = rates.iter().copied().chain(slopes).collect();
    let tape = Tape::compile(&graph, &system.arguments(), &outputs).ok()?;
    let columns: Vec<&Vec<f64>> =
        smooth.columns[..first].iter().map(Option::as_ref).collect::<Option<_>>()?;
    let time = &smooth.time;
    let mut hints = vec![0; m];
    Some(internal_states(&tape, (1 + first, count), time, &mut |i, scratch| {
        let t = 0.5 * (time[i] + time[i + 1]);
        scratch.input(0)[0] = t;
        columns.iter().enumerate().for_each(|(k, c)| scratch.input(1 + k)[0] = 0.5 * (c[i] + c[i + 1]));
        for (k, signal) in smooth.inputs.iter().enumerate() {
            scratch.input(1 + n + k)[0] = signal.value_and_slope(t, &mut hints[k]).0;
        }
        let numbers = system.parameters.iter().map(|p| p.start).chain(smooth.constants.iter().copied());
        numbers.enumerate().for_each(|(k, v)| scratch.input(1 + n + m + k)[0] = v);
    }))
}

impl TrialModel {
    /// Sets the last states of the system, `count` of them and the memory of a law, to where the motion of the records
    /// drives them: the segments of a fit start there.
    pub(crate) fn drive_memory(&mut self, count: usize) {
        let first = self.system.states.len() - count;
        let mut largest = vec![0.0_f64; count];
        for smooth in std::sync::Arc::make_mut(&mut self.smooth) {
            let Some(all) = driven(&self.system, smooth, count) else { continue };
            for (j, column) in all.into_iter().enumerate() {
                largest[j] = column.iter().fold(largest[j], |m, z| m.max(z.abs()));
                smooth.columns[first + j] = Some(column);
            }
        }
        for (state, size) in self.system.states[first..].iter_mut().zip(largest) {
            state.memory = (size > 0.0 && size.is_finite()).then_some(size);
        }
    }
}
