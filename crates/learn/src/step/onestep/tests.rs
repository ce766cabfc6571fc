//! The step on the graph against a Runge-Kutta step written by hand.

use super::OneStep;
use phisindy_expr::Scratch;
use phisindy_phys::{Case, Record};

#[path = "../../../tests/common/mod.rs"]
pub(crate) mod common;

/// Large, so that later stages fall into it.
pub(crate) const TOLERANCE: f64 = 0.03;

/// Rates at a time, states, inputs, parameters.
type Rates = fn(f64, &[f64], &[f64], &[f64]) -> Vec<f64>;

/// A system twice: as a spec, and as rates in plain Rust (time, states, inputs, parameters), the event
/// condition included.
pub(crate) struct Twin {
    pub(crate) case: Case,
    pub(crate) records: Vec<Record>,
    pub(crate) rates: Rates,
    /// Coefficients and movable constants of the tests; record constants come behind them.
    pub(crate) free: Vec<f64>,
}

fn sign(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}

/// One mass, an input, a movable stiffness, and two records under different loads.
pub(crate) fn one_mass(samples: [usize; 2]) -> Twin {
    let record = |samples: usize, load: f64, seed: u64| {
        format!(
            r#"Synthetic(inputs: {{"F": Formula("3*cos(1.3*t) + 0.5*sin(7*t)")}}, constants: {{"N": {load:?}}}, truth: {{"y": "-0.5*N*sgn(y)"}},
               start: {{"x": 0.1, "y": 1.0}}, duration: {:?}, step: 0.05, noise: Relative(0.05), seed: {seed})"#,
            0.05 * samples as f64
        )
    };
    let text = format!(
        r#"(constants: {{"d": 0.3, "k": (value: 2.0, within: (0.5, 8.0))}}, states: {{"x": "", "y": ""}}, inputs: {{"F": ""}},
            known: {{"x": "y", "y": "-d*y - k*x + F"}}, unknown: {{"y": (factor: "-sgn(y)", candidates: ["N", "x^2"])}},
            contacts: ["y"], data: [{}, {}])"#,
        record(samples[0], 0.8, 1),
        record(samples[1], 1.7, 2)
    );
    let (case, records) = common::load_text(&text, &[]);
    for (record, samples) in records.iter().zip(samples) {
        assert_eq!(record.len(), samples);
    }
    let rates = |_: f64, x: &[f64], u: &[f64], p: &[f64]| {
        if x[1].abs() <= TOLERANCE {
            return vec![0.0, 0.0];
        }
        vec![x[1], -0.3 * x[1] - p[2] * x[0] + u[0] - sign(x[1]) * (p[0] * p[3] + p[1] * x[0] * x[0])]
    };
    Twin { case, records, rates, free: vec![0.45, 0.2, 2.1] }
}

/// Two masses on the wall, one contact each; friction, damping, time in the rates.
fn two_masses() -> Twin {
    let text = r#"(constants: {"c": 0.1}, states: {"x1": "", "x2": "", "y1": "", "y2": ""},
        known: {"x1": "y1", "x2": "y2", "y1": "-2*c*y1 + c*y2 - 2*x1 + x2 + 2*cos(3*t)", "y2": "c*(y1-y2) + x1 - x2"},
        unknown: {"y1": (factor: "-sgn(y1)", candidates: ["1", "x2"]), "y2": (factor: "-sgn(y2)", candidates: ["1"])}, contacts: ["y1", "y2"],
        data: [Synthetic(truth: {"y1": "-0.3*sgn(y1)"}, start: {"x1": 0.0, "x2": 0.0, "y1": 0.0, "y2": 0.0}, duration: 1.0, step: 0.05, noise: None)])"#;
    let (case, records) = common::load_text(text, &[]);
    let rates = |t: f64, x: &[f64], _: &[f64], p: &[f64]| {
        let (x1, x2, y1, y2) = (x[0], x[1], x[2], x[3]);
        let mut out = vec![
            y1,
            y2,
            -0.2 * y1 + 0.1 * y2 - 2.0 * x1 + x2 + 2.0 * (3.0 * t).cos() - sign(y1) * (p[0] + p[1] * x2),
            0.1 * (y1 - y2) + x1 - x2 - sign(y2) * p[2],
        ];
        if y1.abs() <= TOLERANCE {
            (out[0], out[2]) = (0.0, 0.0);
        }
        if y2.abs() <= TOLERANCE {
            (out[1], out[3]) = (0.0, 0.0);
        }
        out
    };
    Twin { case, records, rates, free: vec![0.4, 0.1, 0.3] }
}

