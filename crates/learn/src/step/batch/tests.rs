//! The loss over all samples against a plain loop, its derivatives against differences and against a tape
//! that is unrolled.

use super::{Batch, lay_out};
use crate::step::onestep::tests::{TOLERANCE, Twin, common, one_mass, runge_kutta};
use crate::step::onestep::{FIRST_STATE, OneStep};
use crate::step::options::StepOptions;
use crate::step::windows::{deviations, step_row};
use phisindy_expr::{Graph, Id, Names, Scratch};
use phisindy_phys::Record;
use phisindy_phys::spec::{Crossings, Optimiser};
use std::collections::HashMap;

fn options(horizon: usize, crossings: Crossings) -> StepOptions {
    StepOptions { tolerance: TOLERANCE, horizon, crossings, ..Default::default() }
}

fn one_step(twin: &Twin) -> OneStep {
    let system = &twin.case.system;
    let all: Vec<usize> = (0..system.terms.len()).collect();
    OneStep::new(system, &system.model(&all), TOLERANCE)
}

fn batch(twin: &Twin, horizon: usize) -> Batch {
    let records: Vec<&Record> = twin.records.iter().collect();
    let scale = deviations(&twin.case.system, &records);
    Batch::new(&one_step(twin), twin.free.len(), &records, &scale, &options(horizon, Crossings::Keep))
}

/// Samples of the states and inputs, read without the code under test.
fn state(record: &Record, k: usize) -> Vec<f64> {
    record.columns.iter().map(|c| c.as_ref().unwrap()[k]).collect()
}

/// Windows as pairs of sample and direction.
fn windows(record: &Record, horizon: usize) -> Vec<(usize, bool)> {
    (0..record.len() - horizon).flat_map(|s| [(s, false), (s + horizon, true)]).collect()
}

fn after(k: usize, steps: usize, backward: bool) -> usize {
    if backward { k - steps } else { k + steps }
}

/// Every residual, scaled so that the loss is the sum of squares; steps by hand.
fn residuals(
    twin: &Twin,
    free: &[f64],
    horizon: usize,
    used: impl Fn(&Record, usize, bool) -> bool,
) -> Vec<f64> {
    let n = twin.case.system.states.len();
    let mean_square = |k: usize| {
        let all: Vec<f64> = twin.records.iter().flat_map(|r| r.columns[k].clone().unwrap()).collect();
        let mean = all.iter().sum::<f64>() / all.len() as f64;
        all.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / all.len() as f64
    };
    let scale: Vec<f64> = (0..n).map(|k| mean_square(k).sqrt()).collect();
    let (mut out, mut count) = (Vec::new(), 0);
    for record in &twin.records {
        let p: Vec<f64> = free.iter().chain(&record.constants).copied().collect();
        let input = |t: f64| -> Vec<f64> { record.inputs.iter().map(|u| u.value(t)).collect() };
        for (start, backward) in windows(record, horizon) {
            if !used(record, start, backward) {
                continue;
            }
            count += usize::from(!backward);
            let mut x = state(record, start);
            for k in 0..horizon {
                let (from, to) = (after(start, k, backward), after(start, k + 1, backward));
                let (t, h) = (record.time[from], record.time[to] - record.time[from]);
                let u = [input(t), input(t + 0.5 * h), input(record.time[to])];
                x = runge_kutta(twin, (t, h), &x, [&u[0], &u[1], &u[2]], &p, 2);
                out.extend(x.iter().zip(state(record, to)).zip(&scale).map(|((x, y), s)| (x - y) / s));
            }
        }
    }
    let weight = 1.0 / ((n * horizon * count) as f64).sqrt();
    out.iter().map(|e| weight * e).collect()
}

fn square(e: &[f64]) -> f64 {
    e.iter().map(|e| e * e).sum()
}

/// Derivatives of the residuals by central differences, one vector for each parameter.
fn differences(twin: &Twin, horizon: usize) -> Vec<Vec<f64>> {
    let all = |_: &Record, _: usize, _: bool| true;
    (0..twin.free.len())
        .map(|k| {
            let h = 1e-6;
            let at = |by: f64| {
                let mut p = twin.free.clone();
                p[k] += by;
                residuals(twin, &p, horizon, all)
            };
            at(h).iter().zip(at(-h)).map(|(a, b)| (a - b) / (2.0 * h)).collect()
        })
        .collect()
}

