//! Stiff rates against closed forms, published solutions and another solver, and how much work they are.

use crate::common::{self, Case, grid};
use ode_solvers::{DVector, Dop853, OutputType, System};

#[track_caller]
fn near(got: f64, want: f64, accuracy: f64) {
    assert!((got - want).abs() <= accuracy * want.abs(), "{got:e} instead of {want:e}");
}

/// Van der Pol's oscillator with mu = 1000, over a period and a half. The solution is that of the test set
/// for initial value problems (F. Mazzia, C. Magherini, Test Set for Initial Value Problem Solvers, release
/// 2.4, 2008), problem VDPOL, whose time is a thousandth of this one.
#[test]
fn van_der_pol() {
    let rate = "mu*(1 - x^2)*v - x";
    let mut case = Case::new(&[("x", 2.0, "v"), ("v", 0.0, rate)], &[("mu", 1e3)]).tolerance(1e-9);
    case.options.scale = vec![1.0, 1e-3];
    let run = case.run(&[2000.0]);
    near(run.states[0], 1.706167732170483, 1e-6);
    near(run.states[1], -0.8928097010247975e-3, 1e-6);
    assert!(run.implicit > 0 && run.steps + run.rejected < 2_000, "{} {}", run.steps, run.rejected);
}

/// Robertson's reactions, whose rate constants lie nine orders of magnitude apart, at t = 40 (E. Hairer, G.
/// Wanner, Solving Ordinary Differential Equations II, IV.10).
#[test]
fn robertson() {
    let states =
        [("a", 1.0, "-0.04*a + 1e4*b*c"), ("b", 0.0, "0.04*a - 1e4*b*c - 3e7*b^2"), ("c", 0.0, "3e7*b^2")];
    let mut case = Case::new(&states, &[]).tolerance(1e-8);
    case.options.scale = vec![1e-6, 1e-10, 1e-6];
    let run = case.run(&[40.0]);
    near(run.states[0], 0.715_827_068_7, 1e-9);
    near(run.states[1], 0.918_553_476_5e-5, 1e-9);
    near(run.states[2], 0.284_163_745_7, 1e-9);
    assert!(run.implicit > 0 && run.steps + run.rejected < 1_000, "{} {}", run.steps, run.rejected);
}

/// `x' = -L (x - cos(w t))`: the closed form of the state and of its derivatives by L, w and the start.
#[test]
fn a_fast_linear_state_follows_its_closed_form() {
    let (l, w, x0) = (1e5, 3.0, 0.2);
    let case = Case::new(&[("x", x0, "-L*(x - cos(w*t))")], &[("L", l), ("w", w)]).tolerance(1e-11);
    let times = grid(4.0, 300);
    let run = case.run_with_sensitivities(&times);
    assert!(run.implicit > 0 && run.steps < 400, "{} {}", run.steps, run.implicit);
    for (k, t) in times.iter().enumerate().skip(1) {
        let (sin, cos) = (w * t).sin_cos();
        let (n, fading) = (l * l + w * w, (-l * t).exp());
        let exact = (l * l * cos + l * w * sin) / n + (x0 - l * l / n) * fading;
        assert!((run.states[k] - exact).abs() < 1e-10, "{t}: {} {exact}", run.states[k]);
        let by_l = (2.0 * l * cos + w * sin) / n - 2.0 * l * (l * l * cos + l * w * sin) / (n * n);
        let by_w = (-l * l * t * sin + l * sin + l * w * t * cos) / n
            - 2.0 * w * (l * l * cos + l * w * sin) / (n * n);
        for (j, (want, size)) in [(fading, 1.0), (by_l, 1.0 / l), (by_w, 1.0)].into_iter().enumerate() {
            let got = run.sensitivities[k * 3 + j];
            assert!((got - want).abs() < 1e-8 * size, "{t}, {j}: {got:e} {want:e}");
        }
    }
}

