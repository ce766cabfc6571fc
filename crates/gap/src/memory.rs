//! The internal states of laws, driven by a motion.

use crate::decisions::HALVINGS;
use crate::model::TrialModel;
use phisindy_expr::{Id, Scratch, Tape};
use phisindy_phys::{Record, System};

/// Internal states along a motion by exponential Euler steps, exact where a rate is linear in its state. A
/// step ends where the rate vanishes, if that lies on its way: with the motion held, no solution crosses such
/// a point.
///
/// The tape gives their rates, then the derivative of each by its own state. They are its inputs `states.0`
/// and the next ones, `states.1` of them; `motion` sets the others for the step that begins at a sample. Each
/// of the `N` lanes is a run with numbers of its own. Returns samples by lane and state.
pub(crate) fn internal_states<const N: usize>(
    tape: &Tape,
    states: (usize, usize),
    time: &[f64],
    motion: &mut dyn FnMut(usize, &mut Scratch<N>),
) -> Vec<Vec<Vec<f64>>> {
    let (first, count) = states;
    let mut scratch = Scratch::<N>::new(tape);
    let mut all = vec![vec![vec![0.0; time.len()]; count]; N];
    let (mut now, mut end) = (vec![[0.0; N]; count], vec![[0.0; N]; count]);
    let mut at = vec![([0.0; N], [0.0; N]); count];
    for i in 0..time.len().saturating_sub(1) {
        motion(i, &mut scratch);
        now.iter().enumerate().for_each(|(j, z)| *scratch.input(first + j) = *z);
        scratch.run();
        at.iter_mut().enumerate().for_each(|(j, at)| *at = (*scratch.output(j), *scratch.output(count + j)));
        let h = time[i + 1] - time[i];
        for j in 0..count {
            // A state that another one drives goes with where that one has come to: a body on a spring keeps its energy
            // then (symplectic Euler: Hairer, Lubich, Wanner 2006, doi 10.1007/3-540-30666-8).
            if j > 0 {
                *scratch.input(first + j - 1) = end[j - 1];
                scratch.run();
                at[j] = (*scratch.output(j), *scratch.output(count + j));
            }
            let (rate, slope) = &at[j];
            let next = std::array::from_fn(|lane| {
                let decay = slope[lane] * h;
                let factor = if decay.abs() < 1e-8 { h } else { decay.exp_m1() / slope[lane] };
                let next = now[j][lane] + rate[lane] * factor;
                if next.is_finite() { next } else { 0.0 }
            });
            end[j] = before_rest(&mut scratch, (first + j, j), (&now[j], next), rate);
            *scratch.input(first + j) = now[j];
        }
        std::mem::swap(&mut now, &mut end);
        for (lane, all) in all.iter_mut().enumerate() {
            all.iter_mut().zip(&now).for_each(|(column, z)| column[i + 1] = z[lane]);
        }
    }
    all
}

/// The end of a step of an internal state from `now` to `next`, or the place between them where its rate
/// vanishes, by lanes. The state is input `at.0` of the tape, its rate output `at.1`.
fn before_rest<const N: usize>(
    scratch: &mut Scratch<N>,
    at: (usize, usize),
    (now, next): (&[f64; N], [f64; N]),
    rate: &[f64; N],
) -> [f64; N] {
    if rate.iter().all(|rate| *rate == 0.0) {
        return next;
    }
    let mut rates_at = |z: &[f64; N]| {
        *scratch.input(at.0) = *z;
        scratch.run();
        *scratch.output(at.1)
    };
    let there = rates_at(&next);
    let goes_on = |there: &[f64; N], lane: usize| there[lane] * rate[lane] >= 0.0;
    let crosses: [bool; N] = std::array::from_fn(|lane| rate[lane] != 0.0 && !goes_on(&there, lane));
    let lanes = || (0..N).filter(|&lane| crosses[lane]);
    let (mut inside, mut outside) = (*now, next);
    for _ in 0..HALVINGS {
        let middle: [f64; N] = std::array::from_fn(|lane| 0.5 * (inside[lane] + outside[lane]));
        // Between neighbouring numbers there is nothing more to find.
        if lanes().all(|lane| middle[lane] == inside[lane] || middle[lane] == outside[lane]) {
            break;
        }
        let there = rates_at(&middle);
        for lane in lanes() {
            let end = if goes_on(&there, lane) { &mut inside } else { &mut outside };
            end[lane] = middle[lane];
        }
    }
    std::array::from_fn(|lane| if crosses[lane] { inside[lane] } else { next[lane] })
}

/// The last states of a system, `count` of them, along the smoothed motion of a record, with the model's
/// numbers as they start. `None` where the motion is not known, or their rates cannot be evaluated.
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
    let mut runs = internal_states::<1>(&tape, (1 + first, count), time, &mut |i, scratch| {
        let t = 0.5 * (time[i] + time[i + 1]);
        scratch.input(0)[0] = t;
        columns.iter().enumerate().for_each(|(k, c)| scratch.input(1 + k)[0] = 0.5 * (c[i] + c[i + 1]));
        for (k, signal) in smooth.inputs.iter().enumerate() {
            scratch.input(1 + n + k)[0] = signal.value_and_slope(t, &mut hints[k]).0;
        }
        let numbers = system.parameters.iter().map(|p| p.start).chain(smooth.constants.iter().copied());
        numbers.enumerate().for_each(|(k, v)| scratch.input(1 + n + m + k)[0] = v);
    });
    runs.pop()
}

impl TrialModel {
    /// Sets the last states of the system, `count` of them and the memory of a law, to where the motion of
    /// the records drives them: the segments of a fit start there.
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

#[cfg(test)]
mod tests {
    use super::*;
    use phisindy_expr::{Graph, Names, parse};

    /// Each lane runs as it would alone, bit by bit, and ends where its rate vanishes: an elastic contact
    /// that slides at the deflection 1/k.
    #[test]
    fn lanes_do_not_know_of_each_other() {
        let (mut graph, mut names) = (Graph::default(), Names::default());
        let text = parse("v*(1 - (pos(z*sgn(v))*k)^20)").unwrap();
        let rate = graph.lower(&text, |name| Some(names.intern(name))).unwrap();
        let inputs = ["v", "k", "z"].map(|name| graph.symbol(names.get(name).unwrap()));
        let slope = graph.gradient(rate, &inputs[2..])[0];
        let tape = Tape::compile(&graph, &inputs, &[rate, slope]).unwrap();
        let time: Vec<f64> = (0..400).map(|i| 0.02 * f64::from(i)).collect();
        let speed = |i: usize| (0.02 * i as f64).cos();
        let k = |lane: usize| 0.5 + 4.0 * lane as f64;
        let all = internal_states::<4>(&tape, (2, 1), &time, &mut |i, scratch| {
            *scratch.input(0) = [speed(i); 4];
            *scratch.input(1) = std::array::from_fn(k);
        });
        for (lane, own) in all.iter().enumerate() {
            let alone = internal_states::<1>(&tape, (2, 1), &time, &mut |i, scratch| {
                (scratch.input(0)[0], scratch.input(1)[0]) = (speed(i), k(lane));
            });
            assert_eq!(own[0], alone[0][0], "{lane}");
            let most = own[0].iter().fold(0.0_f64, |most, z| most.max(z.abs()));
            // The first lane never slides.
            let due = (1.0 / k(lane)).min(1.0);
            assert!((most / due - 1.0).abs() < 0.02, "{lane} {most} {due}");
        }
    }
}
