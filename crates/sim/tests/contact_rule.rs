//! The contact rule: what sticks, when it lets go, and which way.

use crate::common::{self, Case, grid, story};
use approx::assert_abs_diff_eq;
use phisindy_signal::{Interpolation, Signal};
use phisindy_sim::{Drive, simulate};
use std::sync::Arc;

fn signal(time: &[f64], value: impl Fn(f64) -> f64, kind: Interpolation) -> Signal {
    Signal::new(Arc::from(time), time.iter().map(|&t| value(t)).collect(), kind).unwrap()
}

#[test]
fn a_slowly_growing_load_lets_go_at_the_friction_level() {
    for (push, way) in [("a*t", 1.0), ("-a*t", -1.0)] {
        let rate = format!("{push} - F*sgn(v)");
        let case = Case::new(&[("x", 0.0, "v"), ("v", 0.0, &rate)], &[("a", 0.01), ("F", 0.5)]);
        let run = case.run(&[25.0, 49.0, 60.0]);
        assert_eq!(story(&run), [(0, 0, way as i8)]);
        assert_abs_diff_eq!(run.events[0].time, 50.0, epsilon = 1e-11);
        assert_eq!(run.states[..4], [0.0; 4]);
        assert_abs_diff_eq!(run.states[5], way * 0.005 * 100.0, epsilon = 1e-10);
        assert_abs_diff_eq!(run.states[4], way * 0.005 / 3.0 * 1000.0, epsilon = 1e-9);
    }
}

/// The load is a small difference of large forces: its rounding errors are ten thousand times larger than
/// elsewhere.
#[test]
fn rounding_of_the_load_does_not_shake_it() {
    let rate = "a*t + P*(1 + t) - P - P*t - F*sgn(v)";
    for k in 0..100 {
        let (a, force) = (0.01, 0.4 + 0.00123 * f64::from(k));
        let case = Case::new(&[("v", 0.0, rate)], &[("a", a), ("F", force), ("P", 1e6)]).tolerance(1e-8);
        let run = case.run(&[30.0, 60.0]);
        assert_eq!(story(&run), [(0, 0, 1)], "F = {force}: {:?}", run.events);
        assert_abs_diff_eq!(run.events[0].time, force / a, epsilon = 1e-6);
        assert_abs_diff_eq!(run.states[1], 0.5 * a * (60.0 - force / a).powi(2), epsilon = 1e-6);
    }
}

#[test]
fn at_rest_it_stays_under_load_within_friction_and_leaves_the_pushed_way_beyond() {
    for (load, mode) in [(0.0, 0), (0.4, 0), (-0.4, 0), (0.5, 0), (-0.5, 0), (0.6, 1), (-0.6, -1)] {
        let case = Case::new(&[("x", 0.0, "v"), ("v", 0.0, "P - 0.5*sgn(v)")], &[("P", load)]);
        let run = case.run(&[0.0, 2.0]);
        assert_eq!(run.modes, [mode, mode], "load {load}");
        assert_abs_diff_eq!(run.states[3], f64::from(mode) * 0.2, epsilon = 1e-12);
        assert!(run.events.is_empty());
    }
}

#[test]
fn asymmetric_friction_holds_more_one_way() {
    let rate = "a*t - (Fp*step(v) - Fm*step(-v))";
    for (a, leave, way) in [(0.1, 3.0, 1), (-0.1, 6.0, -1)] {
        let case = Case::new(&[("v", 0.0, rate)], &[("a", a), ("Fp", 0.3), ("Fm", 0.6)]);
        let run = case.run(&[8.0]);
        assert_eq!(story(&run), [(0, 0, way)]);
        assert_abs_diff_eq!(run.events[0].time, leave, epsilon = 1e-11);
        assert_abs_diff_eq!(run.states[0], 0.5 * a * (8.0 - leave).powi(2), epsilon = 1e-11);
    }
}

#[test]
fn negative_friction_does_not_stick() {
    let states = [("x", 1.0, "v"), ("v", 0.0, "-x + 0.3*sgn(v)")];
    let run = Case::new(&states, &[]).run(&[std::f64::consts::PI, 2.0 * std::f64::consts::PI]);
    assert!(run.events.iter().all(|e| e.from != 0 && e.to != 0), "{:?}", run.events);
    assert_abs_diff_eq!(run.states[0], -1.6, epsilon = 1e-9);
    assert_abs_diff_eq!(run.states[2], 2.2, epsilon = 1e-9);
}

/// Friction that pushes opens both ways from rest: it leaves the way of the stronger push, with the sum of
/// both.
#[test]
fn from_rest_negative_friction_leaves_the_way_of_the_stronger_push() {
    for (push, way) in [(0.1, 1.0), (-0.1, -1.0)] {
        let case = Case::new(&[("x", 0.0, "v"), ("v", 0.0, "P + 0.5*sgn(v)")], &[("P", push)]);
        let run = case.run(&[2.0]);
        assert_eq!((story(&run), run.modes.clone()), (vec![], vec![way as i8]));
        assert_abs_diff_eq!(run.states[0], way * 0.6 * 2.0, epsilon = 1e-12);
        assert_abs_diff_eq!(run.states[1], way * 0.6 * 2.0, epsilon = 1e-12);
    }
}

