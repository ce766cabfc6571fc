//! Sensitivities against differences of whole runs, through every kind of event.

use crate::common::{self, Case, grid};
use phisindy_signal::{Interpolation, Signal};
use phisindy_sim::MovingSteps;
use std::sync::Arc;

/// All derivatives of the case by central differences with two Richardson steps, at the sample times.
fn differences(case: &Case, times: &[f64]) -> Vec<Vec<f64>> {
    let n = case.start.len();
    (0..n + case.parameters.len())
        .map(|column| {
            let value = if column < n { case.start[column] } else { case.parameters[column - n] };
            let h = 2e-3 * if value == 0.0 { 0.1 } else { value.abs() };
            let at = |step: f64| {
                let mut moved = case.clone();
                if column < n {
                    moved.start[column] += step;
                } else {
                    moved.parameters[column - n] += step;
                }
                moved.run(times).states
            };
            let central = |h: f64| -> Vec<f64> {
                at(h).iter().zip(at(-h)).map(|(plus, minus)| (plus - minus) / (2.0 * h)).collect()
            };
            let better = |coarse: Vec<f64>, fine: &[f64], gain: f64| -> Vec<f64> {
                coarse.iter().zip(fine).map(|(c, f)| f + (f - c) / (gain - 1.0)).collect()
            };
            let (one, two, four) = (central(h), central(0.5 * h), central(0.25 * h));
            better(better(one, &two, 4.0), &better(two.clone(), &four, 4.0), 16.0)
        })
        .collect()
}

/// Checks every derivative to `accuracy` of the largest of its kind. Samples close to an event do not count:
/// there the difference of two runs compares one that has passed it with one that has not.
#[track_caller]
fn check(name: &str, case: &Case, end: f64, accuracy: f64) {
    check_but(name, case, end, accuracy, &[]);
}

#[track_caller]
fn check_but(name: &str, case: &Case, end: f64, accuracy: f64, skip: &[usize]) {
    let case = case.clone().tolerance(1e-12);
    let times = grid(end, 37);
    let run = case.run_with_sensitivities(&times);
    let (n, m) = (run.n, run.m);
    assert_eq!(run.sensitivities.len(), times.len() * n * m);
    let events = case.run(&[1.02 * end]).events;
    // What holds at the start stops a change of its speed at once.
    let held = run.modes[..run.modes.len() / times.len()].contains(&0);
    let clear = |t: f64| (t > 0.0 || !held) && events.iter().all(|e| (e.time - t).abs() > 0.06);
    for (column, expected) in
        differences(&case, &times).into_iter().enumerate().filter(|(c, _)| !skip.contains(c))
    {
        let size = expected.iter().fold(1e-3_f64, |a, b| a.max(b.abs()));
        for (k, _) in times.iter().enumerate().filter(|(_, t)| clear(**t)) {
            for i in 0..n {
                let (got, want) = (run.sensitivities[(k * n + i) * m + column], expected[k * n + i]);
                assert!(
                    (got - want).abs() < accuracy * size,
                    "{name}: d x{i}(t = {:.4}) / d {column} is {got:.12}, differences say {want:.12}, size {size:e}\n{:?}",
                    times[k],
                    events
                );
            }
        }
    }
    // States with and without sensitivities are the same numbers.
    assert_eq!(case.run(&times).states, run.states);
}

#[test]
fn smooth_motion() {
    let states = [("x", 1.0, "v"), ("v", 0.2, "(-c*v - k*x - k3*x^3 + A*cos(w*t))/m")];
    let parameters = [("m", 1.3), ("c", 0.2), ("k", 2.0), ("k3", 0.5), ("A", 0.7), ("w", 1.1)];
    check("Duffing", &Case::new(&states, &parameters), 20.0, 1e-6);
}

