//! Motions with a closed form.

use crate::common::{Case, grid};
use approx::assert_abs_diff_eq;
use std::f64::consts::PI;

/// Free decay with Coulomb friction: each half cycle takes 2 F/k off the amplitude; it stops at the first
/// turning point within F/k of zero.
#[test]
fn free_decay_loses_4_f_over_k_per_cycle_and_stops_where_it_must() {
    let (k, f) = (4.0, 0.3);
    let case = Case::new(&[("x", 1.0, "v"), ("v", 0.0, "-k*x - F*sgn(v)")], &[("k", k), ("F", f)]);
    let turns: Vec<f64> = (0..=7).map(|j| f64::from(j) * PI / k.sqrt()).collect();
    let run = case.run(&[turns.clone(), vec![15.0, 200.0]].concat());
    let mut sign = 1.0;
    for j in 0..=7 {
        let amplitude = 1.0 - j as f64 * 2.0 * f / k;
        assert_abs_diff_eq!(run.states[2 * j], sign * amplitude, epsilon = 1e-9);
        sign = -sign;
    }
    // Six reversals without a stop, then the stop at 0.05 < F/k = 0.075.
    assert_eq!(run.events.len(), 7, "{:?}", run.events);
    for (event, turn) in run.events.iter().zip(&turns[1..]) {
        assert_abs_diff_eq!(event.time, *turn, epsilon = 1e-9);
    }
    assert_eq!(run.events[6].to, 0);
    assert!(run.events[..6].iter().all(|e| e.from == -e.to));
    for sample in 8..10 {
        assert_eq!(run.states[2 * sample], run.states[2 * 9], "it stays where it is");
        assert_eq!(run.states[2 * sample + 1], 0.0);
    }
}

#[test]
fn block_on_a_table_with_viscous_drag() {
    let (mu, c, v0) = (0.7, 0.4, 3.0);
    let case = Case::new(&[("x", 0.0, "v"), ("v", v0, "-mu*sgn(v) - c*v")], &[("mu", mu), ("c", c)]);
    let stop = (1.0 + c * v0 / mu).ln() / c;
    let run = case.run(&[1.0, stop, 50.0]);
    assert_abs_diff_eq!(run.events[0].time, stop, epsilon = 1e-10);
    assert_abs_diff_eq!(run.states[1], (v0 + mu / c) * (-c).exp() - mu / c, epsilon = 1e-10);
    assert_abs_diff_eq!(run.states[4], v0 / c - mu / c * stop, epsilon = 1e-10);
    assert_eq!(run.states[5], 0.0);
    assert_eq!(run.events.len(), 1);
}

#[test]
fn block_on_a_table_with_quadratic_drag() {
    let (mu, d, v0) = (0.7_f64, 0.2_f64, 3.0);
    let case = Case::new(&[("x", 0.0, "v"), ("v", -v0, "-mu*sgn(v) - d*v*|v|")], &[("mu", mu), ("d", d)]);
    let stop = (v0 * (d / mu).sqrt()).atan() / (mu * d).sqrt();
    let run = case.run(&[stop, 20.0]);
    assert_abs_diff_eq!(run.events[0].time, stop, epsilon = 1e-10);
    assert_abs_diff_eq!(run.states[2], -(1.0 + d * v0 * v0 / mu).ln() / (2.0 * d), epsilon = 1e-10);
    assert_eq!(run.events.len(), 1);
}

/// A block on a belt with static friction `Fs` and kinetic friction `Fk` (R. A. Ibrahim 1994). It sticks for
/// `2 (Fs - Fk)/(k vb)`. Then it slips along a circle about `Fk/k`.
#[test]
fn a_block_that_breaks_away_sticks_and_slips_by_the_book() {
    let (fs, fk, vb) = (1.0, 0.6, 0.5);
    let states = [("x", 0.0, "v"), ("v", vb, "-x - (Fk + (Fs - Fk)*rest(v - vb))*sgn(v - vb)")];
    let case = Case::new(&states, &[("Fs", fs), ("Fk", fk), ("vb", vb)]);
    let run = case.run(&[1.0, 60.0]);
    // It lets go where the spring takes Fs, for the first time after Fs/vb.
    let (first, stick) = (fs / vb, 2.0 * (fs - fk) / vb);
    // The speed is vb at both ends of the slip.
    let slip = 2.0 * (PI - ((fs - fk) / vb).atan());
    let ends = (0..).flat_map(|k| {
        let start = first + f64::from(k) * (slip + stick);
        [start, start + slip]
    });
    assert!(run.events.len() > 15, "{:?}", run.events);
    for (event, due) in run.events.iter().zip(ends) {
        assert_abs_diff_eq!(event.time, due, epsilon = 1e-8);
    }
    assert_abs_diff_eq!(run.states[0], vb, epsilon = 1e-12);
}