#[test]
fn a_velocity_that_touches_zero_goes_on() {
    // v = (t-1)^2 while it slips forwards, and the load is just what friction can hold where it touches.
    let case = Case::new(&[("v", 1.0, "2*(t-1) + F - F*sgn(v)")], &[("F", 0.5)]);
    let run = case.run(&[0.5, 2.0]);
    assert_abs_diff_eq!(run.states[0], 0.25, epsilon = 1e-10);
    assert_abs_diff_eq!(run.states[1], 1.0, epsilon = 1e-6);
}

#[test]
fn a_dip_below_zero_within_one_long_step_is_found() {
    // v = (t-1)^2 - d: below zero for 2 sqrt(d), much less than a step.
    let d: f64 = 1e-6;
    let case = Case::new(&[("v", 1.0 - d, "2*(t-1) - F*sgn(v) + F")], &[("F", 0.5)]);
    let run = case.run(&[2.0]);
    assert_eq!(story(&run), [(0, 1, 0), (0, 0, 1)]);
    assert_abs_diff_eq!(run.events[0].time, 1.0 - d.sqrt(), epsilon = 1e-9);
    assert_abs_diff_eq!(run.events[1].time, 1.0, epsilon = 1e-9);
    assert_abs_diff_eq!(run.states[0], 1.0, epsilon = 1e-9);
}

/// The same where the rate is not straight over the step, so that its zero has to be searched.
#[test]
fn a_dip_of_a_motion_that_is_no_parabola_is_found() {
    // v = exp(t-1) - t - d, least at t = 1.
    let d: f64 = 1e-6;
    let start = (-1.0_f64).exp() - d;
    let case = Case::new(&[("v", start, "exp(t-1) - 1 - F*sgn(v) + F")], &[("F", 0.5)]);
    let run = case.run(&[2.0]);
    // By Newton's method from the parabola.
    let mut stop = 1.0 - (2.0 * d).sqrt();
    for _ in 0..5 {
        stop -= ((stop - 1.0).exp_m1() - (stop - 1.0) - d) / (stop - 1.0).exp_m1();
    }
    assert_eq!(story(&run), [(0, 1, 0), (0, 0, 1)]);
    assert_abs_diff_eq!(run.events[0].time, stop, epsilon = 1e-8);
    assert_abs_diff_eq!(run.events[1].time, 1.0, epsilon = 1e-8);
    assert_abs_diff_eq!(run.states[0], std::f64::consts::E - 2.0, epsilon = 1e-9);
}

#[test]
fn a_short_peak_of_load_lets_go() {
    // The load passes the friction level for a hundredth of its period only.
    let peak: f64 = 1.0005;
    let case = Case::new(&[("v", 0.0, "P*sin(t) - sgn(v)")], &[("P", peak)]);
    let run = case.run(&grid(20.0, 100));
    let leave = (1.0 / peak).asin();
    assert!(run.events.len() >= 8, "{:?}", run.events);
    assert_abs_diff_eq!(run.events[0].time, leave, epsilon = 1e-9);
    assert_abs_diff_eq!(run.events[2].time, leave + std::f64::consts::PI, epsilon = 1e-9);
}

#[test]
fn masses_on_each_other_move_as_one_and_let_go_at_the_right_time() {
    // A growing force on the lower mass (2 kg); friction alone pulls the upper one (1 kg) along: up to F = a
    // t = 3 mu.
    let states = [
        ("x1", 0.0, "y1"),
        ("x2", 0.0, "y2"),
        ("y1", 0.3, "(a*t - mu*sgn(y1 - y2))/2"),
        ("y2", 0.3, "mu*sgn(y1 - y2)"),
    ];
    let (a, mu) = (0.2, 0.4);
    let run = Case::new(&states, &[("a", a), ("mu", mu)]).run(&[3.0, 10.0]);
    let leave = 3.0 * mu / a;
    assert_eq!(story(&run), [(0, 0, 1)]);
    assert_abs_diff_eq!(run.events[0].time, leave, epsilon = 1e-11);
    assert_abs_diff_eq!(run.states[2], 0.3 + a * 9.0 / 6.0, epsilon = 1e-11);
    assert_eq!(run.states[2], run.states[3], "they move as one");
    assert_abs_diff_eq!(run.states[0], run.states[1], epsilon = 1e-13);
    let at = 0.3 + a * leave * leave / 6.0;
    let after = 10.0 - leave;
    assert_abs_diff_eq!(run.states[7], at + mu * after, epsilon = 1e-10);
    assert_abs_diff_eq!(run.states[6], at + mu * after + a * after * after / 4.0, epsilon = 1e-10);
}