/// The rates jump as the block lets go: the instant moves with all that loads or holds it.
#[test]
fn a_departure_from_a_level_above_that_of_motion() {
    let friction = "(Fk + (Fs - Fk)*rest(v))*sgn(v)";
    let rate = format!("(-c*v - k*x + A*cos(w*t) - {friction})/m");
    let numbers = [("m", 1.1), ("c", 0.1), ("k", 1.0), ("A", 1.4), ("w", 0.35), ("Fs", 0.8), ("Fk", 0.45)];
    let case = Case::new(&[("x", 0.1, "v"), ("v", 0.1, &rate)], &numbers);
    let jumps = case.run(&[40.0]).events.iter().filter(|e| e.from == 0).count();
    assert!(jumps > 2, "it lets go {jumps} times");
    check("breakaway", &case, 40.0, 1e-5);
    // Two bodies: as one lets go, the force on the other that sticks changes.
    let one = format!("(-k*x - c*(v - w) - k*(x - y) + A*cos(W*t) - {friction})/m");
    let two = "(k*(x - y) + c*(v - w) - Fc*sgn(w))/m";
    let numbers =
        [("m", 1.1), ("c", 0.3), ("k", 1.0), ("A", 2.2), ("W", 0.35), ("Fs", 0.8), ("Fk", 0.45), ("Fc", 0.3)];
    let states = [("x", 0.1, "v"), ("y", 0.0, "w"), ("v", 0.1, &one), ("w", 0.0, two)];
    let states = states.map(|(name, start, rate)| (name, start, rate));
    // The other body starts at rest: one that starts a little faster stops at once.
    check("breakaway beside another", &Case::new(&states, &numbers), 30.0, 1e-4);
}

#[test]
fn stop_stick_and_departure_with_coulomb_friction() {
    check("1a", &common::case_1a(), 20.0, 1e-6);
}

/// A chain couples neighbours alone: most derivatives are zero at first, and nothing may be left out when
/// they no longer are, behind bodies that stick either. There are more columns than are advanced together.
#[test]
fn a_chain_of_bodies() {
    let bodies = 12;
    let force = |k: usize| {
        let at = |name: &str, k: usize| {
            if k == 0 || k > bodies { "0".to_owned() } else { format!("{name}{k}") }
        };
        let pull = |n: &str| format!("({} - 2*{} + {})", at(n, k - 1), at(n, k), at(n, k + 1));
        format!(
            "g{k}*({} + 0.1*{}){}",
            pull("x"),
            pull("y"),
            if k % 4 == 2 { format!(" - F*sgn(y{k})") } else { String::new() }
        )
    };
    let names: Vec<[String; 4]> =
        (1..=bodies).map(|k| [format!("x{k}"), format!("y{k}"), force(k), format!("g{k}")]).collect();
    let start = |k: usize| (0.3 * (1.7 * k as f64).sin(), 0.8 * (2.3 * k as f64).cos());
    let mut states = Vec::new();
    for (k, [x, y, force, _]) in names.iter().enumerate() {
        states.extend([(&x[..], start(k).0, &y[..]), (&y[..], start(k).1, &force[..])]);
    }
    let mut parameters = vec![("F", 0.4)];
    parameters.extend(names.iter().enumerate().map(|(k, name)| (&name[3][..], 3.0 + 0.1 * k as f64)));
    let case = Case::new(&states, &parameters);
    assert!(case.run(&[3.0]).events.iter().any(|e| e.to == 0), "some body sticks");
    check("chain", &case, 3.0, 1e-6);
}

#[test]
fn crossing_without_a_stop() {
    let states = [("x", 1.0, "v"), ("v", 0.3, "-k*x - F*sgn(v)")];
    check("free decay", &Case::new(&states, &[("k", 4.0), ("F", 0.1)]), 6.0, 1e-6);
}

#[test]
fn dieterich_ruina() {
    check("1b", &common::case_1b(), 20.0, 1e-6);
}

#[test]
fn two_masses() {
    // It starts at rest: there is no derivative by the start velocities there (columns 2 and 3).
    check_but("7", &common::case_7(), 15.0, 1e-6, &[2, 3]);
    let mut moving = common::case_7();
    moving.start = vec![0.1, -0.1, 0.2, 0.1];
    check("7, moving", &moving, 15.0, 1e-6);
}

#[test]
fn stribeck_on_a_belt() {
    let rate = "(-k*x - c*v - (Fc + (Fs-Fc)*exp(-((v-vb)/vs)^2))*sgn(v - vb))/m";
    let parameters =
        [("k", 1.0), ("c", 0.05), ("Fc", 1.0), ("Fs", 1.5), ("vs", 0.1), ("vb", 0.5), ("m", 1.2)];
    check("belt", &Case::new(&[("x", 0.9, "v"), ("v", 0.1, rate)], &parameters), 20.0, 1e-6);
}

