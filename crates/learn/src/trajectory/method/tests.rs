//! What is told of a fit on a line, where each number is a regression by hand.

use super::*;
use crate::line_models::{STEP, fitted, fitted_terms, lever, leverage, records, scatter};
use crate::result::estimate::Estimate;
use crate::result::identified::NoiseModel;
use crate::result::verdict::Verdict;
use crate::trajectory::error_bars::robust_covariance;
use crate::trajectory::unknowns::Unknowns;
use approx::assert_relative_eq;
use phisindy_phys::SensorParameter;
use phisindy_phys::spec::Method;

const SIGMA: f64 = 0.1;

const SAMPLES: usize = 100;
/// A level, a slope and a bend of the rate.
const RATES: &str = r#"states: {"x": ""}, known: {"x": "0"}, unknown: {"x": (factor: "1", candidates: ["1", "2*t", "3*t^2"])}"#;

/// 2 + 0.5 t + bend t^2 and noise.
fn line(bend: f64) -> Vec<f64> {
    let time = |i: usize| STEP * i as f64;
    let clean = |i: usize| 2.0 + 0.5 * time(i) + bend * time(i).powi(2);
    scatter(SAMPLES).iter().enumerate().map(|(i, e)| clean(i) + SIGMA * e).collect()
}

/// Slope, its scatter by what a line without a sample leaves of it, and the mean square of what is left.
fn regression(samples: &[f64]) -> (f64, f64, f64) {
    let (n, mean) = (samples.len() as f64, samples.iter().sum::<f64>() / samples.len() as f64);
    let of = |i: usize| STEP * (i as f64 - 0.5 * (n - 1.0));
    let slope = samples.iter().enumerate().map(|(i, x)| of(i) * x).sum::<f64>() / lever(samples.len());
    let left = |(i, x): (usize, &f64)| x - mean - slope * of(i);
    let without = |s: (usize, &f64)| left(s) / (1.0 - leverage(s.0, samples.len()));
    let meat: f64 = samples.iter().enumerate().map(|s| (of(s.0) * without(s)).powi(2)).sum();
    let square: f64 = samples.iter().enumerate().map(|s| left(s).powi(2)).sum();
    (slope, meat.sqrt() / lever(samples.len()), square / n)
}

fn context<'a>(case: &'a Case, records: &'a [Record]) -> Context<'a> {
    Context {
        system: &case.system,
        records: records.iter().filter(|r| r.role == Role::Fit).collect(),
        smooth: records.iter().filter(|r| r.role == Role::Fit).cloned().collect(),
        segments: SegmentsSpec::Auto,
        stop: Stop::default(),
    }
}

