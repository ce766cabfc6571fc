//! Impacts against closed forms, conservation laws, and differences of runs.

use approx::assert_relative_eq;
use phisindy_phys::{Model, SourceId, check, spec};
use phisindy_signal::{Interpolation, Signal};
use phisindy_sim::{Automaton, Drive, Options, Trajectory, simulate};

const G: f64 = 9.81;

/// A run with this tolerance, sampled evenly; derivatives by all parameters if asked for.
fn run(
    model: &Model,
    (inputs, parameters): (&[Signal], &[f64]),
    start: &[f64],
    (duration, samples): (f64, usize),
    sensitivities: bool,
) -> Trajectory {
    let automaton = Automaton::new(model).expect("an automaton");
    let times: Vec<f64> = (0..=samples).map(|k| duration * k as f64 / samples as f64).collect();
    let options = Options {
        tolerance: 1e-11,
        sensitivities: sensitivities.then(|| (0..parameters.len()).collect()),
        ..Options::default()
    };
    simulate(&automaton, &Drive { inputs, parameters }, 0.0, start, &times, &options).expect("a run")
}

/// A ball that falls on a floor, with this drag.
fn ball_in(drag: &str) -> Model {
    let rate = format!("-9.81 - {drag}");
    let model = Model::build(&["z", "v"], &[], &["e", "c"], &["v", &rate]).expect("a model");
    model.rebounding("z", "e", &[(1, "1")]).expect("an impact")
}

fn ball() -> Model {
    ball_in("c*|v|*v")
}

#[test]
fn bounces_are_those_of_the_closed_form_and_end_after_its_time() {
    for e in [0.85, 0.5, 0.0] {
        let run = run(&ball(), (&[], &[e, 0.0]), &[2.0, 0.0], (10.0, 2000), false);
        let first = (2.0 * 2.0 / G).sqrt();
        // Flights of 2 e^k v0/g.
        let (mut begin, mut speed, mut k) = (first, e * G * first, 0);
        for i in 0..run.samples() {
            let t = 0.005 * i as f64;
            while t > begin + 2.0 * speed / G && speed > 1e-7 {
                begin += 2.0 * speed / G;
                speed *= e;
                k += 1;
            }
            let since = t - begin;
            let due = match t < first {
                true => 2.0 - 0.5 * G * t * t,
                false => (speed * since - 0.5 * G * since * since).max(0.0),
            };
            assert!((run.states[2 * i] - due).abs() < 1e-8, "e {e} t {t}: {} not {due}", run.states[2 * i]);
        }
        let last = run.hits.last().expect("an impact");
        assert!(last.rests && run.hits.iter().filter(|hit| hit.rests).count() == 1);
        assert_relative_eq!(last.time, first * (1.0 + e) / (1.0 - e), max_relative = 1e-6);
        assert!(e == 0.0 || k > 15);
        assert_eq!(run.states[2 * 2000..], [0.0, 0.0]);
    }
}

/// Steps of Runge and Kutta of a ten-thousandth of a second, halved to the time of the impact.
fn independent_bounces(e: f64, c: f64, duration: f64) -> (Vec<f64>, [f64; 2]) {
    let rate = |x: [f64; 2]| [x[1], -G - c * x[1].abs() * x[1]];
    let step = |x: [f64; 2], h: f64| {
        let at = |k: [f64; 2], part: f64| [x[0] + part * h * k[0], x[1] + part * h * k[1]];
        let a = rate(x);
        let b = rate(at(a, 0.5));
        let d = rate(at(b, 0.5));
        let f = rate(at(d, 1.0));
        [0, 1].map(|i| x[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * d[i] + f[i]))
    };
    let (mut t, mut x, mut times) = (0.0, [1.5, 0.3], vec![]);
    while t < duration {
        let h = 1e-4_f64.min(duration - t);
        let next = step(x, h);
        if next[0] >= 0.0 {
            (t, x) = (t + h, next);
            continue;
        }
        let (mut low, mut high) = (0.0, h);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if step(x, middle)[0] > 0.0 { low = middle } else { high = middle }
        }
        x = step(x, low);
        t += low;
        times.push(t);
        x = [0.0, -e * x[1]];
    }
    (times, x)
}