#[test]
fn sliding_masses_come_to_rest_on_each_other_and_then_on_the_floor() {
    // The upper mass is thrown; the lower one is dragged along if mu12 m2 > mu1 (m1+m2).
    let states = [("y1", 0.0, "(0.6*sgn(y2-y1) - 0.3*sgn(y1))/2"), ("y2", 3.0, "-0.6*sgn(y2-y1)")];
    let run = Case::new(&states, &[]).run(&[1.0, 10.0, 50.0]);
    // Relative speed 3 falls at 0.75: together at t = 4 with 0.6; then both slow down at 0.1: at rest at t =
    // 10.
    let stops: Vec<(usize, f64)> =
        run.events.iter().filter(|e| e.to == 0).map(|e| (e.switch, e.time)).collect();
    assert_eq!(stops.len(), 2, "{:?}", run.events);
    assert_ne!(stops[0].0, stops[1].0);
    assert_abs_diff_eq!(stops[0].1, 4.0, epsilon = 1e-10);
    assert_abs_diff_eq!(stops[1].1, 10.0, epsilon = 1e-10);
    assert_abs_diff_eq!(run.states[0], 0.15, epsilon = 1e-12);
    assert!(run.states[4..].iter().all(|v| v.abs() < 1e-16));
}

#[test]
fn contacts_that_hold_the_same_thing_share_the_load() {
    // Two masses on the floor and rubbing on each other: three contacts, two velocities.
    let states =
        [("y1", 0.0, "a*t - 0.5*sgn(y1) - 0.2*sgn(y1-y2)"), ("y2", 0.0, "-0.5*sgn(y2) + 0.2*sgn(y1-y2)")];
    let run = Case::new(&states, &[("a", 0.1)]).run(&[4.0, 6.0, 10.0]);
    // The first gives way at 0.5 + 0.2; 0.2 is not enough to move the second.
    assert_eq!(run.modes[..3], [0, 0, 0]);
    assert_eq!(run.states[..4], [0.0; 4]);
    assert_abs_diff_eq!(run.states[4], 0.05 * 9.0, epsilon = 1e-9);
    assert_eq!(run.states[5], 0.0);
}

/// What of three contacts is decided by the others takes nothing away from a fourth one, wherever it stands.
#[test]
fn contacts_that_hold_the_same_thing_leave_the_others_alone() {
    let pair =
        [("y1", 0.0, "0.1*t - 0.5*sgn(y1) - 0.5*sgn(y1-y2)"), ("y2", 0.0, "-0.5*sgn(y2) + 0.5*sgn(y1-y2)")];
    let third = ("y3", 0.0, "0.1*t - 0.25*sgn(y3)");
    for states in [[pair[0], pair[1], third], [third, pair[0], pair[1]], [pair[0], third, pair[1]]] {
        let of = states.iter().position(|s| s.0 == "y3").unwrap();
        let run = Case::new(&states, &[]).run(&[2.0, 4.5]);
        assert_eq!(run.events.len(), 1, "{:?}", run.events);
        assert_abs_diff_eq!(run.events[0].time, 2.5, epsilon = 1e-9);
        assert_eq!(run.states[..3], [0.0; 3]);
        assert_abs_diff_eq!(run.states[3 + of], 0.05 * 4.0, epsilon = 1e-9);
    }
}

#[test]
fn friction_that_is_singular_at_rest_holds_and_lets_go() {
    // 0.5 - 0.02 ln(|v|/V): infinite at rest; as large as it is a millionth off rest by the rule, at the
    // scale 1 of speed.
    let capacity = |floor: f64| 0.5 - 0.02 * (floor / 0.003).ln();
    let rate = "a*t - (0.5 - 0.02*ln(|v|/V))*sgn(v)";
    let case = Case::new(&[("x", 0.0, "v"), ("v", 0.2, rate)], &[("a", 0.05), ("V", 0.003)]).tolerance(1e-8);
    let run = case.run(&grid(30.0, 300));
    assert_eq!(story(&run), [(0, 1, 0), (0, 0, 1)]);
    assert_abs_diff_eq!(run.events[1].time, capacity(1e-7) / 0.05, epsilon = 1e-9);
    assert!(run.states.iter().chain(&run.rates).all(|v| v.is_finite()));
    assert!(run.steps + run.rejected < 600, "{} {}", run.steps, run.rejected);
    // The scale of the states sets what "just off rest" is.
    let mut small = case.clone();
    small.options.scale = vec![1e-3, 1e-3];
    let run = small.run(&grid(30.0, 300));
    assert_abs_diff_eq!(run.events[1].time, capacity(1e-10) / 0.05, epsilon = 1e-9);
}