/// Two masses whose joint is as good as rigid and dampened: they move as one on the soft spring.
#[test]
fn a_stiff_joint_leaves_the_motion_of_one_body() {
    let joint = "(K*(x1 - x2) + D*(v1 - v2))";
    let first = format!("-k*x1 - {joint}");
    let states = [("x1", 1.0, "v1"), ("v1", 0.0, &*first), ("x2", 1.0, "v2"), ("v2", 0.0, joint)];
    let run = Case::new(&states, &[("k", 1.0), ("K", 1e8), ("D", 1e5)]).tolerance(1e-9).run(&grid(10.0, 100));
    for (k, t) in grid(10.0, 100).iter().enumerate() {
        let exact = (t / 2.0_f64.sqrt()).cos();
        assert!((run.states[4 * k] - exact).abs() < 1e-7, "{t}: {} {exact}", run.states[4 * k]);
    }
    assert!(run.steps < 400 && run.implicit > 0, "{} {}", run.steps, run.implicit);
}

const LUGRE: [(&str, f64); 7] =
    [("m", 1.0), ("k", 300.0), ("s2", 0.4), ("Fc", 1.0), ("Fs", 1.5), ("vs", 0.02), ("A", 4.0)];

/// A LuGre joint on a spring, driven by two sines: stick, creep, slip. C. Canudas de Wit, H. Olsson, K. J.
/// Åström, P. Lischinsky, IEEE Trans. Autom. Control 40 (1995) 419-425, doi:10.1109/9.376053.
fn lugre(bristles: f64) -> Case {
    let rate = "v - s0*abs(v)*z/(Fc + (Fs - Fc)*exp(-(v/vs)^2))";
    let push = "A*sin(6*t) + 0.5*A*sin(9.4*t + 1)";
    let force = format!("({push} - k*x - s0*z - s1*({rate}) - s2*v)/m");
    let states = [("x", 0.0, "v"), ("v", 0.0, &*force), ("z", 0.0, rate)];
    let parameters = [&LUGRE[..], &[("s0", bristles), ("s1", bristles.sqrt())]].concat();
    let mut case = Case::new(&states, &parameters).tolerance(1e-8);
    case.options.scale = vec![0.01, 0.1, 1.0 / bristles];
    case
}

/// The same by hand.
struct Joint(f64);

impl System<f64, DVector<f64>> for Joint {
    fn system(&self, t: f64, x: &DVector<f64>, out: &mut DVector<f64>) {
        let [m, k, s2, fc, fs, vs, a] = LUGRE.map(|(_, value)| value);
        let (s0, s1) = (self.0, self.0.sqrt());
        let level = fc + (fs - fc) * (-(x[1] / vs).powi(2)).exp();
        let slip = x[1] - s0 * x[1].abs() * x[2] / level;
        // The last state is time: the solver has wrong times of the stages.
        let push = a * (6.0 * x[3]).sin() + 0.5 * a * (9.4 * x[3] + 1.0).sin();
        let _ = t;
        out[0] = x[1];
        out[1] = (push - k * x[0] - s0 * x[2] - s1 * slip - s2 * x[1]) / m;
        out[2] = slip;
        out[3] = 1.0;
    }
}

#[test]
fn another_solver_agrees_on_bristles() {
    for bristles in [1e5, 1e6] {
        let run = lugre(bristles).run(&[0.0, 2.0]);
        assert!(run.implicit > 0);
        let start = DVector::from_element(4, 0.0);
        let mut solver = Dop853::from_param(
            Joint(bristles),
            0.0,
            2.0,
            2.0,
            start,
            1e-11,
            1e-16,
            0.9,
            0.0,
            0.333,
            6.0,
            2.0,
            0.0,
            10_000_000,
            u32::MAX,
            OutputType::Sparse,
        );
        solver.integrate().unwrap();
        let want = solver.y_out().last().unwrap();
        for (k, size) in [(0, 0.01), (1, 0.1), (2, 1.0 / bristles)] {
            let got = run.states[3 + k];
            assert!((got - want[k]).abs() < 1e-6 * size, "{bristles}, {k}: {got} {}", want[k]);
        }
    }
}