#[test]
fn bounces_with_drag_are_those_of_an_independent_integrator() {
    let (times, end) = independent_bounces(0.85, 0.12, 3.0);
    let run = run(&ball(), (&[], &[0.85, 0.12]), &[1.5, 0.3], (3.0, 30), false);
    assert_eq!(run.hits.len(), times.len());
    for (hit, due) in run.hits.iter().zip(&times) {
        assert!((hit.time - due).abs() < 1e-9, "{} not {due}", hit.time);
    }
    assert!(times.len() >= 3);
    let own = &run.states[60..];
    assert!((own[0] - end[0]).abs() < 1e-9 && (own[1] - end[1]).abs() < 1e-8, "{own:?} not {end:?}");
}

/// Every derivative against differences, where the number of impacts before a sample is the same.
fn derivatives_hold(
    model: &Model,
    inputs: &[Signal],
    (parameters, start): (&[f64], &[f64]),
    duration: f64,
    fewest: usize,
) {
    let of = |p: &[f64], x: &[f64], with: bool| run(model, (inputs, p), x, (duration, 400), with);
    let with = of(parameters, start, true);
    // The same bits without derivatives.
    assert_eq!(of(parameters, start, false).states, with.states);
    let eps = 1e-5;
    let mut compared = 0;
    for j in 0..with.m {
        let moved = |by: f64| {
            let (mut p, mut x) = (parameters.to_vec(), start.to_vec());
            match j.checked_sub(start.len()) {
                None => x[j] += by,
                Some(k) => p[k] += by,
            }
            of(&p, &x, false)
        };
        let (up, down) = (moved(eps), moved(-eps));
        let before = |r: &Trajectory, t: f64| r.hits.iter().filter(|hit| hit.time <= t).count();
        for i in 0..with.samples() {
            let t = duration * i as f64 / 400.0;
            let count = before(&with, t);
            if before(&up, t) != count || before(&down, t) != count {
                continue;
            }
            for k in 0..with.n {
                let at = i * with.n + k;
                let due = (up.states[at] - down.states[at]) / (2.0 * eps);
                let own = with.sensitivities[at * with.m + j];
                assert!((own - due).abs() < 3e-5 * due.abs().max(1.0), "t {t}, {k} by {j}: {own} not {due}");
                compared += usize::from(count > 0);
            }
        }
    }
    assert!(compared > fewest, "{compared}");
}

#[test]
fn derivatives_by_restitution_start_and_drag_are_those_of_runs() {
    let ball = ball_in("c*v");
    derivatives_hold(&ball, &[], (&[0.85, 0.12], &[1.5, 0.3]), 3.0, 2000);
    // To rest and beyond.
    derivatives_hold(&ball, &[], (&[0.5, 0.05], &[1.0, 0.0]), 3.0, 2000);
}

/// A floor that a shaker moves.
fn shaken() -> (Model, Signal) {
    let model = Model::build(&["z", "v"], &["u"], &["e", "a", "c"], &["v", "-9.81 - c*v"]).expect("a model");
    let time: Vec<f64> = (0..=1000).map(|k| 0.004 * f64::from(k)).collect();
    let u = time.iter().map(|t| (7.0 * t).sin()).collect();
    let u = Signal::new(time.into(), u, Interpolation::Cubic).expect("a signal");
    (model.rebounding("z - a*u", "e", &[(1, "1")]).expect("an impact"), u)
}

#[test]
fn a_moving_floor_counts_in_the_closing_speed() {
    let (model, u) = shaken();
    let run = run(&model, (&[u], &[0.7, 0.1, 0.0]), &[0.5, 0.0], (3.0, 3000), false);
    let floor = |t: f64| 0.7 * (7.0 * t).cos();
    assert!(run.hits.len() > 5);
    for (k, (jump, hit)) in run.jumps.iter().zip(&run.hits).enumerate() {
        if k > 0 && hit.time - run.hits[k - 1].time < 2e-3 {
            continue;
        }
        let i = (hit.time * 1000.0).floor() as usize;
        let before = run.states[2 * i + 1] - G * (hit.time - 0.001 * i as f64);
        let closing = before - floor(hit.time);
        assert!((hit.speed + closing).abs() < 1e-6, "{hit:?} {closing}");
        assert!((jump.by[1] + 1.7 * closing).abs() < 1e-5, "{jump:?} {closing}");
    }
    derivatives_hold(&model, &[shaken().1], (&[0.7, 0.1, 0.1], &[0.5, 0.0]), 2.0, 1500);
}