#[test]
fn friction_that_rises_at_once_holds_what_it_rises_to() {
    let rate = "a*t - F*tanh(|v|/vs)*sgn(v)";
    let case = Case::new(&[("v", 0.0, rate)], &[("a", 0.1), ("F", 0.5), ("vs", 1e-9)]);
    let run = case.run(&[4.9, 8.0]);
    assert_eq!(run.states[0], 0.0);
    assert_abs_diff_eq!(run.events[0].time, 5.0, epsilon = 1e-9);
    assert_abs_diff_eq!(run.states[1], 0.05 * 9.0, epsilon = 1e-9);
}

#[test]
fn friction_without_a_value_at_rest_takes_the_largest_one_nearby() {
    // With eps = 0 both logarithms are infinite at rest and their sum is not a number.
    let law = "(0.5 + 0.07*ln(|y|/V) + 0.09*ln(0.022 + V/|y|))*sgn(y)";
    let rate = format!("-0.1*y - x + cos(0.3*t) - {law}");
    let case = Case::new(&[("x", 0.1, "y"), ("y", 0.1, &rate)], &[("V", 0.003)]).tolerance(1e-8);
    let run = case.run(&grid(50.0, 500));
    let near = common::case_1b().tolerance(1e-8).run(&grid(50.0, 500));
    assert_eq!(story(&run), story(&near));
    assert!(run.states.iter().all(|v| v.is_finite()));
}

#[test]
fn two_uncoupled_equal_masses_stop_at_the_same_time() {
    let states = [
        ("v1", 2.0, "-0.5*sgn(v1) - 0.1*v1"),
        ("v2", 2.0, "-0.5*sgn(v2) - 0.1*v2"),
        ("v3", -2.0, "-0.5*sgn(v3) - 0.1*v3"),
    ];
    let run = Case::new(&states, &[]).run(&[20.0]);
    assert_eq!(run.states, [0.0; 3]);
    assert_eq!(run.events.len(), 3);
    assert!(
        run.events.iter().all(|e| e.to == 0 && (e.time - run.events[0].time).abs() < 1e-12),
        "{:?}",
        run.events
    );
}

/// Each mass goes with its own belt, whose speed is an input of its own.
#[test]
fn two_masses_stick_to_two_belts() {
    let belt = |slope: f64| signal(&[0.0, 10.0], |t| slope * t, Interpolation::Linear);
    let states = [("v", 0.0, "-0.5*sgn(v-u)"), ("z", 0.0, "-0.5*sgn(z-w)")];
    let run = Case::driven(&states, &[], vec![("u", belt(0.3)), ("w", belt(-0.1))]).run(&[2.0, 7.0]);
    for (found, due) in run.states.iter().zip([0.6, -0.2, 2.1, -0.7]) {
        assert_abs_diff_eq!(*found, due, epsilon = 1e-12);
    }
    assert_eq!(run.modes, [0; 4]);
}

/// Three that do not touch, each with a shape of friction of its own, in one model and one by one: the same
/// motion, the same events, the same derivatives.
#[test]
fn bodies_that_do_not_touch_move_as_each_alone() {
    let laws = [
        ("-2*x0 + cos(0.7*t) - (f0 + d*exp(-|v0|/V))*sgn(v0)", vec![("f0", 0.2), ("d", 0.3), ("V", 0.2)]),
        ("-x1 + 2*sin(0.5*t) - (f1 - b*ln(|v1|/W))*sgn(v1)", vec![("f1", 0.5), ("b", 0.02), ("W", 0.003)]),
        ("-3*x2 + 2*cos(0.4*t) - (f2 + g*|v2|)*sgn(v2)", vec![("f2", 0.4), ("g", 0.3)]),
    ];
    let names = [("x0", "v0"), ("x1", "v1"), ("x2", "v2")];
    let body = |k: usize| vec![(names[k].0, 0.1, names[k].1), (names[k].1, 0.2 + 0.1 * k as f64, laws[k].0)];
    let all: Vec<_> = (0..3).flat_map(body).collect();
    let numbers: Vec<_> = laws.iter().flat_map(|(_, numbers)| numbers.clone()).collect();
    let times = grid(25.0, 250);
    let together = Case::new(&all, &numbers).run_with_sensitivities(&times);
    let m = 6 + numbers.len();
    let mut parameter = 0;
    for (k, (_, own_numbers)) in laws.iter().enumerate() {
        let alone = Case::new(&body(k), own_numbers).run_with_sensitivities(&times);
        let own = together.events.iter().filter(|e| e.switch == k);
        assert!(alone.events.len() >= 4);
        assert_eq!(
            own.clone().map(|e| (e.from, e.to)).collect::<Vec<_>>(),
            alone.events.iter().map(|e| (e.from, e.to)).collect::<Vec<_>>()
        );
        for (a, b) in own.zip(&alone.events) {
            assert_abs_diff_eq!(a.time, b.time, epsilon = 1e-7);
        }
        // Columns of the derivatives: starts, then parameters.
        let columns: Vec<usize> =
            (2 * k..2 * k + 2).chain((0..own_numbers.len()).map(|p| 6 + parameter + p)).collect();
        parameter += own_numbers.len();
        for i in 0..times.len() {
            for state in 0..2 {
                assert_abs_diff_eq!(
                    together.states[6 * i + 2 * k + state],
                    alone.states[2 * i + state],
                    epsilon = 1e-7
                );
                let row = &together.sensitivities[(6 * i + 2 * k + state) * m..][..m];
                let due = &alone.sensitivities[(2 * i + state) * columns.len()..][..columns.len()];
                for (j, &value) in row.iter().enumerate() {
                    let due = columns.iter().position(|&c| c == j).map_or(0.0, |c| due[c]);
                    assert_abs_diff_eq!(value, due, epsilon = 1e-4 * due.abs().max(1.0));
                }
            }
        }
    }
}

