//! Residuals written down by hand: a spring and a load, whose motion has a closed form, their derivatives by
//! differences.

use super::*;
use crate::least_squares;
use crate::line_models::{STEP, records, scatter};
use approx::assert_relative_eq;
use phisindy_phys::spec::Role;
use phisindy_phys::{Case, OwnTimes, Record, SensorParameter};

/// Samples of the first record, in three segments, and of the second one, in two.
const SAMPLES: [usize; 2] = [90, 61];
const CUTS: [&[usize]; 2] = [&[0, 30, 60, 90], &[0, 30, 61]];
/// The second column of the first record has every third sample.
const SLOW: usize = 3;
/// By how much the two states may jump from one segment to the next.
const TAU: [f64; 2] = [0.3, 0.7];
const BELIEF: f64 = 2.5;

/// The first record has two columns, with an offset, a gain and a delay of the one and a gain of the other;
/// in the second one the gain is the spring's number, whatever that means.
fn springs() -> (Case, Vec<Record>) {
    let column =
        |n: usize, turn: f64| -> Vec<f64> { (0..n).map(|i| (0.13 * i as f64 + turn).cos()).collect() };
    let (case, mut records) = records(
        r#"states: {"x": "", "v": ""}, known: {"x": "v", "v": "c - k*x"}, unknown: {"v": (factor: "1", candidates: ["1"])},
           constants: {"k": (value: 1.2, within: (0.5, 4.0), sigma: 0.1), "c": (value: 0.1, within: (-9.0, 9.0), each: true)}"#,
        &[(Role::Fit, column(SAMPLES[0], 0.0)), (Role::Fit, column(SAMPLES[1], 0.4))],
    );
    records[0].columns[1] = Some(column(SAMPLES[0], 1.5));
    let free = |start: f64| SensorParameter { within: Some((-9.0, 9.0)), ..SensorParameter::fixed(start) };
    let [x, v] = &mut records[0].sensors[..] else { panic!("two states") };
    (x.offset, x.gain, x.delay, v.gain) = (free(0.0), free(1.0), free(0.13), free(1.0));
    let slow = (0..SAMPLES[0]).map(|i| i % SLOW == 0).collect();
    records[0].own_times = OwnTimes::new(vec![None, Some(slow)]);
    records[1].sensors[0].gain.shared = Some(0);
    records[1].sensors[0].offset = free(0.0);
    (case, records)
}

fn problem<'a>(case: &'a Case, records: &'a [Record], joined: bool) -> Problem<'a> {
    let mut problem = Problem::new(&case.system, &[0], &records.iter().collect::<Vec<_>>(), &[3, 2]).unwrap();
    problem.continuity = joined.then(|| TAU.to_vec());
    problem.belief = BELIEF;
    problem.tolerance = 1e-12;
    problem
}

/// Load; spring; load, sensors and three starts of the first record; load, offset and two starts of the
/// second one.
fn unknowns() -> Vec<f64> {
    let first = [0.02, 0.05, 1.1, 0.13, 0.9, 1.0, 0.1, -0.4, 0.9, -0.6, -0.7];
    let second = [-0.03, 0.04, 0.8, -0.5, -0.9, 0.2];
    [&[0.1, 1.27][..], &first, &second].concat()
}

fn weights() -> Vec<Vec<Vec<f64>>> {
    let column = |n: usize, size: f64| (0..n).map(|i| size * (1.0 + 0.01 * i as f64)).collect::<Vec<_>>();
    vec![vec![column(SAMPLES[0], 4.0), column(SAMPLES[0], 9.0)], vec![column(SAMPLES[1], 2.0), vec![]]]
}

/// Place and speed at `t` after a start. What a late sensor asks for before that is on a straight line.
fn swing(spring: f64, load: f64, start: &[f64], t: f64) -> [f64; 2] {
    let (w, rest, [x, v]) = (spring.sqrt(), load / spring, [start[0], start[1]]);
    if t < 0.0 {
        return [x + t * v, v + t * (load - spring * x)];
    }
    let (sin, cos) = (w * t).sin_cos();
    [rest + (x - rest) * cos + v / w * sin, v * cos - (x - rest) * w * sin]
}