#[test]
fn belt_driven_by_an_input() {
    let time: Arc<[f64]> = Arc::from(grid(20.0, 200));
    let speed = time.iter().map(|t| 0.5 + 0.2 * (0.7 * t).sin()).collect::<Vec<f64>>();
    for kind in [Interpolation::Cubic, Interpolation::Linear] {
        let input = Signal::new(time.clone(), speed.clone(), kind).unwrap();
        let states = [("x", 1.9, "v"), ("v", 0.1, "-k*x - F*sgn(v - g*vb)")];
        let case = Case::driven(&states, &[("k", 1.1), ("F", 1.0), ("g", 1.05)], vec![("vb", input)]);
        check("input belt", &case, 12.0, 2e-6);
    }
}

/// Commands that are held between samples, late by parameters: their steps are events, whose times move.
#[test]
fn steps_of_held_inputs_that_are_late() {
    let time: Arc<[f64]> = Arc::from(grid(12.0, 40));
    let command = |seed: f64| -> Vec<f64> { time.iter().map(|t| 2.0 * (seed * t * t).sin()).collect() };
    let commands = [command(0.7), command(1.1)];
    let late = |delays: [f64; 2], sensitivities: bool| {
        let held = |k: usize| {
            Signal::new(time.clone(), commands[k].clone(), Interpolation::Hold)
                .unwrap()
                .retimed(1.0, delays[k])
        };
        let states = [("x", 0.3, "v"), ("v", 0.5, "a + b^2/3 - k*x - F*sgn(v)")];
        let parameters = [("k", 1.1), ("F", 0.8), ("da", delays[0]), ("db", delays[1])];
        let mut case = Case::driven(&states, &parameters, vec![("a", held(0)), ("b", held(1))]);
        let by = Signal::new([0.0].into(), vec![1.0], Interpolation::Hold).unwrap();
        let of = |input: usize| MovingSteps { input, parameter: 2 + input, by: by.clone() };
        case.options.moving = vec![of(0), of(1)];
        case.options.tolerance = 1e-12;
        let times = grid(11.0, 37);
        if sensitivities { case.run_with_sensitivities(&times) } else { case.run(&times) }
    };
    // At the same instants, where they are late together, for one that is later than the other may end a stop before
    // it; and at others.
    let h = 1e-5;
    for (delays, by) in [([0.25, 0.25], [h, h]), ([0.25, 0.37], [h, 0.0]), ([0.25, 0.37], [0.0, h])] {
        let run = late(delays, true);
        assert!(run.events.iter().any(|e| e.to == 0), "it sticks at times");
        assert_eq!(run.states, late(delays, false).states);
        let moved = |sign: f64| late([delays[0] + sign * by[0], delays[1] + sign * by[1]], false).states;
        let (plus, minus) = (moved(1.0), moved(-1.0));
        let expected: Vec<f64> = plus.iter().zip(minus).map(|(p, m)| (p - m) / (2.0 * h)).collect();
        let size = expected.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        for (i, want) in expected.iter().enumerate() {
            let of = &run.sensitivities[i * run.m + 4..][..2];
            let got = (of[0] * by[0] + of[1] * by[1]) / h;
            assert!((got - want).abs() < 1e-4 * size, "{delays:?} {by:?} {i}: {got} {want} {size}");
        }
    }
}

#[test]
fn mass_on_mass() {
    let states = [
        ("x1", 0.0, "y1"),
        ("x2", 0.0, "y2"),
        ("y1", 0.5, "(A*cos(w*t) - k*x1 - mu*sgn(y1 - y2))/m1"),
        ("y2", 0.1, "(mu*sgn(y1 - y2) - c*y2)/m2"),
    ];
    let parameters = [("A", 2.0), ("w", 0.8), ("k", 1.0), ("mu", 0.6), ("m1", 2.0), ("m2", 1.0), ("c", 0.1)];
    check("mass on mass", &Case::new(&states, &parameters), 20.0, 1e-6);
}

#[test]
fn independent_masses_that_stop_at_the_same_time() {
    let states = [("v1", 2.0, "-F*sgn(v1) - c*v1"), ("v2", 2.0, "-F*sgn(v2) - c*v2"), ("x", 0.3, "v1*v2")];
    // A shift of one start moves one stop and not the other: differences are one-sided nowhere, the two do
    // not interact at the stop.
    check("equal masses", &Case::new(&states, &[("F", 0.5), ("c", 0.1)]), 8.0, 1e-6);
}

