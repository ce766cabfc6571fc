//! The stick-slip cycle of case 1a, `m x'' + c x' + k x + mu sgn(x') = F cos(W t)`, with diffsol (Tsitouras' pair, the root finding that it has, the modes by hand)
//! and with phisindy-sim, which needs no more than the text of the model. `bench/stick_slip.py` runs this and says what it means.
//!
//! ```text
//! cargo run --release -- reference           # 5000 displacements and velocities at the tightest tolerance
//! cargo run --release -- phisindy 1e-8       # steps and microseconds on the first line, then the same
//! cargo run --release -- diffsol 1e-8
//! ```

use diffsol::{
    NalgebraContext, NalgebraMat, NalgebraVec, OdeBuilder, OdeEquations, OdeSolverMethod, OdeSolverProblem,
    OdeSolverStopReason, Vector,
};
use phisindy_phys::Model;
use phisindy_sim::{Automaton, Drive, Options, simulate};
use std::time::Instant;

/// Mass, damping, stiffness, force, its frequency, friction.
const PARAMETERS: [f64; 6] = [1.0, 0.1, 1.0, 1.0, 0.3, 0.5];
const START: [f64; 2] = [0.1, 0.1];
const END: f64 = 50.0;
const SAMPLES: u32 = 5000;
/// The shortest of so many runs counts.
const RUNS: usize = 200;
/// Where nothing is left to gain from a smaller one.
const TIGHTEST: f64 = 1e-13;

/// Displacement and velocity at every sample, and the number of steps.
struct Run {
    states: Vec<[f64; 2]>,
    steps: usize,
}

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let tolerance = || args[1].parse().expect("a tolerance");
    let run: Box<dyn Fn() -> Run> = match args.first().map(String::as_str) {
        Some("reference") => Box::new(with_phisindy(TIGHTEST)),
        Some("phisindy") => Box::new(with_phisindy(tolerance())),
        Some("diffsol") => Box::new(with_diffsol(tolerance())),
        _ => panic!("reference, or phisindy or diffsol and a tolerance"),
    };
    let mut best = f64::INFINITY;
    for _ in 0..RUNS {
        let begin = Instant::now();
        std::hint::black_box(run());
        best = best.min(begin.elapsed().as_secs_f64());
    }
    let Run { states, steps } = run();
    println!("{steps} {}", 1e6 * best);
    states.iter().for_each(|[x, y]| println!("{x:e} {y:e}"));
}

fn times() -> Vec<f64> {
    (0..SAMPLES).map(|k| END / f64::from(SAMPLES) * f64::from(k)).collect()
}

fn with_phisindy(tolerance: f64) -> impl Fn() -> Run {
    let names = ["m", "c", "k", "F", "W", "mu"];
    let rates = ["y", "(-c*y - k*x + F*cos(W*t) - mu*sgn(y))/m"];
    let model = Model::build(&["x", "y"], &[], &names, &rates).expect("two rates");
    let automaton = Automaton::new(&model).expect("every name has a value");
    let (times, options) = (times(), Options { tolerance, ..Options::default() });
    move || {
        let drive = Drive { inputs: &[], parameters: &PARAMETERS };
        let run = simulate(&automaton, &drive, 0.0, &START, &times, &options).expect("a run");
        Run { states: run.states.as_chunks().0.to_vec(), steps: run.steps }
    }
}

/// The equations of every mode. Parameters are those of the model, then the direction (0 for sticking) and the state that a mode starts from.
fn equations(
    tolerance: f64,
) -> OdeSolverProblem<
    impl OdeEquations<M = NalgebraMat<f64>, V = NalgebraVec<f64>, T = f64, C = NalgebraContext>,
> {
    OdeBuilder::<NalgebraMat<f64>>::new()
        .p(PARAMETERS.into_iter().chain([1.0]).chain(START))
        .rtol(tolerance)
        .atol([tolerance, tolerance])
        .rhs(|x: &[f64], p: &[f64], t: f64, rate: &mut [f64]| {
            rate[0] = x[1];
            rate[1] = if p[6] == 0.0 { 0.0 } else { (load(x[0], p, t) - p[1] * x[1] - p[5] * p[6]) / p[0] };
        })
        .init(|p: &[f64], _: f64, x: &mut [f64]| x.copy_from_slice(&p[7..9]), 2)
        // A mass that slips may stop; one that sticks is held while the load is less than the friction.
        .root(
            |x: &[f64], p: &[f64], t: f64, root: &mut [f64]| {
                root[0] = if p[6] == 0.0 { p[5] - load(x[0], p, t).abs() } else { x[1] };
            },
            1,
        )
        .build()
        .expect("a problem")
}

/// What pulls at a mass that stands still.
fn load(x: f64, p: &[f64], t: f64) -> f64 {
    p[3] * (p[4] * t).cos() - p[2] * x
}

fn with_diffsol(tolerance: f64) -> impl Fn() -> Run {
    let times = times();
    move || {
        let mut problem = equations(tolerance);
        let mut run = Run { states: Vec::with_capacity(times.len()), steps: 0 };
        let (mut direction, mut x) = (1.0, START);
        loop {
            let parameters: Vec<f64> = PARAMETERS.into_iter().chain([direction]).chain(x).collect();
            problem.eqn.set_params(&NalgebraVec::from_vec(parameters, NalgebraContext::default()));
            let mut solver = problem.tsit45().expect("a solver");
            let event = loop {
                let reason = solver.step().expect("a step");
                run.steps += 1;
                let end = if let OdeSolverStopReason::RootFound(root, _) = reason {
                    root
                } else {
                    solver.state().t
                };
                while run.states.len() < times.len() && times[run.states.len()] <= end {
                    let y = solver.interpolate(times[run.states.len()]).expect("a time within the step");
                    run.states.push([y[0], y[1]]);
                }
                if run.states.len() == times.len() {
                    return run;
                }
                if let OdeSolverStopReason::RootFound(root, _) = reason {
                    break root;
                }
            };
            x = [solver.interpolate(event).expect("a time within the step")[0], 0.0];
            let pull = load(x[0], &PARAMETERS, event);
            direction = if direction != 0.0 && pull.abs() <= PARAMETERS[5] { 0.0 } else { pull.signum() };
            drop(solver);
            problem.t0 = event;
        }
    }
}