/// Stops, departures and reversals come when they do, whatever the unit of length.
#[test]
fn the_unit_of_length_moves_no_event() {
    let states = |unit: f64| {
        [
            ("v1", 2.0 * unit, "-0.5*U*sgn(v1)"),
            ("v2", 3.0 * unit, "-0.5*U*sgn(v2)"),
            ("v3", 2.0 * unit, "-0.5*U*sgn(v3)"),
            ("v4", 0.0, "0.1*U*t - 0.5*U*sgn(v4)"),
            ("v5", 1.0 * unit, "-0.25*U - 0.1*U*sgn(v5)*step(-v5)"),
        ]
    };
    for unit in [1e-9, 1e-6, 1.0, 1e6, 1e9] {
        let mut case = Case::new(&states(unit), &[("U", unit)]);
        case.options.scale = vec![unit; 5];
        let run = case.run(&[3.0, 7.0]);
        // The last one goes through zero at t = 4 and on with a push that friction of one way takes off.
        let mut seen: Vec<(usize, i8, f64)> = run.events.iter().map(|e| (e.switch, e.to, e.time)).collect();
        seen.sort_by(|a, b| a.0.cmp(&b.0).then(a.2.total_cmp(&b.2)));
        let due = [(0, 0, 4.0), (1, 0, 6.0), (2, 0, 4.0), (3, 1, 5.0), (4, -1, 4.0)];
        for ((switch, to, time), (a, b, c)) in seen.iter().zip(due) {
            assert_eq!((*switch, *to), (a, b), "{unit}: {seen:?}");
            assert_abs_diff_eq!(*time, c, epsilon = 1e-9);
        }
        for (got, due) in run.states.iter().zip([0.5, 1.5, 0.5, 0.0, 0.25, 0.0, 0.0, 0.0, 0.2, -0.45]) {
            assert_abs_diff_eq!(got / unit, due, epsilon = 1e-9);
        }
    }
}

#[test]
fn a_chain_gives_way_mass_by_mass() {
    // A slow pull at one end: mass j moves when the load on it passes its friction, the others hold exactly
    // still.
    let names: Vec<(String, String)> = (0..5).map(|j| (format!("x{j}"), format!("y{j}"))).collect();
    let mut states: Vec<(&str, f64, String)> =
        names.iter().map(|(x, y)| (x.as_str(), 0.0, y.clone())).collect();
    for (j, (_, speed)) in names.iter().enumerate() {
        let left = if j == 0 { "0.05*t".to_owned() } else { format!("(x{}-x{j})", j - 1) };
        let right = if j == 4 { String::new() } else { format!(" - (x{j}-x{})", j + 1) };
        states.push((speed, 0.0, format!("{left}{right} - 2*{speed} - 0.3*sgn({speed})")));
    }
    let states: Vec<(&str, f64, &str)> = states.iter().map(|(n, s, r)| (*n, *s, r.as_str())).collect();
    let run = Case::new(&states, &[]).tolerance(1e-9).run(&grid(120.0, 1200));
    let first: Vec<f64> =
        (0..5).map(|j| run.events.iter().find(|e| e.switch == j && e.to == 1).unwrap().time).collect();
    assert_abs_diff_eq!(first[0], 6.0, epsilon = 1e-10);
    assert!(first.windows(2).all(|pair| pair[0] < pair[1]), "{first:?}");
    for k in 0..1201 {
        for j in 0..5 {
            if run.modes[5 * k + j] == 0 {
                assert_eq!(run.states[10 * k + 5 + j], 0.0, "a mass that sticks does not creep");
            }
        }
    }
}