/// As `identify` begins: from smoothed records.
fn learned(
    case: &Case,
    records: &[Record],
    observe: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<Identified, LearnError> {
    let smooth: Vec<Record> =
        records.iter().map(|r| crate::trajectory::initial::smoothed(&case.system, r)).collect();
    by_trajectory(case, (records, &smooth), &LearnOptions::default(), &Stop::default(), observe)
}

fn identified(learn: &str, samples: &[(Role, Vec<f64>)]) -> Identified {
    let (case, records) = records(&format!("{RATES}, learn: ({learn})"), samples);
    learned(&case, &records, &mut |_| ControlFlow::Continue(())).unwrap()
}

#[test]
fn what_is_told_of_a_line_is_its_regression() {
    let (slope, error, left) = regression(&line(0.0));
    let noise = scatter(SAMPLES);
    // With little noise, so that a tenth of it tells where it starts.
    let calm: Vec<f64> = (0..SAMPLES).map(|i| 2.0 + 0.5 * STEP * i as f64 + 1e-3 * noise[i]).collect();
    let found = identified("", &[(Role::Validate, calm.clone()), (Role::Fit, line(0.0))]);
    assert_eq!(found.terms.iter().map(|t| t.term).collect::<Vec<_>>(), [0]);
    let Estimate { value, std_error, ci95 } = found.terms[0].coefficient;
    assert_relative_eq!(value, slope, max_relative = 1e-4);
    assert_relative_eq!(std_error, error, max_relative = 0.02);
    assert_relative_eq!(found.covariance[0][0], std_error * std_error, max_relative = 1e-9);
    assert_relative_eq!(ci95.1 - ci95.0, 2.0 * 1.96 * std_error, max_relative = 0.02);
    assert!(found.warnings.is_empty() && found.parameters.is_empty(), "{:?}", found.warnings);
    assert_eq!(
        (found.verdict, found.method, found.stop_reason),
        (Verdict::Identified, Method::Trajectory, StopReason::Finished)
    );
    // By the column where nothing was fitted, by what is left where it was.
    assert_relative_eq!(
        found.records[0].noise[0].1,
        phisindy_signal::noise_level(&calm),
        max_relative = 1e-12
    );
    assert_eq!((found.records[1].noise[0].0.as_str(), found.records[1].noise.len()), ("x", 1));
    assert_relative_eq!(found.records[1].noise[0].1, left.sqrt(), max_relative = 0.1);
    assert_eq!(found.noise_model, NoiseModel::Additive);
    let told: Vec<&PathPoint> = found.selection.iter().filter(|p| p.nrmse.is_some()).collect();
    assert_eq!((told.len(), told[0].terms, told[0].nrmse), (1, 1, Some(found.records[1].worst())));
}

/// By hand: what is below the cut_off-off goes, the rest is fitted again.
#[test]
fn all_terms_or_those_above_a_cut_off() {
    let samples = line(0.02);
    let (case, records) = records(RATES, &[(Role::Fit, samples.clone())]);
    let all = fitted(&case, &records, SIGMA);
    let found = identified("selection: All", &[(Role::Fit, samples.clone())]);
    assert_eq!(found.terms.iter().map(|t| t.term).collect::<Vec<_>>(), [0, 1, 2]);
    for (t, due) in found.terms.iter().zip(&all.x) {
        assert_relative_eq!(t.coefficient.value, due, max_relative = 1e-2);
    }
    for (cutoff, rounds) in [(0.0, 0), (0.01, 1), (0.3, 1), (9.0, 1)] {
        let (mut terms, mut path) = (vec![0, 1, 2], vec![3]);
        loop {
            let x = fitted_terms(&case, &records, SIGMA, &terms).x;
            let kept: Vec<usize> =
                terms.iter().zip(&x).filter(|(_, x)| x.abs() >= cutoff).map(|(&t, _)| t).collect();
            if kept.len() == terms.len() {
                break;
            }
            terms = kept;
            path.push(terms.len());
        }
        assert!(path.len() > rounds, "{cutoff}: {path:?}");
        let context = context(&case, &records);
        let Selection { fit, path: way } = cut_off(&context, fitted(&case, &records, SIGMA), cutoff);
        assert_eq!(fit.problem.terms, terms, "{cutoff}");
        assert_eq!(way.iter().map(|p| p.terms).collect::<Vec<_>>(), path);
        for point in [&way[0], &way[way.len() - 1]] {
            let all = [0, 1, 2];
            let of = if point.terms == 3 { &all[..] } else { &terms };
            let cost = fitted_terms(&case, &records, SIGMA, of).normal.cost;
            assert_relative_eq!(point.criterion, cost, max_relative = 1e-4);
        }
    }
}

/// A wave that no term may explain: told, and the samples count as few.
#[test]
fn what_is_left_and_is_not_noise_is_told() {
    let wave: Vec<f64> =
        line(0.0).iter().enumerate().map(|(i, x)| x + 0.4 * (2.0 * STEP * i as f64).cos()).collect();
    let (case, records) = records(&RATES.replace(r#", "2*t", "3*t^2""#, ""), &[(Role::Fit, wave.clone())]);
    let mut heard = vec![];
    let found = learned(&case, &records, &mut |part| {
        heard.push(part);
        ControlFlow::Continue(())
    });
    let found = found.unwrap();
    // As long as something is left another start is tried.
    assert!(
        heard.len() > 3 && heard.is_sorted() && heard.iter().all(|p| (0.0..=1.0).contains(p)),
        "{heard:?}"
    );
    // What the wave does to a state is a force that is left, and the innovations are hardly correlated.
    assert!(
        found.warnings.len() == 1 && found.warnings[0].to_string().starts_with("the residual is not white"),
        "{:?}",
        found.warnings
    );
    let (_, white, _) = regression(&wave);
    let found_error = found.terms[0].coefficient.std_error;
    assert!(found_error > white, "{found_error} {white}");
    assert_relative_eq!(found.covariance[0][0].sqrt(), found_error, max_relative = 1e-9);
}

/// A wave far below the noise: most samples count, and yet it is there.
#[test]
fn what_is_left_and_is_small_is_told() {
    let noise = scatter(2000);
    for (size, told) in [(0.025, true), (0.01, false)] {
        let time = |i: usize| STEP * i as f64;
        let of = |i: usize| 2.0 + 0.5 * time(i) + size * (0.5 * time(i)).cos() + SIGMA * noise[i];
        let found = identified("", &[(Role::Fit, (0..2000).map(of).collect())]);
        let says =
            |w: &Warning| w.to_string().starts_with("the residual is not white: what is left is small");
        assert_eq!(found.warnings.iter().any(says), told, "{:?}", found.warnings);
    }
}

/// Whenever it is said, once is enough.
#[test]
fn who_stops_it_gets_the_best_so_far() {
    for (from, to, stopped) in [(0.0, 0.05, true), (0.05, 0.5, true), (0.5, 0.95, true), (0.95, 1.0, false)] {
        let (case, records) = records(RATES, &[(Role::Fit, line(0.0))]);
        let mut heard = vec![];
        let found = learned(&case, &records, &mut |part| {
            heard.push(part);
            if (from..to).contains(&part) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        let found = found.unwrap();
        assert_eq!(found.interrupted(), stopped, "{from}");
        assert_relative_eq!(found.terms[0].coefficient.value, 0.5, max_relative = 0.05);
        assert!(heard.is_sorted() && heard.iter().all(|p| (0.0..=1.0).contains(p)), "{heard:?}");
    }
}

/// Of the single terms the one that predicts best, in each equation.
#[test]
fn the_first_term_is_the_one_that_predicts_best() {
    let text = r#"states: {"x": "", "z": ""}, known: {"x": "0", "z": "0"}, unknown: {"x": (factor: "1", candidates: ["1", "2*t", "t - 3"]), "z": (factor: "1", candidates: ["t - 2", "1", "2*t"])}"#;
    let time = |i: usize| STEP * i as f64;
    let noise = scatter(2 * SAMPLES);
    let x = (0..SAMPLES).map(|i| 0.5 * time(i) + 0.01 * noise[i]).collect();
    let (case, mut records) = records(text, &[(Role::Fit, x)]);
    for (rate, due) in [([0.7, 0.0], vec![0, 4]), ([0.0, 0.3], vec![0, 5]), ([-0.6, 0.15], vec![0, 3])] {
        let of = |i: usize| rate[0] * time(i) + rate[1] * time(i).powi(2) + 0.01 * noise[SAMPLES + i];
        records[0].columns[1] = Some((0..SAMPLES).map(of).collect());
        let context = context(&case, &records);
        let regression = Regression::new(&case.system, &context.smooth, &[]);
        let found = first_terms(&context, &regression);
        assert_eq!(found, due);
        let size = |terms: &[usize]| context.misfit_of_guess(terms, &regression.solve(terms)).unwrap();
        for x in 0..3 {
            for z in 3..6 {
                assert!(size(&found) <= size(&[x, z]) * (1.0 + 1e-12), "{x} {z}");
            }
        }
    }
}

#[test]
fn what_changes_places_is_named() {
    let case = records(RATES, &[(Role::Fit, line(0.0))]).0;
    let told = alternative(&case.system, &[0, 1], &[0, 2], 1.26).unwrap().to_string();
    assert!(
        told.starts_with(
            "3*t^2 in place of 2*t in x' describes the data just as well (its criterion is 1.3 higher"
        ),
        "{told}"
    );
}

/// A rate that hardly changes is as good as one that does not; who asks for all terms has chosen.
#[test]
fn another_choice_is_told_of_where_there_was_a_choice() {
    let text = RATES.replace("2*t", "1 + 0.01*t");
    for (learn, told) in [("", true), ("selection: All", false)] {
        let (case, records) = records(&format!("{text}, learn: ({learn})"), &[(Role::Fit, line(0.0))]);
        let found = learned(&case, &records, &mut |_| ControlFlow::Continue(())).unwrap();
        let says = |w: &Warning| w.to_string().contains(" in place of ");
        assert_eq!(found.warnings.iter().any(says), told, "{:?}", found.warnings);
    }
}

/// The only record needs no name.
#[test]
fn a_sensor_is_named_by_its_column() {
    let (case, mut records) = records(RATES, &[(Role::Fit, line(0.0))]);
    records[0].sensors[0].delay =
        SensorParameter { within: Some((-1.0, 1.0)), ..SensorParameter::fixed(0.0) };
    let found = learned(&case, &records, &mut |_| ControlFlow::Continue(())).unwrap();
    let of = &found.parameters[0];
    assert_eq!((of.id.to_string().as_str(), of.unit.as_str(), of.id.record()), ("x.delay", "s", Some(0)));
}

/// A second state that nothing measures: the rest has the sandwich, the unseen start no end.
#[test]
fn what_is_not_seen_has_no_error_bar() {
    let text = r#"states: {"x": "", "z": ""}, known: {"x": "0", "z": "0"}, unknown: {"x": (factor: "1", candidates: ["1"])}"#;
    let (case, records) = records(text, &[(Role::Fit, line(0.0))]);
    let fit = fitted(&case, &records, SIGMA);
    let cov = robust_covariance(&fit);
    let (_, error, _) = regression(&line(0.0));
    assert_relative_eq!(cov[(0, 0)], error.powi(2), max_relative = 1e-4);
    assert_eq!((cov[(2, 2)], cov[(0, 2)], cov[(2, 1)]), (f64::INFINITY, 0.0, 0.0));
}

/// One number for all records, one for each, and sensors; a Validate record has those of the one that it goes
/// on from, else of the first.
#[test]
fn each_record_has_its_own_numbers() {
    let text = r#"constants: {"c": (value: 0.3, within: (-90.0, 90.0)), "e": (value: 0.0, unit: "mm", within: (-90.0, 14.5), each: true)},
        states: {"x": ""}, known: {"x": "c + e"}, unknown: {"x": (factor: "1", candidates: ["1"])}"#;
    let roles = [Role::Validate, Role::Fit, Role::Validate, Role::Fit];
    let (case, mut records) = records(text, &roles.map(|role| (role, line(0.0))));
    records[2].continues = Some(3);
    records[3].sensors[0].gain =
        SensorParameter { within: Some((-90.0, 90.0)), ..SensorParameter::fixed(1.0) };
    let two = [&records[1], &records[3]];
    let problem = Problem::new(&case.system, &[0], &two, &[1, 1]).unwrap();
    // The coefficient, c, e and the start of the one, e, gain and start of the other.
    let bound = problem.bounds[4].1;
    let x = vec![10.0, 11.0, 0.0125, 13.0, bound, 1.5, 16.0];
    let noise = vec![vec![crate::trajectory::noise::ColumnNoise { additive: SIGMA, relative: 0.0 }]; 2];
    let weights = problem.weights(&noise, None);
    let normal = problem.normal(&x, &weights).unwrap();
    let fit = Fit {
        problem,
        x,
        noise,
        weights,
        normal,
        samples: 200,
        effective: 200.0,
        excess: 1.0,
        pieces: vec![1, 1],
        force: None,
    };
    let unknowns = Unknowns::new(&case.system, &records, &fit);
    assert_eq!(unknowns.fitted, [1, 3]);
    let found = unknowns.solution();
    assert_eq!((&found.terms, &found.coefficients), (&vec![0], &vec![10.0]));
    assert_eq!(found.parameters, [[11.0, 0.0125], [11.0, 0.0125], [11.0, bound], [11.0, bound]]);
    assert_eq!(found.sensors.iter().map(|s| s[0][1]).collect::<Vec<_>>(), [1.0, 1.0, 1.0, 1.5]);
    assert_eq!(found.starts, [None, Some(vec![13.0]), None, Some(vec![16.0])]);
    // Their names, units, records and bounds.
    let estimate = |k: usize| Estimate::normal(fit.x[k], 0.0);
    let all: Vec<_> = unknowns
        .parameters(estimate)
        .into_iter()
        .map(|(_, p)| p)
        .map(|p| (p.id.to_string(), p.factor, p.estimate.value, p.at_bound, p.id.constant(), p.id.record()))
        .collect();
    let due = [
        ("c", 1.0, 11.0, false, Some(0), None),
        ("e [r1]", 1e-3, 0.0125, false, Some(1), Some(1)),
        ("e [r3]", 1e-3, bound, true, Some(1), Some(3)),
        ("x.gain [r3]", 1.0, 1.5, false, None, Some(3)),
    ];
    let due: Vec<_> = due.into_iter().map(|(name, a, b, c, d, e)| (name.to_owned(), a, b, c, d, e)).collect();
    assert_eq!(all, due);
}
