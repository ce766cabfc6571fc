//! Free runs that can be written down: lines and exponentials. The fit of a start state is a mean, or
//! regression by hand.

use super::*;
use crate::line_models::{STEP, records, scatter};
use approx::assert_relative_eq;
use phisindy_phys::Case;

const LINE: &str =
    r#"states: {"x": ""}, known: {"x": "0"}, unknown: {"x": (factor: "1", candidates: ["1"])}"#;
const SAMPLES: usize = 200;

/// All records, with these coefficients; no start is known.
fn assessed(case: &Case, records: &[Record], coefficients: &[f64]) -> Vec<RecordFit> {
    let parameters: Vec<f64> = case.system.parameters.iter().map(|p| p.start).collect();
    let terms = (0..coefficients.len()).collect();
    let mut solution = Solution::new(terms, coefficients.to_vec(), &parameters, records);
    free_runs(&case.system, records, records, &mut solution)
}

/// How many samples the start took, if more than usual.
fn took(fit: &RecordFit) -> Option<usize> {
    fit.adapted.as_ref().filter(|a| a.took_more).map(|a| a.samples)
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Bent and noisy, so that each part of it has a mean of its own.
fn bent(samples: usize) -> Vec<f64> {
    scatter(samples).iter().enumerate().map(|(i, e)| 2.0 + 1e-4 * (i * i) as f64 + 0.1 * e).collect()
}

/// The start of a line of known slope is a mean: of the whole of a Fit record, of the first tenth of a
/// Validate record.
#[test]
fn the_start_of_a_line_is_a_mean() {
    let samples = bent(SAMPLES);
    let (case, records) = records(LINE, &[(Role::Fit, samples.clone()), (Role::Validate, samples.clone())]);
    let fits = assessed(&case, &records, &[0.3]);
    let lowered: Vec<f64> = samples.iter().enumerate().map(|(i, x)| x - 0.3 * STEP * i as f64).collect();
    for (fit, part) in fits.iter().zip([SAMPLES, SAMPLES / 10]) {
        let start = mean(&lowered[..part]);
        let adapted = fit.adapted.as_ref().map(|a| (a.samples, a.took_more));
        assert_eq!((adapted, fit.failure.as_ref()), ((part < SAMPLES).then_some((part, false)), None));
        assert_relative_eq!(fit.start[0], start, max_relative = 1e-6);
        // What is left, in the units of the column and as a part of how it scatters.
        let left: Vec<f64> = lowered.iter().map(|x| x - start).collect();
        left.iter().zip(&fit.residuals[0]).for_each(|(a, b)| assert_relative_eq!(a, b, epsilon = 1e-6));
        // A Validate record is judged by what its start was not fitted to.
        let from = if part < SAMPLES { part } else { 0 };
        let square = |of: &[f64], about: f64| of[from..].iter().map(|x| (x - about).powi(2)).sum::<f64>();
        let nrmse = (square(&left, 0.0) / square(&samples, mean(&samples[from..]))).sqrt();
        assert_eq!(fit.nrmse[0].0, "x");
        assert_relative_eq!(fit.nrmse[0].1, nrmse, max_relative = 1e-6);
    }
}

/// What the fit has found is not fitted again.
#[test]
fn a_start_that_is_known_stays() {
    let (case, records) = records(LINE, &[(Role::Fit, bent(SAMPLES)), (Role::Validate, bent(SAMPLES))]);
    let mut solution = Solution::new(vec![0], vec![0.3], &[], &records);
    solution.starts = vec![Some(vec![7.0]); 2];
    let fits = free_runs(&case.system, &records, &records, &mut solution);
    assert!(fits.iter().all(|fit| fit.start == [7.0] && fit.adapted.is_none()));
    assert_relative_eq!(fits[1].residuals[0][0], records[1].columns[0].as_ref().unwrap()[0] - 7.0);
}

/// A column that does not move has no scale to compare a residual with, not even one of zero.
#[test]
fn a_column_at_rest_is_never_met() {
    let (case, records) = records(LINE, &[(Role::Fit, vec![0.0; 50])]);
    let fits = assessed(&case, &records, &[0.0]);
    assert!(fits[0].residuals[0].iter().all(|e| *e == 0.0));
    assert_eq!(fits[0].nrmse[0].1, f64::INFINITY);
}

/// A record at rest is met to a part of what the state does elsewhere.
#[test]
fn a_column_that_rests_in_one_record_is_scored_by_its_motion_in_another() {
    let moves: Vec<f64> = (0..50).map(|i| f64::from(i % 2)).collect();
    let (case, records) = records(LINE, &[(Role::Fit, moves), (Role::Validate, vec![3.0; 50])]);
    let fits = assessed(&case, &records, &[0.0]);
    assert!(fits[1].nrmse[0].1 < 1e-6, "{:?}", fits[1].nrmse);
    // Two rows of half a unit: as far off as the other record scatters.
    let fits = assessed(&case, &records, &[1.0]);
    assert!(fits[1].nrmse[0].1 > 1.0 && fits[1].nrmse[0].1.is_finite(), "{:?}", fits[1].nrmse);
}

/// A sensor's gain moves with the start where the record is only predicted, and is held where it was fitted.
#[test]
fn a_sensor_is_found_anew_on_a_validate_record_alone() {
    let samples: Vec<f64> = (0..SAMPLES).map(|i| 1.0 + 0.6 * STEP * i as f64).collect();
    let (case, mut records) = records(LINE, &[(Role::Fit, samples.clone()), (Role::Validate, samples)]);
    for record in &mut records {
        record.sensors[0].gain.within = Some((0.2, 5.0));
    }
    let fits = assessed(&case, &records, &[0.3]);
    let adapted = fits[1].adapted.as_ref().unwrap();
    // Gain and start of a short piece are nearly collinear.
    assert_eq!((adapted.samples, adapted.took_more, adapted.values.len()), (160, true, 1));
    assert_relative_eq!(adapted.span.1, 159.0 * STEP, max_relative = 1e-12);
    assert_eq!(adapted.values[0].id.to_string(), "x.gain [r1]");
    assert_relative_eq!(adapted.values[0].value, 2.0, max_relative = 1e-5);
    // Twice the gain of the spec gives the slope that was measured.
    assert_relative_eq!(fits[1].start[0], 0.5, max_relative = 1e-5);
    assert!(fits[1].worst() < 1e-5, "{}", fits[1].worst());
    // Half of the scatter of the samples is not followed by half of the slope.
    assert_relative_eq!(fits[0].worst(), 0.5, max_relative = 1e-5);
}

/// A slope of its own is found with the start on half of a Validate record: regression by hand.
#[test]
fn a_number_of_its_own_takes_half_of_a_validate_record() {
    let samples = bent(SAMPLES);
    let (case, records) = records(
        r#"constants: {"c": (value: 0.3, within: (-9.0, 9.0), each: true)}, states: {"x": ""}, known: {"x": "c"}, unknown: {}"#,
        &[(Role::Fit, samples.clone()), (Role::Validate, samples.clone())],
    );
    let fits = assessed(&case, &records, &[]);
    let half = &samples[..SAMPLES / 2];
    let middle = 0.5 * (half.len() - 1) as f64;
    let lever: f64 = (0..half.len()).map(|i| (i as f64 - middle).powi(2)).sum();
    let slope = half.iter().enumerate().map(|(i, x)| (i as f64 - middle) * x).sum::<f64>() / lever;
    let adapted = fits[1].adapted.as_ref().unwrap();
    assert_eq!((adapted.samples, adapted.took_more, fits[1].scored()), (half.len(), false, 100..SAMPLES));
    assert_eq!(adapted.values[0].id.to_string(), "c [r1]");
    assert_relative_eq!(adapted.values[0].value, slope / STEP, max_relative = 1e-6);
    assert_relative_eq!(fits[1].start[0], mean(half) - slope * middle, max_relative = 1e-6);
    let end = samples[SAMPLES - 1] - mean(half) - slope * ((SAMPLES - 1) as f64 - middle);
    assert_relative_eq!(fits[1].residuals[0][SAMPLES - 1], end, max_relative = 1e-6);
}

/// Two columns, one tells the place of a steady motion and one its speed, and they do not agree: each weighs
/// by its own scatter.
#[test]
fn columns_weigh_by_their_own_scatter() {
    let (place, speed) = (bent(SAMPLES), scatter(SAMPLES).iter().map(|e| 0.02 + 4.0 * e).collect::<Vec<_>>());
    let (case, mut records) = records(
        r#"states: {"x": "", "v": ""}, known: {"x": "v", "v": "0"}, unknown: {}"#,
        &[(Role::Fit, place.clone())],
    );
    records[0].columns[1] = Some(speed.clone());
    let fits = assessed(&case, &records, &[]);
    // Normal equations of (x - x0 - v t)^2 / a + (u - v)^2 / b.
    let (a, b) = (standard_deviation(&place).powi(2), standard_deviation(&speed).powi(2));
    let time = |i: usize| STEP * i as f64;
    let sum = |f: &dyn Fn(usize) -> f64| (0..SAMPLES).map(f).sum::<f64>();
    let n = SAMPLES as f64;
    let (xx, xv, vv) = (n / a, sum(&time) / a, sum(&|i| time(i).powi(2)) / a + n / b);
    let (rx, rv) = (sum(&|i| place[i]) / a, sum(&|i| time(i) * place[i]) / a + sum(&|i| speed[i]) / b);
    let det = xx * vv - xv * xv;
    assert_relative_eq!(fits[0].start[0], (vv * rx - xv * rv) / det, max_relative = 1e-6);
    assert_relative_eq!(fits[0].start[1], (xx * rv - xv * rx) / det, max_relative = 1e-6);
}

/// Neighbours of `exp(l t)` part: a start that is known to `s` at the beginning is known to `s exp(l t)`
/// later, in the mean square over the record `sum(all) / sum(part)` of the noise.
#[test]
fn a_motion_that_hangs_on_its_start_takes_as_much_as_it_needs() {
    for growth in [0.01, 0.1, 0.2, 0.45] {
        let samples: Vec<f64> = (0..SAMPLES).map(|i| (growth * STEP * i as f64).exp()).collect();
        let power = |part: usize| samples[..part].iter().map(|x| x * x).sum::<f64>();
        let mut due = SAMPLES / 10;
        while due < SAMPLES && power(SAMPLES) / power(due) > 0.1 * SAMPLES as f64 {
            due = (2 * due).min(SAMPLES);
        }
        let (case, records) = records(
            &format!(r#"states: {{"x": ""}}, known: {{"x": "{growth}*x"}}, unknown: {{}}"#),
            &[(Role::Validate, samples)],
        );
        let fits = assessed(&case, &records, &[]);
        assert_eq!(took(&fits[0]), (due > SAMPLES / 10).then_some(due), "{growth}");
        // The run is as exact as the end of the motion asks for.
        assert_relative_eq!(fits[0].start[0], 1.0, max_relative = 1e-4);
    }
}

/// A state that nothing shows is no reason to wait; one that shows later is, until it has.
#[test]
fn a_state_that_shows_late_is_waited_for() {
    let took = |known: &str, samples: Vec<f64>| {
        let text =
            format!(r#"states: {{"x": "", "z": ""}}, known: {{"x": "{known}", "z": "0"}}, unknown: {{}}"#);
        let (case, records) = records(&text, &[(Role::Validate, samples)]);
        let fits = assessed(&case, &records, &[]);
        (took(&fits[0]), fits[0].start.clone())
    };
    assert_eq!(took("0.1", bent(SAMPLES)).0, None);
    // From a quarter of the record on; what is added later has little that is new.
    let late: Vec<f64> = (0..SAMPLES).map(|i| 1.0 + 0.5 * (STEP * i as f64 - 5.0).max(0.0)).collect();
    let (part, start) = took("z*step(t - 5)", late);
    assert_eq!(part, Some(160));
    assert_relative_eq!(start[1], 0.5, max_relative = 1e-5);
}

/// The second record goes on where the first one ends, half a second later by the clock, and both are read
/// late.
#[test]
fn a_record_that_continues_another_one_runs_on() {
    let (delay, slope, gap) = (0.25, 0.3, 0.5);
    let samples = bent(120);
    let (case, mut records) =
        records(LINE, &[(Role::Fit, samples.clone()), (Role::Validate, samples.clone())]);
    for (record, begin) in records.iter_mut().zip([2.0, 2.0 + 119.0 * STEP + gap]) {
        record.time = (0..120).map(|i| begin + STEP * i as f64).collect();
        record.sensors[0].delay.start = delay;
    }
    records[1].continues = Some(0);
    let fits = assessed(&case, &records, &[slope]);
    // Where the body is at the first look, by the samples that show what was after it; the start of a run is where the
    // clock says that it begins.
    let told = |i: &usize| STEP * *i as f64 >= delay + 0.5 * STEP;
    let first =
        mean(&(0..120).filter(told).map(|i| samples[i] - slope * STEP * i as f64).collect::<Vec<_>>());
    assert_relative_eq!(fits[0].start[0], first + slope * delay, max_relative = 1e-6);
    for i in [60, 119] {
        let due = first + slope * (119.0 * STEP + gap + STEP * i as f64);
        assert_relative_eq!(samples[i] - fits[1].residuals[0][i], due, max_relative = 1e-6);
    }
    assert_eq!(fits[1].residuals[0][0], 0.0);
    let begin = first + slope * (119.0 * STEP + gap + delay);
    assert_relative_eq!(fits[1].start[0], begin, max_relative = 1e-6);

    // Where the first one has no run there is nothing to continue.
    let mut solution = Solution::new(vec![0], vec![slope], &[], &records);
    solution.starts[0] = Some(vec![f64::NAN]);
    let fits = free_runs(&case.system, &records, &records, &mut solution);
    assert!(fits[0].run.is_none() && fits[0].failure.is_some());
    // The samples of a tenth that tell are too few; twice as many are enough.
    let first: Vec<f64> = (0..24).filter(told).map(|i| samples[i] - slope * STEP * i as f64).collect();
    assert_relative_eq!(fits[1].start[0], mean(&first) + slope * delay, max_relative = 1e-6);
}

/// A swing of nanometres is continued as exactly as one of metres, and what grows without bound ends the run.
#[test]
fn a_continued_run_knows_the_size_of_its_states() {
    let swing = |i: usize| 1e-9 * (STEP * i as f64).cos();
    let (case, mut records) = records(
        r#"states: {"x": "", "v": ""}, known: {"x": "v", "v": "-x"}, unknown: {}"#,
        &[(Role::Fit, (0..100).map(swing).collect()), (Role::Validate, (99..199).map(swing).collect())],
    );
    records[1].time = (99..199).map(|i| STEP * i as f64).collect();
    records[1].continues = Some(0);
    let fits = assessed(&case, &records, &[]);
    assert!(fits[1].worst() < 1e-4, "{}", fits[1].worst());

    // e^10 times its size at the end of the second record.
    let (case, mut records) = crate::line_models::records(
        r#"states: {"x": ""}, known: {"x": "x*step(t - 1)"}, unknown: {}"#,
        &[(Role::Fit, (0..11).map(|i| 1.0 + 1e-3 * i as f64).collect()), (Role::Validate, bent(200))],
    );
    records[1].time = (0..200).map(|i| 1.0 + STEP * i as f64).collect();
    records[1].continues = Some(0);
    let fits = assessed(&case, &records, &[]);
    let why = fits[1].failure.as_ref().map(ToString::to_string).unwrap_or_default();
    assert!(fits[0].run.is_some() && why.contains("`x` grows without bound"), "{why}");
}