/// All residuals over what they are known to, but for the belief; none of a sample that shows what was before the start.
fn residuals(u: &[f64], (problem, records): (&Problem<'_>, &[Record]), joined: bool) -> Vec<f64> {
    let (weights, mut out) = (weights(), vec![]);
    // Offset, gain, delay of each column.
    let sensors = [vec![[u[3], u[4], u[5]], [0.0, u[6], 0.0]], vec![[u[14], u[1], 0.0]]];
    for (r, (own, starts)) in [(u[2], 7), (u[13], 15)].into_iter().enumerate() {
        let load = u[0] + own;
        let known = |k: usize, i: usize| weights[r][k][i].sqrt();
        for (piece, cut) in CUTS[r].windows(2).enumerate() {
            let start = &u[starts + 2 * piece..][..2];
            for i in cut[0]..cut[1] {
                for (k, [offset, gain, delay]) in sensors[r].iter().enumerate() {
                    let state = swing(u[1], load, start, STEP * (i - cut[0]) as f64 - delay)[k];
                    let sample = records[r].columns[k].as_ref().unwrap()[i];
                    let own = r == 1 || k == 0 || i % SLOW == 0;
                    let told = if own && problem.tells(r, k, i) { 1.0 } else { 0.0 };
                    out.push(told * known(k, i) * (offset + gain * state - sample));
                }
            }
            if joined && piece + 2 < CUTS[r].len() {
                let end = swing(u[1], load, start, STEP * (cut[1] - cut[0]) as f64);
                out.extend((0..2).map(|k| (end[k] - u[starts + 2 * piece + 2 + k]) / TAU[k]));
            }
        }
    }
    out
}

/// Cost, matrix, gradient, and the meat of the sandwich.
#[test]
fn the_normal_equations_are_those_of_the_residuals() {
    let (case, records) = springs();
    let u = unknowns();
    let d = u.len();
    for joined in [false, true] {
        let problem = problem(&case, &records, joined);
        assert_eq!(problem.unknowns, d);
        let e = residuals(&u, (&problem, &records), joined);
        let by = |k: usize| -> Vec<f64> {
            let at = |step: f64| {
                let mut moved = u.clone();
                moved[k] += step;
                residuals(&moved, (&problem, &records), joined)
            };
            at(1e-5).iter().zip(&at(-1e-5)).map(|(up, down)| (up - down) / 2e-5).collect()
        };
        let j: Vec<Vec<f64>> = (0..d).map(by).collect();
        let sum = |of: &dyn Fn(usize) -> f64| (0..e.len()).map(of).sum::<f64>();
        let (miss, believed) = ((u[1] - 1.2) / 0.1, |a: usize| if a == 1 { BELIEF } else { 0.0 });
        let normal = problem.normal(&u, &weights()).unwrap();
        let meat = problem.meat(&u, &weights(), None).unwrap();
        assert_relative_eq!(normal.cost, sum(&|i| e[i] * e[i]) + BELIEF * miss * miss, max_relative = 1e-8);
        for a in 0..d {
            let gradient = sum(&|i| j[a][i] * e[i]) + believed(a) * miss / 0.1;
            assert_relative_eq!(normal.gradient[a], gradient, max_relative = 1e-6, epsilon = 1e-5);
            for b in 0..d {
                let believed = if a == b { believed(a) / (0.1 * 0.1) } else { 0.0 };
                let due = sum(&|i| j[a][i] * j[b][i]) + believed;
                assert_relative_eq!(normal.matrix[(a, b)], due, max_relative = 1e-6, epsilon = 1e-5);
                let due = sum(&|i| j[a][i] * j[b][i] * e[i] * e[i]) + believed;
                assert_relative_eq!(meat[(a, b)], due, max_relative = 1e-6, epsilon = 1e-5);
            }
        }
    }
}

/// An early sensor asks for more than the takeover: the state there is read back along the rates.
#[test]
fn an_early_sensor_sees_beyond_the_takeover() {
    let (case, mut records) = springs();
    let early = 0.25;
    for sensor in &mut records[0].sensors {
        sensor.delay = SensorParameter::fixed(-early);
    }
    records.truncate(1);
    let mut problem = Problem::new(&case.system, &[0], &[&records[0]], &[3]).unwrap();
    (problem.continuity, problem.tolerance) = (Some(TAU.to_vec()), 1e-12);
    // Without a delay of its own among the unknowns.
    let mut u = unknowns()[..13].to_vec();
    u.remove(5);
    assert_eq!(problem.unknowns, u.len());
    let (k, load) = (u[1], u[0] + u[2]);
    let cost_of_joints = |problem: &mut Problem<'_>, tau: f64| {
        problem.continuity = Some(vec![tau; 2]);
        problem.normal(&u, &weights()[..1]).unwrap().cost
    };
    let due: f64 = (0..2)
        .flat_map(|piece| {
            let start = &u[6 + 2 * piece..][..4];
            let end = swing(k, load, start, STEP * 29.0 + early);
            let late = early - STEP;
            [(end[0] - late * end[1]) - start[2], (end[1] - late * (load - k * end[0])) - start[3]]
        })
        .map(|jump| jump * jump)
        .sum();
    // The rest of the cost does not know of the joints.
    let found = cost_of_joints(&mut problem, 0.1) - cost_of_joints(&mut problem, 0.2);
    assert_relative_eq!(found, (100.0 - 25.0) * due, max_relative = 1e-8);
}