fn close(a: f64, b: f64, tolerance: f64, what: &str) {
    assert!((a - b).abs() <= tolerance * (a.abs() + b.abs()).max(1e-12), "{what}: {a} against {b}");
}

/// Loss, gradient and normal equations of one horizon against the plain loop.
fn agrees_with_a_plain_loop(samples: [usize; 2], horizon: usize) {
    let twin = one_mass(samples);
    let batch = batch(&twin, horizon);
    let e = residuals(&twin, &twin.free, horizon, |_, _, _| true);
    assert_eq!(batch.residuals, e.len(), "{samples:?}");
    let p = twin.free.len();
    let mut gradient = vec![0.0; p];
    let loss = batch.loss(&twin.free, &mut gradient);
    close(loss, square(&e), 1e-12, "loss");
    let columns = differences(&twin, horizon);
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let (cost, triangle, right) = batch.normal(&twin.free);
    close(cost, square(&e), 1e-12, "cost");
    let mut at = 0;
    for i in 0..p {
        close(gradient[i], 2.0 * dot(&columns[i], &e), 1e-6, "gradient");
        close(right[i], dot(&columns[i], &e), 1e-6, "J^T e");
        for j in i..p {
            close(triangle[at], dot(&columns[i], &columns[j]), 1e-6, "J^T J");
            at += 1;
        }
    }
    assert_eq!(at, triangle.len());
}

/// Blocks of 64 lanes: one short, full, one over, two and one over; two records with loads of their own.
#[test]
fn one_step_whatever_the_length_of_the_last_block() {
    for samples in [[63, 30], [64, 33], [65, 64], [129, 11]] {
        agrees_with_a_plain_loop(samples, 1);
    }
}

#[test]
fn three_steps_whatever_the_length_of_the_last_block() {
    for samples in [[63, 30], [64, 35], [65, 67], [129, 11]] {
        agrees_with_a_plain_loop(samples, 3);
    }
}

/// Three steps put into one another in one graph, differentiated as a whole.
#[test]
fn the_adjoint_is_that_of_an_unrolled_tape() {
    let twin = one_mass([70, 23]);
    let batch = batch(&twin, 3);
    let p = twin.free.len();
    let mut gradient = vec![0.0; p];
    let loss = batch.loss(&twin.free, &mut gradient);

    let step = one_step(&twin);
    let n = step.states.len();
    let (mut graph, mut names): (Graph, Names) = (step.graph.clone(), step.names.clone());
    let mut fresh = |graph: &mut Graph, name: String| {
        let symbol = names.intern(&name);
        graph.symbol(symbol)
    };
    let records: Vec<&Record> = twin.records.iter().collect();
    let scale = deviations(&twin.case.system, &records);
    let (mut data, mut targets) = (step.data.clone(), Vec::new());
    let (mut now, mut total) = (step.states.clone(), graph.constant(0.0));
    for k in 0..3 {
        let mut with: HashMap<Id, Id> = HashMap::new();
        for (i, &d) in step.data.iter().enumerate() {
            let state = (FIRST_STATE..FIRST_STATE + n).contains(&i);
            if state {
                with.insert(d, now[i - FIRST_STATE]);
            } else if k > 0 {
                let symbol = fresh(&mut graph, format!("unrolled {k} {i}"));
                with.insert(d, symbol);
                data.push(symbol);
            }
        }
        now = graph.replace(&step.next, &with);
        for i in 0..n {
            let target = fresh(&mut graph, format!("unrolled target {k} {i}"));
            targets.push(target);
            let miss = graph.sub(now[i], target);
            let unit = graph.constant(1.0 / scale[i]);
            let miss = graph.mul(miss, unit);
            let miss = graph.mul(miss, miss);
            total = graph.add(total, miss);
        }
    }
    let mut outputs = vec![total];
    outputs.extend(graph.gradient(total, &step.parameters[..p]));
    let whole = OneStep { graph, names, ..step.clone() };
    let mut inputs = data;
    inputs.extend(&step.parameters);
    inputs.extend(&targets);
    let tape = whole.compile(&inputs, &outputs);
    let mut scratch = Scratch::<1>::new(&tape);
    let mut sums = vec![0.0; 1 + p];
    let mut count = 0;
    for record in &twin.records {
        for (start, backward) in windows(record, 3) {
            count += 1;
            let at: Vec<usize> = (0..4).map(|k| after(start, k, backward)).collect();
            let mut row = step_row(record, at[0], at[1], None);
            for k in 1..3 {
                let rest = step_row(record, at[k], at[k + 1], None);
                row.extend(
                    rest.iter()
                        .enumerate()
                        .filter(|(i, _)| !(FIRST_STATE..FIRST_STATE + n).contains(i))
                        .map(|(_, v)| v),
                );
            }
            row.extend(twin.free.iter().chain(&record.constants));
            (1..4).for_each(|k| row.extend(state(record, at[k])));
            row.iter().enumerate().for_each(|(k, v)| scratch.input(k)[0] = *v);
            scratch.run();
            sums.iter_mut().enumerate().for_each(|(k, s)| *s += scratch.output(k)[0]);
        }
    }
    // Windows forward and backward are each a mean over states, steps and windows.
    let mean = (n * 3 * count / 2) as f64;
    close(loss, sums[0] / mean, 1e-12, "loss");
    for k in 0..p {
        close(gradient[k], sums[1 + k] / mean, 1e-11, "gradient");
    }
}