/// Mass 1 on top of mass 2: while they stick both keep their displacement's rate and share one acceleration.
fn stacked() -> Twin {
    let text = r#"(constants: {"m1": 1.0, "m2": 2.5}, states: {"x1": "", "x2": "", "y1": "", "y2": ""}, inputs: {"F": ""},
        known: {"x1": "y1", "x2": "y2", "y1": "(F - x1)/m1", "y2": "-4*x2/m2"}, inertia: {"y1": "m1", "y2": "m2"},
        unknown: {"y1": (factor: "-sgn(y1-y2)/m1", candidates: ["1"]), "y2": (factor: "sgn(y1-y2)/m2", candidates: ["1"])}, contacts: ["y1-y2"],
        data: [Synthetic(inputs: {"F": Formula("3*cos(2*t)")}, truth: {"y1": "-0.3*sgn(y1-y2)/m1", "y2": "0.3*sgn(y1-y2)/m2"},
            start: {"x1": 0.0, "x2": 0.0, "y1": 0.0, "y2": 0.0}, duration: 1.0, step: 0.05, noise: None)])"#;
    let (case, records) = common::load_text(text, &[]);
    let rates = |_: f64, x: &[f64], u: &[f64], p: &[f64]| {
        let (x1, x2, y1, y2) = (x[0], x[1], x[2], x[3]);
        if (y1 - y2).abs() <= TOLERANCE {
            // Friction cancels in the motion of the two as one body.
            let together = (u[0] - x1 - 4.0 * x2 + sign(y1 - y2) * (p[1] - p[0])) / 3.5;
            return vec![y1, y2, together, together];
        }
        vec![y1, y2, u[0] - x1 - sign(y1 - y2) * p[0], (-4.0 * x2 + sign(y1 - y2) * p[1]) / 2.5]
    };
    Twin { case, records, rates, free: vec![0.4, 0.4] }
}

/// The classical step by hand; `third` says from which slope stage 3 starts.
pub(crate) fn runge_kutta(
    twin: &Twin,
    (t, h): (f64, f64),
    x: &[f64],
    u: [&[f64]; 3],
    p: &[f64],
    third: usize,
) -> Vec<f64> {
    let ahead = |k: &[f64], by: f64| -> Vec<f64> { x.iter().zip(k).map(|(x, k)| x + by * k).collect() };
    let k1 = (twin.rates)(t, x, u[0], p);
    let k2 = (twin.rates)(t + h / 2.0, &ahead(&k1, h / 2.0), u[1], p);
    let k3 = (twin.rates)(t + h / 2.0, &ahead([&k1, &k2][third - 1], h / 2.0), u[1], p);
    let k4 = (twin.rates)(t + h, &ahead(&k3, h), u[2], p);
    (0..x.len()).map(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i])).collect()
}

/// Numbers in (-1, 1), the same in every run.
pub(crate) fn scatter(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

fn compare(twin: &Twin, contact: fn(&[f64]) -> f64) {
    let system = &twin.case.system;
    let all: Vec<usize> = (0..system.terms.len()).collect();
    let step = OneStep::new(system, &system.model(&all), TOLERANCE);
    let mut inputs = step.data.clone();
    inputs.extend(&step.parameters);
    let tape = step.compile(&inputs, &step.next);
    let mut scratch = Scratch::<1>::new(&tape);
    let (n, m, mut seed) = (system.states.len(), system.inputs.len(), 1u64);
    let (mut stuck, mut later, mut third) = (0, 0, 0.0_f64);
    for k in 0..4000 {
        let (t, h) = (5.0 * scatter(&mut seed), if k % 2 == 0 { 0.05 } else { -0.05 });
        // Velocities from far above the tolerance to far below.
        let size = 10f64.powi(-(k % 4));
        let mut x: Vec<f64> = (0..n).map(|_| scatter(&mut seed)).collect();
        x[n / 2..].iter_mut().for_each(|v| *v *= size);
        let u: Vec<f64> = (0..3 * m).map(|_| 2.0 * scatter(&mut seed)).collect();
        let u = [&u[..m], &u[m..2 * m], &u[2 * m..]];
        let mut p = twin.free.clone();
        p.extend(&twin.records[0].constants);
        let row = [t, h, 0.5 * h, h / 3.0, h / 6.0]
            .into_iter()
            .chain(x.iter().copied())
            .chain(u.concat())
            .chain(p.iter().copied());
        row.enumerate().for_each(|(k, v)| scratch.input(k)[0] = v);
        scratch.run();
        let by_hand = runge_kutta(twin, (t, h), &x, u, &p, 2);
        for (i, expected) in by_hand.iter().enumerate() {
            let got = scratch.output(i)[0];
            assert!((got - expected).abs() < 1e-13, "state {i} at {x:?}, h {h}: {got}, by hand {expected}");
        }
        let wrong = runge_kutta(twin, (t, h), &x, u, &p, 1);
        third = by_hand.iter().zip(&wrong).map(|(a, b)| (a - b).abs()).fold(third, f64::max);
        let first = contact(&x).abs() <= TOLERANCE;
        stuck += usize::from(first);
        let slopes = (twin.rates)(t, &x, u[0], &p);
        let middle: Vec<f64> = x.iter().zip(&slopes).map(|(x, k)| x + 0.5 * h * k).collect();
        later += usize::from(!first && contact(&middle).abs() <= TOLERANCE);
    }
    // The comparison sees what it is meant to see.
    assert!(
        stuck > 100 && later > 30 && third > 1e-4,
        "stuck {stuck}, in a later stage {later}, stage 3 {third}"
    );
}

#[test]
fn one_mass_with_an_input() {
    compare(&one_mass([20, 20]), |x| x[1]);
}

#[test]
fn two_masses_with_a_contact_each() {
    compare(&two_masses(), |x| x[3]);
}

#[test]
fn a_mass_on_a_mass() {
    compare(&stacked(), |x| x[2] - x[3]);
}