#[test]
fn a_stuck_mass_follows_a_belt_whose_speed_is_an_input() {
    // Belt speed 0.5 + 0.2 sin t from samples: the mass moves with it as long as friction can accelerate it.
    let belt = |t: f64| 0.5 + 0.2 * t.sin();
    let time = grid(20.0, 400);
    for (kind, tolerance) in [(Interpolation::Cubic, 1e-6), (Interpolation::Linear, 1e-3)] {
        let states = [("x", 0.0, "v"), ("v", 0.5, "-0.05*x - F*sgn(v - vb)")];
        let case = Case::driven(&states, &[("F", 0.4)], vec![("vb", signal(&time, belt, kind))]);
        let run = case.run(&grid(20.0, 133));
        let leave = run.events.iter().find(|e| e.from == 0).unwrap().time;
        for (k, t) in grid(20.0, 133).into_iter().enumerate().take_while(|(_, t)| *t <= leave) {
            let x = 0.5 * t + 0.2 * (1.0 - t.cos());
            assert_abs_diff_eq!(run.states[2 * k], x, epsilon = tolerance);
            assert_abs_diff_eq!(run.states[2 * k + 1], case.inputs[0].value(t), epsilon = 2e-15);
        }
        // It lets go when -0.05 x - 0.2 cos t passes the level.
        let x = 0.5 * leave + 0.2 * (1.0 - leave.cos());
        let slack = if kind == Interpolation::Cubic { 1e-3 } else { 0.02 };
        assert_abs_diff_eq!(0.05 * x + 0.2 * leave.cos(), 0.4, epsilon = slack);
    }
}

#[test]
fn a_held_force_takes_effect_at_its_jump_exactly() {
    let time = [0.0, 1.0, 2.5, 4.0];
    let level = |t: f64| {
        if t < 1.0 {
            0.2
        } else if t < 2.5 {
            0.7
        } else {
            -0.1
        }
    };
    let force = signal(&time, level, Interpolation::Hold);
    let case = Case::driven(&[("v", 0.0, "P - 0.5*sgn(v)")], &[], vec![("P", force)]);
    let run = case.run(&[0.9, 2.0, 2.5, 4.0]);
    assert_eq!(story(&run), [(0, 0, 1), (0, 1, 0)]);
    assert_eq!(run.events[0].time, 1.0);
    assert_abs_diff_eq!(run.states[1], 0.2, epsilon = 1e-14);
    assert_abs_diff_eq!(run.states[2], 0.3, epsilon = 1e-14);
    // From 0.3 at -0.1 - 0.5.
    assert_abs_diff_eq!(run.events[1].time, 3.0, epsilon = 1e-12);
    assert!(run.rejected == 0 && run.steps < 20, "{} {}", run.steps, run.rejected);
}

#[test]
fn a_belt_that_jumps_tears_the_mass_off() {
    let speed = signal(&[0.0, 1.0, 10.0], |t| if t < 1.0 { 0.5 } else { 1.5 }, Interpolation::Hold);
    let case = Case::driven(&[("v", 0.5, "-F*sgn(v - vb)")], &[("F", 0.4)], vec![("vb", speed)]);
    let run = case.run(&[1.0, 2.0, 6.0]);
    assert_eq!(story(&run), [(0, 0, -1), (0, -1, 0)]);
    assert_eq!(run.events[0].time, 1.0);
    assert_abs_diff_eq!(run.states[1], 0.9, epsilon = 1e-12);
    assert_abs_diff_eq!(run.events[1].time, 3.5, epsilon = 1e-12);
    assert_eq!(run.states[2], 1.5);
}

/// The belt is overtaken at one instant, without a moment at its speed: friction turns round there.
#[test]
fn a_belt_that_jumps_past_a_sliding_mass_turns_its_friction() {
    for way in [1.0, -1.0] {
        for fast in [1.3, 2.4] {
            let speed =
                signal(&[0.0, 1.0, 10.0], |t| if t < 1.0 { 0.0 } else { way * fast }, Interpolation::Hold);
            let rate = [("v", way, "-F*sgn(v - vb)")];
            let run = Case::driven(&rate, &[("F", 0.1)], vec![("vb", speed)]).run(&[1.0, 2.0]);
            let way = way as i8;
            assert_eq!(story(&run), [(0, way, -way)]);
            assert_eq!(run.events[0].time, 1.0);
            assert_abs_diff_eq!(run.states[0], f64::from(way) * 0.9, epsilon = 1e-12);
            assert_abs_diff_eq!(run.states[1], f64::from(way) * 1.0, epsilon = 1e-12);
        }
    }
}

#[test]
fn a_linear_ramp_of_force_lets_go_inside_its_piece() {
    let ramp =
        signal(&[0.0, 2.0, 5.0, 9.0], |t| if t < 2.0 { 0.0 } else { 0.2 * (t - 2.0) }, Interpolation::Linear);
    let case = Case::driven(&[("v", 0.0, "P - 0.5*sgn(v)")], &[], vec![("P", ramp)]);
    let run = case.run(&[9.0]);
    assert_abs_diff_eq!(run.events[0].time, 4.5, epsilon = 1e-12);
    assert_abs_diff_eq!(run.states[0], 0.1 * 4.5 * 4.5, epsilon = 1e-12);
}