/// With Fs = Fd the slip touches the belt speed once a period and goes on: a circle about x = F/k.
#[test]
fn coulomb_on_a_belt_ends_on_the_circle_that_grazes_the_belt_speed() {
    let states = [("x", 3.0, "v"), ("v", 0.0, "-x - F*sgn(v - vb)")];
    let case = Case::new(&states, &[("F", 1.0), ("vb", 0.5)]);
    let stop = PI + 0.25_f64.asin();
    let at_stop = 1.0 - 2.0 * (1.0_f64 - 1.0 / 16.0).sqrt();
    let leave = stop + (1.0 - at_stop) / 0.5;
    let times = grid(60.0, 600);
    let run = case.run(&times);
    assert_abs_diff_eq!(run.events[0].time, stop, epsilon = 1e-9);
    assert_abs_diff_eq!(run.events[1].time, leave, epsilon = 1e-9);
    for (k, &t) in times.iter().enumerate() {
        let x = match t {
            t if t < stop => 1.0 + 2.0 * t.cos(),
            t if t < leave => at_stop + 0.5 * (t - stop),
            t => 1.0 + 0.5 * (t - leave).sin(),
        };
        assert_abs_diff_eq!(run.states[2 * k], x, epsilon = 1e-8);
        if t > stop && t < leave {
            assert_abs_diff_eq!(run.states[2 * k + 1], 0.5, epsilon = 1e-15);
        }
    }
}

/// STYLE.md, "Stick-slip measured": F_s = 1.5, F_d = 1 gives a slip of 3 pi/2 and a period of 2 + 3 pi/2. The
/// fall from static to sliding friction happens within `vs` here. After letting go, w' = a t + (w/vs)^2/2
/// first has to grow: that takes a time in proportion to vs^(2/3), and so the times converge.
#[test]
fn static_friction_on_a_belt_converges_to_the_closed_form() {
    let states = [("x", 0.0, "v"), ("v", 0.5, "-x - (1 + 0.5*exp(-((v-vb)/vs)^2))*sgn(v - vb)")];
    for vs in [1e-3_f64, 1e-5, 1e-7, 1e-9] {
        let case = Case::new(&states, &[("vb", 0.5), ("vs", vs)]);
        let run = case.run(&grid(40.0, 40));
        let stops: Vec<f64> = run.events.iter().filter(|e| e.to == 0).map(|e| e.time).collect();
        let leaves: Vec<f64> = run.events.iter().filter(|e| e.from == 0).map(|e| e.time).collect();
        assert!(leaves.len() >= 5, "{:?}", run.events);
        let off = |got: f64, want: f64| (got - want).abs();
        let mut worst = off(leaves[0], 3.0);
        for j in 0..4 {
            worst = worst
                .max(off(stops[j] - leaves[j], 1.5 * PI))
                .max(off(leaves[j + 1] - leaves[j], 2.0 + 1.5 * PI));
        }
        assert!(worst < 4.0 * vs.powf(2.0 / 3.0) + 1e-8, "vs = {vs}: {worst}");
        assert!(run.steps + run.rejected < 2500, "{} + {}", run.steps, run.rejected);
    }
}

/// The error of an undamped oscillator falls with the fifth power of the number of steps, and that of its
/// rates, by the interpolant, with the fourth.
#[test]
fn the_method_has_order_five() {
    let times = grid(20.0, 199);
    let result = |tolerance: f64| {
        let case = Case::new(&[("x", 1.0, "v"), ("v", 0.0, "-x")], &[]).tolerance(tolerance);
        let run = case.run(&times);
        let worst = |column: &[f64], exact: &dyn Fn(f64) -> f64| -> f64 {
            times.iter().zip(column).map(|(t, x)| (x - exact(*t)).abs()).fold(0.0, f64::max)
        };
        let rate: Vec<f64> = run.rates.iter().skip(1).step_by(2).copied().collect();
        (run.steps as f64, worst(&run.column(0), &f64::cos), worst(&rate, &|t| -t.cos()))
    };
    let ((n1, x1, f1), (n2, x2, f2)) = (result(1e-6), result(1e-10));
    let order = |coarse: f64, fine: f64| (coarse / fine).ln() / (n2 / n1).ln();
    assert!((4.6..5.6).contains(&order(x1, x2)), "order {}: {x1:e} {x2:e}", order(x1, x2));
    assert!((3.6..5.6).contains(&order(f1, f2)), "order {}: {f1:e} {f2:e}", order(f1, f2));
    assert!(x2 < 1e-8 && f2 < 1e-7, "{x2:e} {f2:e}");
}
