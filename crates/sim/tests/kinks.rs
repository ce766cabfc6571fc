//! Kinks of the rates: against closed forms, against another solver, and what they cost.

#![allow(clippy::print_stderr, clippy::needless_range_loop)]

use crate::common::{Case, grid};
use approx::assert_abs_diff_eq;
use ode_solvers::{DVector, Dop853, OutputType, System};

/// A mass flies at 1 m/s into a spring at x = 0, is thrown back, and flies away.
fn stop() -> Case {
    Case::new(&[("x", -1.0, "v"), ("v", 1.0, "-k*pos(x)/m")], &[("k", 9.0), ("m", 1.0)])
}

/// `x`, `v` and their derivatives by `x0`, `v0`, `k`, `m` after the impact: half a sine, then flight.
fn stopped(t: f64, [x0, v0, k, m]: [f64; 4]) -> [f64; 2] {
    let (w, hit) = ((k / m).sqrt(), -x0 / v0);
    let since = t - hit;
    if since < 0.0 {
        [x0 + v0 * t, v0]
    } else if w * since < std::f64::consts::PI {
        [v0 / w * (w * since).sin(), v0 * (w * since).cos()]
    } else {
        [-v0 * (since - std::f64::consts::PI / w), -v0]
    }
}

#[test]
fn a_one_sided_spring_has_the_derivatives_of_its_closed_form() {
    for (tolerance, accuracy) in [(1e-6, 2e-5), (1e-9, 2e-8), (1e-12, 2e-10)] {
        let times = grid(3.1, 31);
        let run = stop().tolerance(tolerance).run_with_sensitivities(&times);
        assert_eq!((run.events.len(), run.modes.len()), (0, 0), "a kink is no contact");
        let at = [-1.0, 1.0, 9.0, 1.0];
        for (k, &t) in times.iter().enumerate() {
            let due = stopped(t, at);
            for i in 0..2 {
                assert_abs_diff_eq!(run.states[2 * k + i], due[i], epsilon = accuracy);
            }
            for column in 0..4 {
                // Central differences of the closed form with two Richardson steps.
                let slope = |h: f64| -> [f64; 2] {
                    let side = |h: f64| {
                        let mut moved = at;
                        moved[column] += h;
                        stopped(t, moved)
                    };
                    std::array::from_fn(|i| (side(h)[i] - side(-h)[i]) / (2.0 * h))
                };
                let (coarse, fine) = (slope(2e-4), slope(1e-4));
                for i in 0..2 {
                    let due = fine[i] + (fine[i] - coarse[i]) / 3.0;
                    let got = run.sensitivities[(2 * k + i) * 4 + column];
                    let near = [1.0, 1.0 + std::f64::consts::PI / 3.0].iter().any(|e| (t - e).abs() < 1e-3);
                    assert!(
                        near || (got - due).abs() < accuracy.max(1e-9),
                        "{tolerance:e}: d x{i}(t = {t}) / d {column} is {got}, not {due}"
                    );
                }
            }
        }
    }
}

/// Rates written by hand; the last state is time.
struct Plain(fn(f64, &[f64], &mut [f64]));

impl System<f64, DVector<f64>> for Plain {
    fn system(&self, _: f64, z: &DVector<f64>, dz: &mut DVector<f64>) {
        let n = z.len() - 1;
        dz[n] = 1.0;
        (self.0)(z[n], &z.as_slice()[..n], &mut dz.as_mut_slice()[..n]);
    }
}

/// Compares with DOP853, which passes the kinks by step control alone.
fn compare(case: &Case, rates: fn(f64, &[f64], &mut [f64]), end: f64, tolerance: f64) {
    let times = grid(end, 60);
    let run = case.clone().tolerance(1e-11).run(&times);
    let n = case.start.len();
    let mut z = DVector::from_iterator(n + 1, case.start.iter().copied().chain([0.0]));
    for (k, pair) in times.windows(2).enumerate() {
        let step = pair[1] - pair[0];
        // Defaults but for the tolerances; see `independent.rs`.
        let mut solver = Dop853::from_param(
            Plain(rates),
            pair[0],
            pair[1],
            step,
            z.clone(),
            1e-12,
            1e-12,
            0.9,
            0.0,
            0.333,
            6.0,
            0.01 * step,
            0.0,
            100_000,
            u32::MAX,
            OutputType::Sparse,
        );
        solver.integrate().unwrap();
        z = solver.y_out().last().unwrap().clone();
        for i in 0..n {
            let (got, due) = (run.states[(k + 1) * n + i], z[i]);
            assert!((got - due).abs() < tolerance, "t = {}: x{i} is {got}, not {due}", pair[1]);
        }
    }
}

fn dead(x: f64, g: f64) -> f64 {
    if x.abs() > g { x.signum() * (x.abs() - g) } else { 0.0 }
}

/// Two masses with play between them, a driven one and one on a spring.
fn play() -> Case {
    let first = "(0.4*sin(3*t) - k*dead(x1-x2, gap) - d*(y1-y2) - 0.2*y1)/0.1";
    let second = "(k*dead(x1-x2, gap) + d*(y1-y2) - 0.3*y2 - 2*x2)/0.3";
    let states = [("x1", 0.0, "y1"), ("x2", 0.0, "y2"), ("y1", 0.0, first), ("y2", 0.0, second)];
    Case::new(&states, &[("k", 20.0), ("gap", 0.03), ("d", 0.1)])
}

