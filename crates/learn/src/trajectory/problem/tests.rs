//! What is unknown, in which order, and where a fit starts; residuals of lines.

use super::*;
use crate::line_models::{STEP, records, scatter};
use crate::trajectory::layout::GAIN;
use approx::assert_relative_eq;
use phisindy_phys::Case;
use phisindy_phys::spec::Role;

/// A place and its speed, and something that nothing shows; `k` is common, `e` of each record.
const SPEC: &str = r#"constants: {"k": (value: 0.3, within: (-9.0, 8.0), sigma: 0.5), "e": (value: 0.1, within: (-7.0, 6.0), each: true, sigma: 0.2)},
    states: {"x": "", "v": "", "z": ""}, known: {"x": "v", "v": "0", "z": "0*k*e"},
    unknown: {"z": (factor: "1", candidates: ["1", "2*t"], within: {"2*t": (0.0, 5.0)})}"#;

fn lines() -> (Case, Vec<Record>) {
    let line = |n: usize, slope: f64| {
        scatter(n).iter().enumerate().map(|(i, e)| slope * STEP * i as f64 + 0.1 * e).collect()
    };
    let (case, mut records) = records(SPEC, &[(Role::Fit, line(90, 0.5)), (Role::Fit, line(250, -2.0))]);
    records[1].sensors[0].gain.within = Some((0.5, 2.0));
    records[1].sensors[0].gain.start = 1.25;
    records[1].sensors[0].gain.sigma = Some(0.3);
    // It has no column.
    records[1].sensors[2].gain.within = Some((0.5, 2.0));
    (case, records)
}

fn problem<'a>(case: &'a Case, records: &'a [Record], pieces: &[usize]) -> Problem<'a> {
    Problem::new(&case.system, &[0, 1], &records.iter().collect::<Vec<_>>(), pieces).unwrap()
}

#[test]
fn the_unknowns_stand_in_their_order() {
    let (case, records) = lines();
    let problem = problem(&case, &records, &[3, 1]);
    let free = (f64::NEG_INFINITY, f64::INFINITY);
    let start = [(Meaning::Start, free), (Meaning::Start, free), (Meaning::Start, free)];
    let due = [
        vec![(Meaning::Coefficient(0), free), (Meaning::Coefficient(1), (0.0, 5.0))],
        vec![(Meaning::Parameter(0, None), (-9.0, 8.0)), (Meaning::Parameter(1, Some(0)), (-7.0, 6.0))],
        [start.to_vec(), start.to_vec(), start.to_vec()].concat(),
        vec![(Meaning::Parameter(1, Some(1)), (-7.0, 6.0)), (Meaning::Sensor(1, 0, GAIN), (0.5, 2.0))],
        start.to_vec(),
    ]
    .concat();
    let found: Vec<_> = problem.meanings().into_iter().zip(problem.bounds.iter().copied()).collect();
    assert_eq!(found, due);
    assert_eq!(problem.unknowns, due.len());
    assert!(problem.has_priors());
    assert_eq!(problem.priors, [(2, 0.3, 0.5), (3, 0.1, 0.2), (13, 0.1, 0.2), (14, 1.25, 0.3)]);
    let of = |record, samples, start| Segment { record, samples, start };
    let due = [of(0, (0, 30), 4), of(0, (30, 60), 7), of(0, (60, 90), 10), of(1, (0, 250), 15)];
    assert_eq!(problem.segments, due);
}

/// Four samples at least in a piece.
#[test]
fn a_short_record_is_not_cut_to_nothing() {
    let (case, records) = lines();
    let pieces = |count: usize| {
        let problem = problem(&case, &records, &[count, 1]);
        let own: Vec<(usize, usize)> = problem.segments.iter().map(|s| s.samples).collect();
        assert!(own.windows(2).all(|w| w[0].1 == w[1].0 || w[1].0 == 0));
        own.len() - 1
    };
    assert_eq!([0, 1, 22, 23, 1000].map(pieces), [1, 1, 22, 22, 22]);
}

/// A speed without a column is as large as the slope of its place, over a hundredth of a record; what nothing
/// shows has size 1.
#[test]
fn states_have_the_size_of_their_columns() {
    let (case, records) = lines();
    let found = problem(&case, &records, &[1, 1]);
    let columns = [0, 1].map(|r| records[r].columns[0].as_ref().unwrap());
    let rms = |column: &[f64], far: usize| {
        let slope = |i: usize| (column[i] - column[i - far]) / (STEP * far as f64);
        let n = (column.len() - far) as f64;
        ((far..column.len()).map(|i| slope(i).powi(2)).sum::<f64>() / n).sqrt()
    };
    let sizes = columns.map(|c| phisindy_signal::standard_deviation(c));
    assert_eq!(found.deviations, [[sizes[0], 0.0, 0.0], [sizes[1], 0.0, 0.0]]);
    // What a sensor reads is larger than the state by its gain.
    let gain = |r: usize| records[r].sensors[0].gain.start;
    assert_relative_eq!(found.scale[0], (sizes[0] / gain(0)).max(sizes[1] / gain(1)), max_relative = 1e-12);
    let speed = (rms(columns[0], 1) / gain(0)).max(rms(columns[1], 2) / gain(1));
    assert_relative_eq!(found.scale[1], speed, max_relative = 1e-9);
    assert_eq!(found.scale[2], 1.0);
}