#[test]
fn a_body_at_rest_on_a_shaker_lets_go_where_the_floor_would_have_to_pull() {
    let (model, u) = shaken();
    // a W^2 = 1.5 g: the floor falls faster than the body from sin(W t) = 2/3 on.
    let a = 1.5 * G / 49.0;
    let run =
        run(&model, (std::slice::from_ref(&u), &[0.0, a, 0.0]), &[0.0, a * u.slope(0.0)], (2.0, 4000), false);
    let lifts = (2.0_f64 / 3.0).asin() / 7.0;
    let (z0, v0) = (a * 2.0 / 3.0, 7.0 * a * (7.0 * lifts).cos());
    let flight = |t: f64| z0 + v0 * (t - lifts) - 0.5 * G * (t - lifts).powi(2);
    let (mut low, mut high) = (lifts + 0.1, lifts + 0.8);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if flight(middle) > a * (7.0 * middle).sin() { low = middle } else { high = middle }
    }
    for i in 0..run.samples() {
        let t = 0.0005 * i as f64;
        let due = if t > lifts && t < low { flight(t) } else { a * u.value(t) };
        if t < low + 0.05 {
            assert!((run.states[2 * i] - due).abs() < 1e-7, "t {t}: {} not {due}", run.states[2 * i]);
        }
    }
    let landing = run.hits.iter().find(|hit| hit.time > 0.01).expect("a landing");
    assert!((landing.time - low).abs() < 1e-7 && landing.rests, "{landing:?}, not {low}");
    // It lifts again and again; the derivatives go along.
    assert!(run.hits.iter().filter(|hit| hit.rests).count() >= 2, "{:?}", run.hits);
    derivatives_hold(&model, &[u], (&[0.0, a, 0.0], &[0.001, 7.0 * a]), 1.8, 400);
}

/// The model of a spec, and its run.
fn of_spec(text: &str, start: &[f64], duration: f64) -> Trajectory {
    let (spec, _) = spec::read_without_data(text, SourceId(0)).unwrap_or_else(|e| panic!("{e:?}"));
    let (case, _) = check(&spec, SourceId(0)).unwrap_or_else(|e| panic!("{e:?}"));
    let model = case.system.model(&[]);
    let numbers: Vec<f64> = case.system.parameters.iter().map(|p| p.start).collect();
    run(&model, (&[], &numbers), start, (duration, 1000), false)
}

#[test]
fn two_bodies_that_hit_each_other_keep_their_momentum() {
    let text = r#"(states: { "x1": "m", "v1": "m/s", "x2": "m", "v2": "m/s" },
        constants: { "m1": (1.0, "kg"), "m2": (3.0, "kg"), "d": (0.2, "m") },
        known: { "x1": "v1", "v1": "0", "x2": "v2", "v2": "0" }, inertia: { "v1": "m1", "v2": "m2" },
        impacts: { "cars": (when: "x2 - x1 - d", restitution: Find(start: 0.6, within: (0.0, 1.0))) })"#;
    let run = of_spec(text, &[0.0, 2.0, 1.0, -0.5], 2.0);
    let end = &run.states[4 * 1000..];
    assert_eq!(run.hits.len(), 1);
    assert_relative_eq!(run.hits[0].speed, 2.5, max_relative = 1e-12);
    assert_relative_eq!(end[1] + 3.0 * end[3], 2.0 - 1.5, max_relative = 1e-12);
    assert_relative_eq!(end[3] - end[1], 0.6 * 2.5, max_relative = 1e-12);
}