/// A step that is likely to fail is looked at without derivatives; the way is the same, to the bit.
#[test]
fn the_way_to_the_minimum_is_that_of_full_evaluations() {
    let (case, records) = springs();
    let mut problem = problem(&case, &records, true);
    let mut start = unknowns();
    start[1] = 3.0;
    let limits = Limits::new(30, 1e-9);
    let (mut fails, mut least) = (0, f64::INFINITY);
    let (mut plain, mut short) = (start.clone(), start.clone());
    let full = least_squares::minimise(&mut plain, &problem.bounds, limits, |x, _| {
        let normal = problem.normal(x, &weights()).ok()?;
        if normal.cost < least {
            least = normal.cost
        } else {
            fails += 1
        }
        Some(normal)
    });
    let end = problem.minimise(&mut short, &weights(), limits).unwrap();
    assert!(fails > 1, "no step fails");
    assert_eq!((end.cost, &short), (full.unwrap().cost, &plain));
    // Within other bounds, and from where nothing can be simulated.
    let mut bounds = problem.bounds.clone();
    bounds[1] = (2.9, 3.1);
    let mut near = start.clone();
    problem.minimise_within(&bounds, &mut near, &weights(), limits).unwrap();
    assert!((2.9..=3.1).contains(&near[1]) && near != start, "{}", near[1]);
    problem.budget = Some(1);
    assert!(problem.minimise(&mut start, &weights(), limits).is_err());
}

/// Cut and joined softly, with a belief about a parameter, a sensor of its own, and a step that fails: what a
/// fit meets.
#[test]
fn the_cost_alone_is_the_cost_to_the_bit() {
    let samples: Vec<f64> =
        scatter(90).iter().enumerate().map(|(i, e)| (0.2 * i as f64).cos() + 0.1 * e).collect();
    let (case, records) = records(
        r#"states: {"x": "", "v": ""}, constants: {"k": (value: 1.2, unit: "", within: (0.5, 2.0), sigma: 0.1)}, known: {"x": "v", "v": "-k*x"},
           unknown: {"v": (factor: "-sgn(v)", candidates: ["1", "x"])}, contacts: ["v"]"#,
        &[(Role::Fit, samples.clone()), (Role::Fit, samples)],
    );
    let both: Vec<_> = records.iter().collect();
    let mut problem = Problem::new(&case.system, &[0, 1], &both, &[3, 2]).unwrap();
    let mut x = problem.guess(&[0.05, 0.01], None, &records);
    // Off what is believed, in steps that are not one.
    (x[problem.priors[0].0], problem.belief) = (1.47, BELIEF);
    let noise = vec![vec![crate::trajectory::noise::ColumnNoise { additive: 0.1, relative: 0.05 }; 2]; 2];
    let weights = problem.weights(&noise, None);
    let mut all = Vec::new();
    for joints in [None, Some(vec![0.3, 0.7])] {
        problem.continuity = joints;
        let normal = problem.normal(&x, &weights).unwrap();
        assert_eq!(problem.cost(&x, &weights).unwrap(), normal.cost);
        all.push(normal.cost);
    }
    assert!(all[1] > all[0], "{all:?}");
}