#[test]
fn friction_that_is_singular_at_rest() {
    let rate = "A*sin(w*t) - k*x - (F - b*ln(|v|/V))*sgn(v)";
    let parameters = [("A", 2.0), ("w", 0.5), ("k", 1.0), ("F", 0.5), ("b", 0.02), ("V", 0.003)];
    let case = Case::new(&[("x", 0.1, "v"), ("v", 0.2, rate)], &parameters);
    assert!(case.run(&grid(20.0, 40)).events.len() >= 4);
    check("singular", &case, 20.0, 1e-6);
}

#[test]
fn force_that_switches_at_a_place() {
    let states = [("x", 0.0, "v"), ("v", 2.0, "-k*x - (f + k2*(x-gap))*step(x - gap)")];
    check("place", &Case::new(&states, &[("k", 1.0), ("f", 0.8), ("k2", 3.0), ("gap", 0.7)]), 12.0, 1e-6);
}

#[test]
fn force_that_switches_at_a_time_that_is_a_parameter() {
    let states = [("x", 0.0, "v"), ("v", 1.0, "-x + f*step(t - when)")];
    check("time", &Case::new(&states, &[("f", 0.8), ("when", 3.3)]), 12.0, 1e-6);
}

#[test]
fn start_on_the_surface() {
    // Starts stuck: the start velocity stands on the surface, where there is no derivative by it.
    let states = [("x", 0.4, "v"), ("v", 0.0, "A*sin(t) - k*x - F*sgn(v)")];
    check_but("start stuck", &Case::new(&states, &[("A", 1.5), ("k", 1.0), ("F", 0.6)]), 12.0, 1e-6, &[1]);
}

#[test]
fn derivatives_by_part_of_the_parameters_are_the_same_columns() {
    let times = grid(20.0, 10);
    let case = common::case_1b();
    let (n, all) = (2, case.run_with_sensitivities(&times));
    let mut part = case;
    part.options.sensitivities = Some(vec![6, 0]);
    let run = part.run(&times);
    assert_eq!(run.m, n + 2);
    for row in 0..times.len() * n {
        let (a, b) = (&all.sensitivities[row * all.m..], &run.sensitivities[row * run.m..]);
        assert_eq!((a[0], a[1], a[n + 6], a[n]), (b[0], b[1], b[2], b[3]));
    }
}

