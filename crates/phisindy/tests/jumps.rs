//! Impacts and sampled controllers from data of other integrators to numbers with intervals.
#![allow(missing_docs)]

use phisindy::{Case, Options, identify};

/// One step of Runge and Kutta.
fn step<const N: usize>(rate: &dyn Fn([f64; N]) -> [f64; N], x: [f64; N], h: f64) -> [f64; N] {
    let at = |k: [f64; N], part: f64| std::array::from_fn(|i| x[i] + part * h * k[i]);
    let a = rate(x);
    let b = rate(at(a, 0.5));
    let c = rate(at(b, 0.5));
    let d = rate(at(c, 1.0));
    std::array::from_fn(|i| x[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]))
}

/// Numbers as noise makes them: the sum of twelve of a simple generator.
fn noise(state: &mut u64) -> f64 {
    let mut next = || {
        *state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (*state >> 11) as f64 / (1u64 << 53) as f64
    };
    (0..12).map(|_| next()).sum::<f64>() - 6.0
}

/// A ball with drag, sampled every 5 ms by a camera with noise of half a millimetre.
fn ball(restitution: f64, drag: f64) -> (Vec<f64>, Vec<f64>) {
    let rate = |x: [f64; 2]| [x[1], -9.81 - drag * x[1].abs() * x[1]];
    let (mut x, mut seed) = ([1.5, 0.2], 7);
    let (mut t, mut z) = (vec![], vec![]);
    for k in 0..800 {
        t.push(0.005 * f64::from(k));
        z.push(x[0] + 5e-4 * noise(&mut seed));
        for _ in 0..50 {
            let next = step(&rate, x, 1e-4);
            if next[0] >= 0.0 {
                x = next;
                continue;
            }
            let (mut low, mut high) = (0.0, 1e-4);
            for _ in 0..50 {
                let middle = 0.5 * (low + high);
                if step(&rate, x, middle)[0] > 0.0 { low = middle } else { high = middle }
            }
            let hit = step(&rate, x, low);
            x = step(&rate, [0.0, -restitution * hit[1]], 1e-4 - low);
            if x[0] < 0.0 {
                x = [0.0, 0.0];
            }
        }
    }
    (t, z)
}

#[test]
fn restitution_and_drag_are_found_in_the_bounces_of_a_ball() {
    let text = r#"(states: { "z": "m", "v": "m/s" }, constants: { "g": (9.81, "m/s^2") }, known: { "z": "v", "v": "-g" },
        unknown: { "v": (factor: "-1", candidates: ["v", "|v|*v"]) },
        impacts: { "floor": (when: "z", restitution: Find(start: 0.7, within: (0.0, 1.0))) })"#;
    let case = Case::read(text).expect("a spec");
    let (t, z) = ball(0.85, 0.06);
    let found =
        identify(&case, &[case.record(&[("t", &t), ("z", &z)]).expect("a record")], &Options::default());
    let found = found.expect("a result");
    let [drag] = &found.terms()[..] else { panic!("{:?}", found.terms()) };
    assert_eq!(drag.candidate, "|v|*v");
    let e =
        found.parameters().iter().find(|p| p.id.to_string() == "floor.restitution").expect("a restitution");
    for (what, of, due) in [("drag", &drag.coefficient, 0.06), ("e", &e.estimate, 0.85)] {
        assert!(of.ci95.0 <= due && due <= of.ci95.1, "{what}: {of:?}");
    }
    assert!(e.estimate.std_error < 1e-3, "{:?}", e.estimate);
}

/// A carriage under a PID with a period of 10 ms, a saturation of 20 N and a computation delay of 2 ms.
fn carriage(kp: f64, ki: f64, kd: f64) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let (mut x, mut last, mut sum, mut force, mut seed) = ([0.0, 0.0], 0.0, 0.0, 0.0, 11);
    let (mut t, mut position, mut reference) = (vec![], vec![], vec![]);
    let wish = |t: f64| 0.03 * (2.0 * t).sin() + 0.02 * (7.3 * t).sin();
    for k in 0..500 {
        let begin = 0.01 * f64::from(k);
        let error = wish(begin) - x[0];
        let next = (kp * error + ki * sum - kd * (x[0] - last) / 0.01).clamp(-20.0, 20.0);
        (last, sum) = (x[0], sum + 0.01 * error);
        if k == 0 {
            force = next;
        }
        for part in 0..5 {
            t.push(begin + 0.002 * f64::from(part));
            position.push(x[0] + 2e-5 * noise(&mut seed));
            reference.push(wish(t[t.len() - 1]));
            if part == 1 {
                force = next;
            }
            let rate = |x: [f64; 2]| [x[1], (force - 3.0 * x[1]) / 1.5];
            (0..20).for_each(|_| x = step(&rate, x, 1e-4));
        }
    }
    (t, position, reference)
}

#[test]
fn the_gains_of_a_sampled_controller_are_found() {
    let text = r#"(states: { "x": "m", "v": "m/s", "i": "m*s" }, inputs: { "r": "m" },
        constants: { "m": (1.5, "kg"), "c": (3.0, "N*s/m"), "T": (10.0, "ms"),
            "Kp": Find(start: 300.0, unit: "N/m", within: (100.0, 900.0)), "Ki": Find(start: 500.0, unit: "N/(m*s)", within: (0.0, 4000.0)),
            "Kd": Find(start: 20.0, unit: "N*s/m", within: (1.0, 60.0)) },
        let: { "u": "hold(min(max(Kp*(r - x) + Ki*i - Kd*(x - hold(x, T))/T, -20), 20), T, 0.002)" },
        known: { "x": "v", "v": "(u - c*v)/m", "i": "hold(r - x, T)" }, unknown: {})"#;
    let case = Case::read(text).expect("a spec");
    let (t, x, r) = carriage(400.0, 900.0, 25.0);
    let found = identify(
        &case,
        &[case.record(&[("t", &t), ("x", &x), ("r", &r)]).expect("a record")],
        &Options::default(),
    );
    let found = found.expect("a result");
    for (name, due) in [("Kp", 400.0), ("Ki", 900.0), ("Kd", 25.0)] {
        let own = found.parameters().iter().find(|p| p.id.to_string() == name).expect("a gain");
        let e = &own.estimate;
        assert!((e.value - due).abs() < 3.0 * e.std_error, "{name}: {e:?}");
        assert!(e.std_error < 0.05 * due, "{name}: {e:?}");
    }
}