#[test]
fn another_solver_agrees_about_play() {
    compare(
        &play(),
        |t, x, out| {
            let force = 20.0 * dead(x[0] - x[1], 0.03) + 0.1 * (x[2] - x[3]);
            out.copy_from_slice(&[
                x[2],
                x[3],
                (0.4 * (3.0 * t).sin() - force - 0.2 * x[2]) / 0.1,
                (force - 0.3 * x[3] - 2.0 * x[1]) / 0.3,
            ]);
        },
        12.0,
        1e-8,
    );
}

/// All kinds of kinks, some within others, on surfaces of states and of time.
fn zoo() -> Case {
    let rate = "max(min(2*sin(3*t), lim), -lim) - 0.3*|v|*v - dead(|x|, 0.2) - 0.1*|dead(x, g)| \
                - pos(x - 0.5)^2 - 2*x - min(t - 4, 0)*pos(0.3 - v)";
    Case::new(&[("x", 0.3, "v"), ("v", 0.0, rate)], &[("lim", 1.2), ("g", 0.4)])
}

#[test]
fn another_solver_agrees_about_kinks_of_every_kind() {
    let rates = |t: f64, x: &[f64], out: &mut [f64]| {
        let drive = (2.0 * (3.0 * t).sin()).clamp(-1.2, 1.2);
        let (x, v) = (x[0], x[1]);
        out[0] = v;
        out[1] = drive
            - 0.3 * v.abs() * v
            - dead(x.abs(), 0.2)
            - 0.1 * dead(x, 0.4).abs()
            - (x - 0.5).max(0.0).powi(2)
            - 2.0 * x
            - (t - 4.0).min(0.0) * (0.3 - v).max(0.0);
    };
    compare(&zoo(), rates, 12.0, 1e-8);
}

/// A negative gap is a step of the function, which no kink stands for.
#[test]
fn a_negative_gap_means_what_the_function_means() {
    let case = Case::new(&[("x", 1.0, "v"), ("v", 0.0, "-dead(x, g) - 0.1*v")], &[("g", -0.3)]);
    let rates = |_: f64, x: &[f64], out: &mut [f64]| {
        out.copy_from_slice(&[x[1], -x[0].signum() * (x[0].abs() + 0.3) - 0.1 * x[1]]);
    };
    compare(&case, rates, 1.2, 1e-8);
}

/// What has no value beyond its surface is passed by step control.
#[test]
fn a_root_of_a_size_keeps_its_domain() {
    let case = Case::new(&[("x", 1.0, "v"), ("v", 0.0, "-x/sqrt(|x| + 1e-3) - 0.1*v*|v|^1.5")], &[]);
    let rates = |_: f64, x: &[f64], out: &mut [f64]| {
        let (x, v) = (x[0], x[1]);
        out.copy_from_slice(&[v, -x / (x.abs() + 1e-3).sqrt() - 0.1 * v * v.abs().powf(1.5)]);
    };
    compare(&case, rates, 6.0, 1e-7);
}

/// Rest on a kink, motion that dies out around one, and a touch of one: no run of events, no step wasted.
#[test]
fn rest_on_a_kink_costs_nothing() {
    let tries = |case: &Case, end: f64| {
        let run = case.clone().tolerance(1e-8).run(&grid(end, 200));
        run.steps + run.rejected
    };
    let oscillator = |x: f64, force: &str| {
        let rate = format!("-x - 0.5*v - {force}");
        Case::new(&[("x", x, "v"), ("v", 0.0, &rate)], &[("g", 0.0)])
    };
    for (force, smooth) in [("3*dead(x, g)", "3*x"), ("|x|*v", "0"), ("pos(x) + pos(-x)", "0")] {
        for (start, most) in [(0.0, 1.1), (1.0, 2.2)] {
            let (with, without) =
                (tries(&oscillator(start, force), 60.0), tries(&oscillator(start, smooth), 60.0));
            assert!(
                with as f64 <= most * without as f64 + 2.0,
                "{force} from {start}: {with} against {without}"
            );
        }
    }
    // The sine touches 1 once in each period, and -1 within rounding.
    for level in ["1", "0.99999999", "0.99"] {
        let rate = format!("v - pos(sin(t) - {level}) + dead(cos(t), 1)");
        let touch = tries(&Case::new(&[("v", 0.0, &rate)], &[]), 20.0);
        let free = tries(&Case::new(&[("v", 0.0, "v + 0.01*sin(t)")], &[]), 20.0);
        assert!(touch < 3 * free + 60, "{level}: {touch} against {free}");
    }
}

/// A kink is passed in one shortened step, where step control takes a dozen that it refuses: three quarters of the
/// evaluations that it needs are enough.
#[test]
fn a_kink_costs_little() {
    let saturated = "max(min(-3*x - 0.5*v + 3*sin(2.1*t), 1), -1)";
    let saturated = Case::new(&[("x", 1.0, "v"), ("v", 0.0, saturated)], &[]);
    for (case, end, by_step_control) in [(stop(), 12.0, 452), (play(), 20.0, 15_542), (saturated, 20.0, 2054)]
    {
        let run = case.tolerance(1e-8).run(&grid(end, 400));
        assert!(4 * run.evaluations < 3 * by_step_control, "{} of {by_step_control}", run.evaluations);
        assert!(run.rejected < run.steps / 4, "{} of {}", run.rejected, run.steps);
    }
}