/// A cart with a hanging load hits a wall: along the other coordinate there is no impulse.
#[test]
fn an_impulse_goes_through_the_mass_matrix() {
    let text = r#"(constants: { "M": (2.0, "kg"), "m": (1.0, "kg"), "l": (0.5, "m"), "g": (9.81, "m/s^2") },
        energy: (coordinates: { "x": ("v", "m"), "th": ("w", "rad") },
            kinetic: "(M + m)*v^2/2 + m*l*v*w*cos(th) + m*(l*w)^2/2", potential: "-m*g*l*cos(th)"),
        impacts: { "wall": (when: "1.0 - x", restitution: 0.4) })"#;
    let run = of_spec(text, &[0.0, 2.0, 0.4, 0.3], 0.8);
    let (jump, hit) = (&run.jumps[0], run.hits[0]);
    let i = (hit.time / 0.0008).floor() as usize;
    let th = run.states[4 * i + 2] + (hit.time - 0.0008 * i as f64) * run.states[4 * i + 3];
    assert_relative_eq!(jump.by[1], -1.4 * hit.speed, max_relative = 1e-9);
    // m l cos(th) dv + m l^2 dw = 0
    assert_relative_eq!(jump.by[3], -th.cos() / 0.5 * jump.by[1], max_relative = 1e-5);
    assert!(jump.by[0] == 0.0 && jump.by[2] == 0.0);
}

/// What a force cell and an accelerometer read while a body rests on a floor.
#[test]
fn outputs_read_the_reaction() {
    let text = r#"(states: { "z": "m", "v": "m/s" }, constants: { "g": (9.81, "m/s^2") }, known: { "z": "v", "v": "-g" },
        outputs: { "a": (unit: "m/s^2", reads: "rate(v) + g") }, impacts: { "floor": (when: "z", restitution: 0.3) })"#;
    let run = of_spec(text, &[0.5, 0.0], 2.0);
    assert!(run.states[2].abs() < 1e-12, "it falls freely: {}", run.states[2]);
    assert_relative_eq!(run.states[3 * 1000 + 2], 9.81, max_relative = 1e-12);
}

/// A slider with dry friction is pressed against a stop, and pulled off again.
#[test]
fn friction_and_a_stop_at_the_same_speed_do_not_both_hold() {
    let model = Model::build(&["x", "v"], &["u"], &["e"], &["v", "u - 2*sgn(v)"]).expect("a model");
    let model = model.rebounding("x", "e", &[(1, "1")]).expect("an impact");
    let time: Vec<f64> = (0..=400).map(|k| 0.01 * f64::from(k)).collect();
    // Pressed by 5, then by 1, which friction holds, then pulled by 1, which it holds too, then by 6.
    let push = time.iter().map(|t| [-5.0, -1.0, 1.0, 6.0][(*t as usize).min(3)]).collect();
    let u = Signal::new(time.into(), push, Interpolation::Hold).expect("a signal");
    for e in [0.0, 0.5] {
        let run = run(&model, (std::slice::from_ref(&u), &[e]), &[0.3, 0.0], (4.0, 400), false);
        let x = |t: f64| run.states[2 * (t * 100.0) as usize];
        assert!([0.9, 1.9, 2.9].iter().all(|t| x(*t).abs() < 1e-12), "{e}: {} {} {}", x(0.9), x(1.9), x(2.9));
        assert_relative_eq!(x(4.0), 0.5 * 4.0, max_relative = 1e-6);
    }
}

/// A start beyond the floor, as noise makes it, is no trap.
#[test]
fn a_run_that_begins_beyond_the_floor_goes_on() {
    let model = ball();
    let of = |z: f64, v: f64| run(&model, (&[], &[0.8, 0.0]), &[z, v], (3.0, 300), false);
    // It moves on down: it rebounds at once. It comes out, and bounces as ever.
    for v in [-3.0, 3.0] {
        let run = of(-1e-3, v);
        let highest = run.column(0).into_iter().fold(0.0, f64::max);
        let due = if v < 0.0 { (0.8 * v).powi(2) } else { v * v } / (2.0 * G) - 1e-3;
        assert!((highest - due).abs() < 1e-3, "{v}: {highest} not {due}");
        assert!(run.states[600].abs() < 1e-9 || run.states[600] > 0.0);
    }
    // Too slow to come out it rests there.
    let run = of(-1e-3, 0.01);
    assert!(run.states[600] < 0.0 && run.states[601] == 0.0, "{:?}", &run.states[600..]);
}
