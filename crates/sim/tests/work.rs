//! How much work the reference runs are. A change that makes them slower fails here; one that makes them

//! faster may tighten the numbers.

use crate::common::{Case, case_1a, case_1b, case_7, grid};

struct Work {
    events: usize,
    steps: usize,
    rejected: usize,
    evaluations: usize,
}

/// The counters may be lower, and 2 % higher: they depend on the last bits of `cos` and `ln` a little.
#[track_caller]
fn check(case: Case, most: Work) {
    let run = case.tolerance(1e-8).run(&grid(50.0, 5000));
    let got = (run.events.len(), run.steps, run.rejected, run.evaluations);
    let fits = |got: usize, most: usize| got as f64 <= 1.02 * most as f64;
    assert!(
        got.0 == most.events
            && fits(got.1, most.steps)
            && fits(got.2, most.rejected)
            && fits(got.3, most.evaluations),
        "events, steps, rejected, evaluations: {got:?}"
    );
}

#[test]
fn case_1a_coulomb() {
    check(case_1a(), Work { events: 10, steps: 327, rejected: 0, evaluations: 2074 });
}

#[test]
fn case_1b_dieterich_ruina() {
    check(case_1b(), Work { events: 10, steps: 624, rejected: 160, evaluations: 4816 });
}

#[test]
fn case_7_two_masses() {
    check(case_7(), Work { events: 39, steps: 1188, rejected: 298, evaluations: 9470 });
}

/// What a stop or a departure costs beyond the smooth motion between: friction with a steep shape near rest
/// must not make the steps crawl.
#[test]
fn an_event_of_dieterich_ruina_costs_less_than_sixty_steps() {
    for (with, without, events) in [(case_1b(), case_1a(), 10), (case_7(), coulomb_7(), 39)] {
        let tries = |case: Case| {
            let run = case.tolerance(1e-8).run(&grid(50.0, 5000));
            (run.steps + run.rejected, run.events.len())
        };
        let ((with, all), (without, _)) = (tries(with), tries(without));
        assert_eq!(all, events);
        assert!(with < without + 60 * events, "{with} against {without}");
        assert!(with < 1600, "{with}");
    }
}

/// ... nor be passed with steps that miss its shape: the default tolerance gives states and derivatives that
/// a sharper one confirms.
#[test]
fn the_default_tolerance_resolves_the_events() {
    for (case, states, derivatives) in
        [(case_1a(), 2e-8, 2e-7), (case_1b(), 2e-8, 1e-5), (case_7(), 3e-8, 5e-5)]
    {
        let times = grid(50.0, 500);
        let run = case.clone().tolerance(1e-8).run_with_sensitivities(&times);
        let exact = case.tolerance(1e-12).run_with_sensitivities(&times);
        let rms = |values: &[f64]| (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt();
        let off = |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a - b).collect() };
        let error = rms(&off(&run.states, &exact.states));
        assert!(error < states, "states {error:e}");
        for column in 0..run.m {
            let of = |s: &[f64]| -> Vec<f64> { s.iter().skip(column).step_by(run.m).copied().collect() };
            let (got, want) = (of(&run.sensitivities), of(&exact.sensitivities));
            // Nothing hangs on the speed of a mass that starts at rest and is held.
            let error = rms(&off(&got, &want)) / rms(&want).max(f64::MIN_POSITIVE);
            assert!(error < derivatives, "derivative {column}: {error:e}");
        }
    }
}

fn coulomb_7() -> Case {
    let mut case = case_7();
    // The last five parameters shape the friction of the second mass; a and b are the first two.
    (case.parameters[10], case.parameters[11]) = (0.0, 0.0);
    case
}