#[test]
fn a_burst_of_force_on_something_at_rest_is_not_stepped_over() {
    let time = grid(50.0, 5000);
    let burst = signal(&time, |t| (-((t - 30.0) / 0.05).powi(2)).exp(), Interpolation::Cubic);
    for rate in ["P - x", "P - x - 0.5*sgn(v)"] {
        let case = Case::driven(&[("x", 0.0, "v"), ("v", 0.0, rate)], &[], vec![("P", burst.clone())]);
        let run = case.run(&[50.0]);
        assert!(run.states[0] != 0.0, "{rate}");
    }
}

#[test]
fn a_force_that_switches_at_a_place_is_located() {
    // Thrown upwards; above x = 1 it is pulled back three times as hard.
    let case = Case::new(&[("x", 0.0, "v"), ("v", 2.0, "-1 - 2*step(x - gap)")], &[("gap", 1.0)]);
    let (up, over) = (2.0 - 2.0_f64.sqrt(), 2.0 * 2.0_f64.sqrt() / 3.0);
    let run = case.run(&[up + 0.5 * over, up + over + 1.0]);
    assert_eq!(story(&run), [(0, -1, 1), (0, 1, -1)]);
    assert_abs_diff_eq!(run.events[0].time, up, epsilon = 1e-12);
    assert_abs_diff_eq!(run.events[1].time, up + over, epsilon = 1e-12);
    assert_abs_diff_eq!(run.states[0], 1.0 + 1.0 / 3.0, epsilon = 1e-12);
    assert_abs_diff_eq!(run.states[2], 1.0 - 2.0_f64.sqrt() - 0.5, epsilon = 1e-12);
}

#[test]
fn a_force_that_switches_at_a_time_is_located() {
    let run = Case::new(&[("v", 0.0, "step(t - 2.7) - 3*step(t - 3.1)")], &[]).run(&[0.0, 10.0]);
    assert_abs_diff_eq!(run.states[1], 7.3 - 3.0 * 6.9, epsilon = 1e-11);
}

#[test]
fn what_sticks_does_not_drift() {
    for case in [common::case_1a(), common::case_1b(), common::case_7()] {
        let run = case.tolerance(1e-8).run(&grid(50.0, 5000));
        let (n, c) = (run.n, run.n / 2);
        let mut rest = vec![None; c];
        for k in 0..5001 {
            for (j, rest) in rest.iter_mut().enumerate() {
                let (x, v) = (run.states[k * n + j], run.states[k * n + c + j]);
                if run.modes[k * c + j] != 0 {
                    *rest = None;
                    continue;
                }
                assert!(v.abs() < 1e-16, "{v:e} while stuck");
                let place: f64 = *rest.get_or_insert(x);
                assert!((x - place).abs() < 1e-15, "it drifted by {:e}", x - place);
            }
        }
    }
}

/// Three contacts on three bodies in a row, all stuck: moving each of them onto its surface without a look at
/// the others lets their speeds grow from step to step.
#[test]
fn contacts_that_share_a_body_rest_together() {
    let states = [
        ("x1", 0.0, "y1"),
        ("x2", 0.0, "y2"),
        ("x3", 0.0, "y3"),
        ("y1", 0.3, "-x1 - 2*sgn(y1-y2)"),
        ("y2", -0.2, "2*sgn(y1-y2) - 2*sgn(y2-y3) - 2*sgn(y2)"),
        ("y3", 0.5, "2*sgn(y2-y3) - x3"),
    ];
    let run = Case::new(&states, &[]).run(&grid(50.0, 20_000));
    assert_eq!(run.modes[run.modes.len() - 3..], [0, 0, 0]);
    let end = &run.states[run.states.len() - 3..];
    assert!(end.iter().all(|v| v.abs() < 1e-15), "{end:?} while stuck");
}

/// Three blocks on top of each other, at rest: which contacts stick, against a search through all
/// combinations of modes.
#[test]
fn coupled_contacts_find_the_one_consistent_combination() {
    let states = [
        ("y1", 0.0, "(p1 - f1*sgn(y1) - f2*sgn(y1-y2))/m1"),
        ("y2", 0.0, "(p2 + f2*sgn(y1-y2) - f3*sgn(y2-y3))/m2"),
        ("y3", 0.0, "(p3 + f3*sgn(y2-y3))/m3"),
    ];
    // A small generator of uniform numbers: no two cases alike, the same in every run.
    let mut seed = 1_u64;
    let mut uniform = |low: f64, high: f64| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * (seed >> 11) as f64 / (1_u64 << 53) as f64
    };
    let names = ["p1", "p2", "p3", "f1", "f2", "f3", "m1", "m2", "m3"];
    let mut case = Case::new(&states, &names.map(|n| (n, 1.0)));
    let order: Vec<usize> = ["y1", "y1 - y2", "y2 - y3"]
        .iter()
        .map(|text| case.automaton.switches.iter().position(|s| s.text == *text).unwrap())
        .collect();
    let mut kinds = std::collections::BTreeSet::new();
    for _ in 0..2000 {
        let load: [f64; 3] = std::array::from_fn(|_| uniform(-2.0, 2.0));
        let hold: [f64; 3] = std::array::from_fn(|_| uniform(0.1, 1.0));
        let mass: [f64; 3] = std::array::from_fn(|_| uniform(0.3, 3.0));
        case.parameters = [load, hold, mass].concat();
        let modes = case.run(&[0.0]).modes;
        let got = [modes[order[0]], modes[order[1]], modes[order[2]]];
        let consistent: Vec<[i8; 3]> = (0..27)
            .map(|k| [k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1])
            .filter(|modes| fits(modes, &load, &hold, &mass))
            .collect();
        assert_eq!(consistent, [got], "load {load:?}, holds {hold:?}, masses {mass:?}");
        kinds.insert(got);
    }
    assert!(kinds.len() > 20, "{kinds:?}");
}