/// Windows in which the contact turns are left out, and only those, whatever the horizon.
#[test]
fn skipping_leaves_out_the_steps_across_a_turn() {
    let twin = one_mass([129, 64]);
    let records: Vec<&Record> = twin.records.iter().collect();
    let scale = deviations(&twin.case.system, &records);
    for horizon in [1, 3] {
        let straight = |record: &Record, start: usize, backward: bool| {
            let y: Vec<f64> = (0..=horizon).map(|k| state(record, after(start, k, backward))[1]).collect();
            y.windows(2).all(|w| w[0] * w[1] >= 0.0)
        };
        let every = residuals(&twin, &twin.free, horizon, |_, _, _| true).len();
        let e = residuals(&twin, &twin.free, horizon, straight);
        assert!(e.len() < every);
        let batch = Batch::new(
            &one_step(&twin),
            twin.free.len(),
            &records,
            &scale,
            &options(horizon, Crossings::Skip),
        );
        assert_eq!(batch.residuals, e.len());
        let loss = batch.loss(&twin.free, &mut [0.0; 3]);
        close(loss, square(&e), 1e-12, "loss");
    }
}

/// The velocity of a belt is a constant that moves, or one of the record: turns are those of the contact, not
/// of the mass.
#[test]
fn turns_are_seen_on_a_belt() {
    for (constants, own) in [
        (r#""vb": (value: 0.3, within: (0.1, 0.5))"#, ""),
        (r#""vb": 9.0"#, r#"constants: {"vb": 0.3},"#),
        (r#""vb": 0.3"#, ""),
    ] {
        let text = format!(
            r#"(constants: {{{constants}}}, states: {{"x": "", "v": ""}}, known: {{"x": "v", "v": "-x + 1.5*cos(0.7*t)"}},
                unknown: {{"v": (factor: "-sgn(v-vb)", candidates: ["1"])}}, contacts: ["v-vb"],
                data: [Synthetic({own} truth: {{"v": "-0.3*sgn(v-vb)"}}, start: {{"x": 0.0, "v": 0.0}}, duration: 20.0, step: 0.05, noise: Relative(0.02))])"#
        );
        let (case, records) = common::load_text(&text, &[]);
        let records: Vec<&Record> = records.iter().collect();
        let velocity = records[0].columns[1].as_ref().unwrap();
        let turns = velocity.windows(2).filter(|w| (w[0] - 0.3) * (w[1] - 0.3) < 0.0).count();
        assert!(turns > 3);
        for optimiser in [Optimiser::GaussNewton, Optimiser::RAdam] {
            let options = StepOptions { crossings: Crossings::Skip, optimiser, ..Default::default() };
            let start: Vec<f64> = case.system.parameters.iter().map(|p| p.start).collect();
            let batch = lay_out(&case.system, &records, &options, &[0], &start);
            // Two states, two directions.
            assert_eq!(batch.residuals, 4 * (velocity.len() - 1 - turns), "{constants}");
        }
    }
}