/// 10,000 samples in 10 s: work does not grow with the stiffness of the bristles. The counters may be lower,
/// and 5 % higher. 80,000 evaluations of these rates are some hundredths of a second.
#[test]
fn stiff_bristles_are_little_work() {
    for (bristles, tries, evaluations, factorisations) in [
        (1e4, 7_004, 42_700, 61),
        (1e5, 8_400, 72_600, 1_980),
        (1e6, 7_440, 77_600, 3_580),
        (1e7, 6_230, 79_800, 4_590),
    ] {
        let run = lugre(bristles).run(&grid(10.0, 10_000));
        let got = (run.steps + run.rejected, run.evaluations, run.factorisations);
        let fits = |got: usize, most: usize| got as f64 <= 1.05 * f64::from(most as u32);
        assert!(
            fits(got.0, tries) && fits(got.1, evaluations) && fits(got.2, factorisations),
            "{bristles:e}: tries, evaluations, factorisations: {got:?}"
        );
    }
}

/// What is not stiff stays with explicit steps: an oscillator at a coarse tolerance, one with a fast mode in
/// its motion, friction that is singular at rest.
#[test]
fn what_is_not_stiff_is_explicit() {
    let oscillator = Case::new(&[("x", 1.0, "v"), ("v", 0.0, "-x")], &[]);
    let states = [("x", 1.0, "v"), ("v", 0.0, "-x - 1e-3*v + cos(50*t)")];
    for tolerance in [1e-3, 1e-4, 1e-6, 1e-8, 1e-10] {
        for case in [oscillator.clone(), Case::new(&states, &[]), common::case_1b(), common::case_7()] {
            let run = case.tolerance(tolerance).run(&grid(50.0, 500));
            assert_eq!((run.implicit, run.factorisations), (0, 0), "{tolerance}");
        }
    }
}

/// Where the stiffness ends, so do the implicit steps.
#[test]
fn explicit_steps_come_back() {
    // The fast state is slow after a second; from then on a fast drive wants short steps.
    let rate = "-(1 + 1e5*step(1 - t))*(x - sin(300*t)*step(t - 1))";
    let run = Case::new(&[("x", 1.0, rate)], &[]).tolerance(1e-8).run(&grid(5.0, 500));
    assert!(run.implicit > 0, "never implicit");
    let after = run.steps - run.implicit;
    assert!(run.implicit < 100 && after > 1_000, "{} implicit, {after} explicit", run.implicit);
}

/// The samples are so dense that no step is long: an implicit one never pays, and the tries are few.
#[test]
fn tries_that_do_not_pay_are_few() {
    let case = Case::new(&[("x", 1.0, "-100*(x - sin(t))")], &[]).tolerance(1e-7);
    let run = case.run(&grid(100.0, 64_000));
    let part = run.implicit as f64 / run.steps as f64;
    assert!(run.implicit > 0 && part < 0.1, "{} of {}", run.implicit, run.steps);
}

/// Forty bodies in a stiff chain.
#[test]
fn a_long_stiff_chain_is_followed() {
    let n = 40;
    let names: Vec<(String, String)> = (0..n).map(|i| (format!("x{i}"), format!("v{i}"))).collect();
    let mut rates = Vec::new();
    for i in 0..n {
        let spring = |a: usize, b: usize| format!("(1e6*(x{a} - x{b}) + 1e4*(v{a} - v{b}))");
        let left = if i == 0 { "x0".to_owned() } else { spring(i, i - 1) };
        let right = if i + 1 < n { spring(i, i + 1) } else { "0".to_owned() };
        rates.push(format!("-{left} - {right}"));
    }
    let mut states: Vec<(&str, f64, &str)> = Vec::new();
    names.iter().for_each(|(x, v)| states.push((x, 1.0, v)));
    names.iter().zip(&rates).for_each(|((_, v), rate)| states.push((v, 0.0, rate)));
    let run = Case::new(&states, &[]).tolerance(1e-8).run(&grid(20.0, 200));
    assert!(run.implicit > 0 && run.steps < 4_000, "{} {}", run.steps, run.implicit);
    // All together on the soft spring, but for the bending of the chain: a part in 1e4.
    for (k, t) in grid(20.0, 200).iter().enumerate() {
        let exact = (t / (n as f64).sqrt()).cos();
        let got = run.states[k * 2 * n];
        assert!((got - exact).abs() < 1e-3, "{t}: {got} {exact}");
    }
}