/// Whether these modes of the three blocks agree with the rates that they lead to.
fn fits(modes: &[i8; 3], load: &[f64; 3], hold: &[f64; 3], mass: &[f64; 3]) -> bool {
    // Groups that stick together move as one; the ground has no rate. From the top downwards.
    let mut rate = [0.0; 3];
    let forces: [f64; 3] = std::array::from_fn(|c| f64::from(modes[c]) * hold[c]);
    let mut first = 0;
    while first < 3 {
        let last = (first..3).find(|&j| j == 2 || modes[j + 1] != 0).unwrap();
        let push: f64 = load[first..=last].iter().sum();
        let below = if first == 0 { -forces[0] } else { forces[first] };
        let above = if last == 2 { 0.0 } else { forces[last + 1] };
        let force = push + below - above;
        let grounded = first == 0 && modes[0] == 0;
        let common = if grounded { 0.0 } else { force / mass[first..=last].iter().sum::<f64>() };
        rate[first..=last].fill(common);
        first = last + 1;
    }
    // What each contact bears, from the top block down.
    let mut bears = [0.0; 3];
    bears[2] = mass[2] * rate[2] - load[2];
    bears[1] = mass[1] * rate[1] - load[1] + bears[2];
    bears[0] = load[0] - mass[0] * rate[0] - bears[1];
    let relative = [rate[0], rate[0] - rate[1], rate[1] - rate[2]];
    (0..3).all(|c| match modes[c] {
        0 => bears[c].abs() <= hold[c],
        mode => f64::from(mode) * relative[c] > 0.0,
    })
}

/// What the input was before the run is not felt in it.
#[test]
fn a_force_that_jumps_at_the_start_acts_from_there() {
    let force = signal(&[-1.0, 0.0, 5.0], |t| if t < 0.0 { 0.0 } else { 2.0 }, Interpolation::Hold);
    let case = Case::driven(&[("v", 0.0, "u - F*sgn(v)")], &[("F", 0.5)], vec![("u", force)]);
    let run = case.run(&[0.0, 1.0]);
    assert_eq!((run.modes[0], run.rates[0]), (1, 1.5));
    assert_abs_diff_eq!(run.states[1], 1.5, epsilon = 1e-12);
    assert!(run.events.is_empty(), "{:?}", run.events);
}

/// A double holds the time since 1970 to a quarter of a microsecond; steps behind a turn are shorter.
#[test]
fn a_motion_does_not_depend_on_the_origin_of_time() {
    let states = [("x", 2e-3, "v"), ("v", 0.0, "P - k*x - F*(1 + exp(-|v|/c))*sgn(v)")];
    let times = grid(1.0, 200);
    let motion = |origin: f64| {
        let at = |times: &[f64]| times.iter().map(|t| origin + t).collect::<Vec<f64>>();
        let level = |t: f64| if (0.25..0.55).contains(&(t - origin)) { -3.0 } else { 2.0 };
        let force = signal(&at(&[0.0, 0.3, 0.6, 0.9]), level, Interpolation::Hold);
        let constants = [("k", 2500.0), ("F", 0.3), ("c", 2e-3)];
        let case = Case::driven(&states, &constants, vec![("P", force)]).tolerance(1e-9);
        let drive = Drive { inputs: &case.inputs, parameters: &case.parameters };
        simulate(&case.automaton, &drive, origin, &case.start, &at(&times), &case.options).unwrap()
    };
    let first = motion(0.0);
    for origin in [0.1, -7.3, 1.7e9] {
        let run = motion(origin);
        assert_eq!(story(&run), story(&first), "{origin}");
        // A quarter of a microsecond at the speed of the motion, 0.1 m/s, and again at each step of the force.
        for (k, (x, y)) in run.states.iter().zip(&first.states).enumerate() {
            let size = if k % 2 == 0 { 1e-7 } else { 1e-5 };
            assert_abs_diff_eq!(x, y, epsilon = if origin.abs() < 1e3 { 1e-9 } else { size });
        }
    }
}