#[test]
fn a_guess_is_what_is_known() {
    let (case, mut records) = lines();
    records[0].start[1] = Some(-4.0);
    let mut filled = records.clone();
    filled[0].columns[0] = Some((0..90).map(f64::from).collect());
    filled[0].columns[1] = Some((0..90).map(|i| 1e3 + f64::from(i)).collect());
    filled[1].columns[0] = Some(vec![7.0; 250]);
    let problem = problem(&case, &records, &[3, 1]);
    let due = [
        // The second coefficient may not be negative.
        vec![0.7, 0.0, 0.3, 0.1],
        // What the spec states of a start holds for the first piece.
        vec![0.0, -4.0, 0.0, 30.0, 1030.0, 0.0, 60.0, 1060.0, 0.0],
        vec![0.1, 1.25, 7.0, 0.0, 0.0],
    ]
    .concat();
    assert_eq!(problem.guess(&[0.7, -0.8], None, &filled), due);
    let found = problem.guess(&[0.7, -0.8], Some(&[0.4, 0.2]), &filled);
    assert_eq!([found[2], found[3], found[13]], [0.4, 0.2, 0.2]);
    assert_eq!(problem.model_parameters(1, &found), [0.7, 0.0, 0.4, 0.2]);
}

/// Lines of the first record from starts that are written down.
#[test]
fn residuals_weights_and_jumps_are_those_of_lines() {
    let (case, records) = lines();
    let mut problem = problem(&case, &records, &[3, 1]);
    let mut x = problem.guess(&[0.0, 0.0], None, &records);
    x[4..13].copy_from_slice(&[0.0, 0.5, 0.0, 1.8, 0.7, 0.2, 3.9, 0.4, 0.1]);
    let residuals = problem.residuals(&x).unwrap();
    let samples = records[0].columns[0].as_ref().unwrap();
    for i in [0, 17, 29, 30, 45, 60, 89] {
        let piece = i / 30;
        let line = x[4 + 3 * piece] + x[5 + 3 * piece] * STEP * (i % 30) as f64;
        assert_relative_eq!(residuals[0][0].prediction[i], line, epsilon = 1e-9);
        assert_relative_eq!(residuals[0][0].residual[i], samples[i] - line, epsilon = 1e-9);
    }
    assert!(residuals[0][1].residual.is_empty() && residuals[1][0].residual.len() == 250);
    // By a gain that is not one.
    let seen = problem.trajectory(&problem.segments[3], &x).unwrap();
    let readings = problem.readings(1, &x, &seen);
    assert_relative_eq!(readings[0][200], 1.25 * x[15] + 1.25 * x[16] * 20.0, epsilon = 1e-6);
    assert_relative_eq!(residuals[1][0].prediction[200], readings[0][200], epsilon = 1e-12);

    let noise = vec![vec![ColumnNoise { additive: 0.2, relative: 0.5 }; 3]; 2];
    let (measured, predicted) = (problem.weights(&noise, None), problem.weights(&noise, Some(&residuals)));
    let due = |value: f64| 1.0 / (0.2 * 0.2 + 0.25 * value * value);
    assert_relative_eq!(measured[0][0][45], due(samples[45]), max_relative = 1e-12);
    assert_relative_eq!(predicted[0][0][45], due(residuals[0][0].prediction[45]), max_relative = 1e-12);
    assert!(measured[0][1].is_empty() && measured[1][0].len() == 250);
    let of = |c: &ColumnResidual, size: f64| ColumnNoise::estimate(&c.residual, &c.prediction, size);
    assert_eq!(problem.noise(&residuals)[1][0], of(&residuals[1][0], 0.0));

    // From 1.5 to 1.8, and from 3.9 to 3.9; speeds by 0.2 and -0.3, the third by 0.2 and -0.1.
    let jumps = problem.jumps(&x).unwrap();
    for (found, due) in jumps.iter().zip([[0.3, 0.0], [0.2, -0.3], [0.2, -0.1]]) {
        assert_relative_eq!(*found, ((due[0] * due[0] + due[1] * due[1]) / 2.0_f64).sqrt(), epsilon = 1e-8);
    }
    assert!(problem.continuity.is_none() && problem.next(&problem.segments[0]).is_none());
    let longest = problem.segments.iter().map(|s| problem.run(s, &x, false).unwrap().run);
    assert_eq!(problem.steps(&x), longest.map(|run| run.steps + run.rejected).max().unwrap());
}

/// Of two inputs the second one is read late; what the record has undone already does not count.
#[test]
fn an_input_is_late_by_a_delay_of_its_own() {
    let spec = r#"(states: {"x": ""}, inputs: {"u": "", "w": ""}, known: {"x": "u + w"}, unknown: {},
        data: [Synthetic(truth: {}, inputs: {"u": Formula("1"), "w": Formula("2*t")}, start: {"x": 0.0}, duration: 5.0, step: 0.1, noise: Relative(0))])"#;
    let (case, mut records) = crate::step::onestep::tests::common::load_text(spec, &[]);
    records[0].sensors[2].delay.within = Some((-1.0, 1.0));
    records[0].sensors[2].delay.start = 0.2;
    let problem = Problem::new(&case.system, &[], &[&records[0]], &[1]).unwrap();
    assert_eq!(problem.meanings(), [Meaning::Sensor(0, 2, DELAY), Meaning::Start]);
    assert_eq!(problem.input_clocks(0, &[0.5, 0.0])[0].delay, 0.5);
    // What it says now was so earlier: w is ahead of its column by 0.3, and the place a line above the other.
    let [on_time, late] = [0.2, 0.5].map(|d| problem.residuals(&[d, 0.0]).unwrap()[0][0].prediction.clone());
    let inner = 20;
    let slope = (late[inner] - on_time[inner] - late[inner - 5] + on_time[inner - 5]) / 0.5;
    assert_relative_eq!(slope, 2.0 * 0.3, max_relative = 1e-3);
}
