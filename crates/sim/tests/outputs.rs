//! Outputs of a run against the equations they read, and their derivatives against differences of runs.

use phisindy_phys::Model;
use phisindy_signal::{Interpolation, Signal};
use phisindy_sim::{Automaton, Drive, Options, Trajectory, simulate};

/// A block on a spring with friction, pushed by an input; an accelerometer, and a force cell at the floor.
fn rig() -> Model {
    let rate = "(u - k*x - c*v - F*sgn(v))/m";
    let model = Model::build(&["x", "v"], &["u"], &["m", "k", "c", "F"], &["v", rate]).expect("a model");
    model.reading(rate).and_then(|m| m.reading("c*v + F*sgn(v)")).expect("outputs")
}

fn run(parameters: &[f64], start: &[f64], sensitivities: bool) -> Trajectory {
    let automaton = Automaton::new(&rig()).expect("an automaton");
    let time: Vec<f64> = (0..=400).map(|k| 0.01 * f64::from(k)).collect();
    let push = time.iter().map(|t| 3.0 * (2.0 * t).sin() + 1.5 * (5.0 * t).sin()).collect();
    let input = Signal::new(time.clone().into(), push, Interpolation::Cubic).expect("a signal");
    let options = Options {
        tolerance: 1e-11,
        sensitivities: sensitivities.then(|| vec![0, 1, 2, 3]),
        ..Options::default()
    };
    let drive = Drive { inputs: &[input], parameters };
    simulate(&automaton, &drive, 0.0, start, &time, &options).expect("a run")
}

const PARAMETERS: [f64; 4] = [1.2, 30.0, 0.4, 1.1];
const START: [f64; 2] = [0.05, 0.4];

#[test]
fn outputs_are_what_the_equations_say_while_a_contact_sticks_too() {
    let run = run(&PARAMETERS, &START, false);
    assert_eq!((run.n, run.outputs), (4, 2));
    let [m, k, c, f] = PARAMETERS;
    let mut stuck = 0;
    for i in 0..run.samples() {
        let t = 0.01 * i as f64;
        let u = 3.0 * (2.0 * t).sin() + 1.5 * (5.0 * t).sin();
        let (x, v, a, force) =
            (run.states[4 * i], run.states[4 * i + 1], run.states[4 * i + 2], run.states[4 * i + 3]);
        match run.modes[i] {
            // The floor holds what the others push with.
            0 => {
                stuck += 1;
                assert!(a.abs() < 1e-9 && (force - (u - k * x)).abs() < 1e-6, "{t}: {a} {force}");
            }
            s => {
                let friction = c * v + f * f64::from(s);
                assert!((force - friction).abs() < 1e-9, "{t}: {force}");
                assert!((a - (u - k * x - friction) / m).abs() < 1e-6, "{t}: {a}");
            }
        }
    }
    assert!(stuck > 10, "{stuck}");
    // Every reversal is a jump of the force by twice the friction, or less where it sticks.
    assert!(
        !run.jumps.is_empty() && run.jumps.iter().all(|j| j.by[3].abs() < 2.0 * f + 1e-9),
        "{:?}",
        run.jumps
    );
}

#[test]
fn derivatives_of_outputs_and_of_their_jumps_are_those_of_runs() {
    let with = run(&PARAMETERS, &START, true);
    let eps = 1e-6;
    for j in 0..6 {
        let moved = |by: f64| {
            let (mut p, mut x) = (PARAMETERS, START);
            match j {
                0 | 1 => x[j] += by,
                _ => p[j - 2] += by,
            }
            run(&p, &x, false)
        };
        let (up, down) = (moved(eps), moved(-eps));
        let modes = |i: usize| [&up, &down, &with].map(|r| r.modes[i]);
        for i in 0..with.samples() {
            // A sample that the event passes has no derivative.
            if modes(i).iter().any(|m| *m != with.modes[i]) {
                continue;
            }
            for k in 2..4 {
                let at = i * with.n + k;
                let due = (up.states[at] - down.states[at]) / (2.0 * eps);
                let own = with.sensitivities[at * with.m + j];
                assert!((own - due).abs() < 2e-4 * due.abs().max(1.0), "{i} {k} {j}: {own} not {due}");
            }
        }
        for (n, jump) in with.jumps.iter().enumerate() {
            let due = (up.jumps[n].time - down.jumps[n].time) / (2.0 * eps);
            assert!(
                (jump.moves[j] - due).abs() < 1e-4 * due.abs().max(1.0),
                "{n} {j}: {} not {due}",
                jump.moves[j]
            );
        }
    }
}

#[test]
fn rates_of_outputs_are_their_slopes() {
    let run = run(&PARAMETERS, &START, false);
    let mut compared = 0;
    for i in 1..run.samples() - 1 {
        if (i - 1..=i + 1).any(|j| run.modes[j] != run.modes[i]) {
            continue;
        }
        for k in 2..4 {
            let slope = (run.states[(i + 1) * 4 + k] - run.states[(i - 1) * 4 + k]) / 0.02;
            let own = run.rates[i * 4 + k];
            assert!((own - slope).abs() < 0.02 * slope.abs().max(1.0), "{i} {k}: {own} not {slope}");
            compared += 1;
        }
    }
    assert!(compared > 500, "{compared}");
}
