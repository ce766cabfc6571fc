//! Held values against simulations from sample to sample, and differences of runs.

use ode_solvers::{Dopri5, OVector, System, Vector3};
use phisindy_phys::Model;
use phisindy_sim::{Automaton, Drive, Options, Trajectory, simulate};

/// A mass on a spring that a sampled PID controls: period 10 ms, saturation, computation delay 2 ms. The third state is
/// the sum of the errors; the speed is the difference of two samples.
fn loop_of(delay: &str) -> Model {
    let e = "(0.1*sin(3*t) - x)";
    let difference = "(x - hold(x, 0.01))/0.01";
    let push = format!("min(max(kp*{e} + ki*i - kd*{difference}, -1.5), 1.5)");
    let rate = format!("hold({push}, 0.01{delay}) - 20*x - 0.4*v");
    let i = format!("hold({e}, 0.01)");
    let model = Model::build(&["x", "v", "i"], &[], &["kp", "ki", "kd"], &["v", &rate, &i]).expect("a model");
    model.reading(&format!("hold({push}, 0.01{delay})")).expect("an output")
}

const GAINS: [f64; 3] = [60.0, 80.0, 1.5];
const START: [f64; 3] = [0.02, 0.1, 0.0];

fn run(
    model: &Model,
    gains: &[f64],
    start: &[f64],
    (origin, samples): (f64, usize),
    sensitivities: bool,
) -> Trajectory {
    let automaton = Automaton::new(model).expect("an automaton");
    let times: Vec<f64> = (0..=samples).map(|k| origin + 0.002 * k as f64).collect();
    let options = Options {
        tolerance: 1e-11,
        scale: vec![0.1, 0.3, 0.1],
        sensitivities: sensitivities.then(|| vec![0, 1, 2]),
        ..Options::default()
    };
    simulate(&automaton, &Drive { inputs: &[], parameters: gains }, origin, start, &times, &options)
        .expect("a run")
}

/// The plant between two instants at which something jumps.
struct Plant {
    push: f64,
    error: f64,
}

impl System<f64, Vector3<f64>> for Plant {
    fn system(&self, _: f64, x: &Vector3<f64>, dx: &mut Vector3<f64>) {
        *dx = OVector::from([x[1], self.push - 20.0 * x[0] - 0.4 * x[1], self.error]);
    }
}

/// The loop from sample to sample.
fn independent(delay: f64, duration: f64) -> (Vec<Vec<f64>>, Vec<f64>) {
    let [kp, ki, kd] = GAINS;
    let (mut x, mut last) = (Vector3::from(START), START[0]);
    let advance = |x: Vector3<f64>, h: f64, push: f64, error: f64| {
        if h == 0.0 {
            return x;
        }
        let mut stepper = Dopri5::new(Plant { push, error }, 0.0, h, h, x, 1e-13, 1e-13);
        stepper.integrate().expect("a step");
        *stepper.y_out().last().expect("an end")
    };
    let mut push = 0.0;
    let (mut states, mut pushes) = (vec![], vec![]);
    for k in 0..(duration / 0.01).round() as usize {
        let error = 0.1 * (3.0 * 0.01 * k as f64).sin() - x[0];
        let new = (kp * error + ki * x[2] - kd * (x[0] - last) / 0.01).clamp(-1.5, 1.5);
        last = x[0];
        if k == 0 {
            push = new;
        }
        // Samples every 2 ms.
        for part in 0..5 {
            let late = 0.002 * f64::from(part) >= delay - 1e-12;
            states.push(vec![x[0], x[1], x[2]]);
            if late {
                push = new;
            }
            pushes.push(push);
            x = advance(x, 0.002, push, error);
        }
    }
    (states, pushes)
}

#[test]
fn a_sampled_controller_is_that_of_a_simulation_from_sample_to_sample() {
    for (text, delay) in [("", 0.0), (", 0.002", 0.002)] {
        let (states, pushes) = independent(delay, 2.0);
        let run = run(&loop_of(text), &GAINS, &START, (0.0, 999), false);
        assert_eq!((run.n, run.samples()), (4, states.len()));
        let saturated = pushes.iter().filter(|u| u.abs() == 1.5).count();
        assert!((10..900).contains(&saturated), "{saturated}");
        for (i, (x, u)) in states.iter().zip(&pushes).enumerate() {
            for (k, due) in x.iter().enumerate() {
                let own = run.states[4 * i + k];
                assert!((own - due).abs() < 1e-9, "delay {delay}, sample {i}, {k}: {own} not {due}");
            }
            let own = run.states[4 * i + 3];
            assert!((own - u).abs() < 1e-6, "delay {delay}, sample {i}: {own} not {u}");
        }
    }
}

/// The times are those of the record, wherever the run begins.
#[test]
fn a_run_that_begins_between_two_samples_keeps_their_times() {
    let model = Model::build(&["x", "y", "z"], &[], &["a", "b", "c"], &["1", "hold(x, 0.01)", "0"]).unwrap();
    let origin = 1e6 + 0.004;
    let run = run(&model, &GAINS, &[1.0, 0.0, 0.0], (origin, 10), false);
    // Up to 0.01 the value at the start, then those at 0.01 and 0.02.
    for (i, due) in [(0, 0.0), (3, 0.006), (5, 0.006 + 0.004 * 1.006), (8, 0.006 + 0.01 * 1.006)] {
        let own = run.states[3 * i + 1];
        assert!((own - due).abs() < 1e-8, "{i}: {own} not {due}");
    }
}

#[test]
fn derivatives_go_through_what_is_held() {
    let model = loop_of(", 0.002");
    let with = run(&model, &GAINS, &START, (0.0, 500), true);
    assert_eq!(run(&model, &GAINS, &START, (0.0, 500), false).states, with.states);
    let eps = 1e-6;
    let mut largest = 0.0_f64;
    for j in 0..6 {
        let moved = |by: f64| {
            let (mut gains, mut start) = (GAINS, START);
            if j < 3 {
                start[j] += by
            } else {
                gains[j - 3] += by
            }
            run(&model, &gains, &start, (0.0, 500), false)
        };
        let (up, down) = (moved(eps), moved(-eps));
        for at in 0..with.states.len() {
            let due = (up.states[at] - down.states[at]) / (2.0 * eps);
            let own = with.sensitivities[at * with.m + j];
            assert!((own - due).abs() < 2e-5 * due.abs().max(0.1), "{at} by {j}: {own} not {due}");
            largest = largest.max(if j >= 3 { due.abs() } else { 0.0 });
        }
    }
    assert!(largest > 1e-3, "{largest}");
}