#[test]
fn before_the_start_they_follow_the_extrapolation() {
    let case = Case::new(&[("x", 0.3, "v"), ("v", 0.5, "-k*x")], &[("k", 2.0)]);
    let run = case.run_with_sensitivities(&[-0.1, 0.0]);
    assert_eq!(run.states[..2], [0.3 - 0.05, 0.5 + 0.06]);
    assert_eq!(run.sensitivities[..6], [1.0, -0.1, 0.0, 0.2, 1.0, 0.03]);
    assert_eq!(run.sensitivities[6..], [1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
}

/// Where the velocity just touches zero there is no derivative; the run goes on with finite numbers.
#[test]
fn grazing_stays_finite() {
    for offset in [0.0, 1e-13, -1e-13, 1e-10, -1e-10, 1e-6] {
        let case = Case::new(&[("v", 1.0 + offset, "2*(t-1) + F - F*sgn(v)")], &[("F", 0.5)]);
        let run = case.run_with_sensitivities(&[0.5, 1.5, 2.0]);
        assert!(run.sensitivities.iter().all(|s| s.is_finite()), "{offset}: {:?}", run.sensitivities);
        assert!((run.states[2] - 1.0).abs() < 1e-3);
    }
}

/// The slope of this friction is singular at rest, and every crossing passes it in a moment: derivatives must
/// be right at the tolerance of a fit too, where the state alone would allow to step over it.
#[test]
fn fast_crossings_of_a_steep_shape() {
    let law = "(F + a*ln((|v|+eps)/V) + b*ln(c0 + V/(|v|+eps)))*sgn(v)";
    let rate = format!("-c*v - k*x + F0*cos(W*t) - {law}");
    let numbers = [("c", 0.12), ("k", 5.6), ("F0", 1.2), ("W", 2.8), ("F", 0.15), ("a", 0.042), ("b", 0.056)];
    let parameters = [&numbers[..], &[("V", 0.003), ("c0", 0.022), ("eps", 1e-6)]].concat();
    let case = Case::new(&[("x", 0.15, "v"), ("v", 0.13, &rate)], &parameters);
    let times = grid(54.0, 10);
    let expected = differences(&case.clone().tolerance(1e-11), &times);
    for tolerance in [1e-6, 1e-7] {
        let run = case.clone().tolerance(tolerance).run_with_sensitivities(&times);
        for (column, expected) in expected.iter().enumerate() {
            let size = expected.iter().fold(1e-3_f64, |a, b| a.max(b.abs()));
            // Of the displacement: the velocity has a corner at each crossing.
            for (i, want) in expected.iter().enumerate().step_by(2) {
                let got = run.sensitivities[i * run.m + column];
                assert!(
                    (got - want).abs() < 2e-3 * size,
                    "{tolerance:e}: column {column} is {got}, differences say {want}"
                );
            }
        }
        // Some 48 crossings, each in a score of steps.
        assert!(run.steps < 2500, "{} steps", run.steps);
    }
}

/// Masses that slide onto belts of their own: where they are then depends on the belt's speed, on the
/// friction and on the start as `x = (v0^2 - V^2)/2F + V (T - (v0 - V)/F)` does.
#[test]
fn a_belt_whose_speed_is_a_parameter_moves_its_own_mass_alone() {
    let states = [
        ("x1", 0.0, "v1"),
        ("v1", 2.0, "-F1*sgn(v1 - V1)"),
        ("x2", 0.0, "v2"),
        ("v2", 3.0, "-F2*sgn(v2 - V2)"),
    ];
    let numbers = [("F1", 0.5), ("V1", 0.3), ("F2", 0.7), ("V2", 0.8)];
    let end = 6.0;
    let run = Case::new(&states, &numbers).run_with_sensitivities(&[end]);
    let (n, m) = (run.n, run.m);
    assert_eq!((n, m), (4, 8));
    for mass in 0..2 {
        let (v0, force, belt) = ([2.0, 3.0][mass], [0.5, 0.7][mass], [0.3, 0.8][mass]);
        let time = (v0 - belt) / force;
        let mut place = vec![0.0; m];
        place[2 * mass] = 1.0;
        place[2 * mass + 1] = time;
        place[4 + 2 * mass] = -0.5 * time * time;
        place[4 + 2 * mass + 1] = end - time;
        let mut speed = vec![0.0; m];
        speed[4 + 2 * mass + 1] = 1.0;
        for (state, due) in [(2 * mass, place), (2 * mass + 1, speed)] {
            for (got, due) in run.sensitivities[state * m..(state + 1) * m].iter().zip(due) {
                assert!((got - due).abs() < 1e-9, "state {state}: {got} instead of {due}");
            }
        }
    }
}

/// The same check for runs with implicit steps.
#[track_caller]
fn check_stiff(name: &str, case: &Case, end: f64, accuracy: f64) {
    let run = case.clone().tolerance(1e-12).run_with_sensitivities(&grid(end, 37));
    assert!(run.implicit > 20, "{name}: {} implicit steps", run.implicit);
    check(name, case, end, accuracy);
}

#[test]
fn stiff_smooth_motion() {
    let states = [("x", 0.5, "v"), ("v", 0.2, "-k*x - c*v + F"), ("F", 0.1, "L*(A*cos(w*t) - b*F^3 - F)")];
    let parameters = [("k", 1.0), ("c", 0.2), ("L", 1e6), ("A", 2.0), ("w", 1.3), ("b", 0.4)];
    check_stiff("actuator", &Case::new(&states, &parameters), 10.0, 1e-6);
}

#[test]
fn stop_stick_and_departure_behind_a_stiff_actuator() {
    let states = [
        ("x", 0.1, "v"),
        ("v", 0.1, "(F - c*v - k*x - mu*sgn(v))/m"),
        ("F", 1.0, "L*(A*cos(w*t) - F - b*v)"),
    ];
    let parameters =
        [("m", 1.0), ("c", 0.1), ("k", 1.0), ("mu", 0.5), ("L", 1e6), ("A", 1.0), ("w", 0.3), ("b", 0.2)];
    let case = Case::new(&states, &parameters);
    let events = case.run(&[20.0]).events;
    assert!(events.iter().any(|e| e.to == 0) && events.iter().any(|e| e.from == 0), "{events:?}");
    check_stiff("actuator with friction", &case, 20.0, 1e-6);
}

/// Next to no mass on a belt: the slip is stiff, the stick is not.
#[test]
fn stick_slip_of_a_stiff_slider() {
    let friction = "(Fc + (Fs - Fc)*exp(-((v - vb)/vs)^2))*sgn(v - vb)";
    let rate = format!("(-k*x - c*v - {friction})/m");
    let states = [("x", 0.5, "v"), ("v", -0.3, &*rate)];
    let parameters =
        [("k", 1.0), ("c", 20.0), ("Fc", 1.0), ("Fs", 1.2), ("vs", 0.5), ("vb", 0.1), ("m", 1e-3)];
    let case = Case::new(&states, &parameters);
    check_stiff("slider", &case, 20.0, 1e-6);
}

/// The fast mode becomes slow, without an event, and the steps are explicit again.
#[test]
fn stiffness_that_fades() {
    let rate = "-(b + L*exp(-5*t))*(x - A*sin(w*t))";
    let parameters = [("b", 1.0), ("L", 1e6), ("A", 2.0), ("w", 20.0)];
    // The second state keeps what the first one forgets.
    let case = Case::new(&[("x", 0.3, rate), ("y", 0.0, "x + 0.1*x*y")], &parameters);
    let run = case.clone().tolerance(1e-12).run(&grid(6.0, 37));
    assert!(run.steps - run.implicit > 200, "{} of {}", run.implicit, run.steps);
    check_stiff("fading", &case, 6.0, 1e-6);
}

/// Bristles: stick, creep and slip without a switch. Where the velocity changes its sign the rates have a
/// kink, which differences see a little late.
#[test]
fn stiff_bristles() {
    let slip = "v - s0*abs(v)*z/(Fc + (Fs - Fc)*exp(-(v/vs)^2))";
    let force = format!("(A*sin(6*t) - k*x - s0*z - s1*({slip}) - s2*v)/m");
    let states = [("x", 5e-4, "v"), ("v", 0.01, &*force), ("z", 5e-6, slip)];
    let parameters = [
        ("m", 1.0),
        ("k", 300.0),
        ("s0", 1e5),
        ("s1", 300.0),
        ("s2", 0.4),
        ("Fc", 1.0),
        ("Fs", 1.5),
        ("vs", 0.02),
        ("A", 6.0),
    ];
    let mut case = Case::new(&states, &parameters);
    case.options.scale = vec![0.01, 0.1, 1e-5];
    check_stiff("bristles", &case, 2.0, 1e-5);
}

/// Elastic contacts that slide one after the other, at any tolerance: the derivatives stay those of the run
/// although the rates are stiff while they slide.
#[test]
fn contacts_that_slide_one_after_the_other() {
    let element = |spread: &str| format!("v*(1 - (pos(SLOT*sgn(v))*kt/(Fc*({spread})))^20)");
    let rates: Vec<String> = ["1 - spread", "1 - spread/3", "1 + spread/3", "1 + spread"]
        .iter()
        .enumerate()
        .map(|(k, spread)| element(spread).replace("SLOT", &format!("z{}", k + 1)))
        .collect();
    let body = "F*(cos(w*t) + cos(2.3*w*t)) - c*v - k*x - 0.25*kt*(z1 + z2 + z3 + z4)";
    let names = ["z1", "z2", "z3", "z4"];
    let mut states = vec![("x", 0.01, "v"), ("v", 0.02, body)];
    states.extend(names.iter().zip(&rates).map(|(name, rate)| (*name, 0.0, rate.as_str())));
    let parameters =
        [("F", 1.0), ("w", 1.3), ("c", 0.053), ("k", 8.4), ("Fc", 0.66), ("kt", 5.6), ("spread", 0.51)];
    let case = Case::new(&states, &parameters);
    let times = grid(60.0, 300);
    let exact = differences(&case.clone().tolerance(1e-12), &times);
    for tolerance in [1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-11] {
        let run = case.clone().tolerance(tolerance).run_with_sensitivities(&times);
        let (n, m) = (run.n, run.m);
        for (column, exact) in exact.iter().enumerate() {
            let size = exact.iter().step_by(n).fold(0.0_f64, |a, b| a.max(b.abs()));
            for k in 0..times.len() {
                let (got, want) = (run.sensitivities[k * n * m + column], exact[k * n]);
                assert!((got - want).abs() < 1e-3 * size, "{tolerance:e} {column} {got} {want} {size}");
            }
        }
    }
}
