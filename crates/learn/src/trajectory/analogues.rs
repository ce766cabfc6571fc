//! What of a remainder follows the motion, by analogues: where the motion of the last while was alike, was the
//! remainder alike too (E. N. Lorenz, J. Atmos. Sci. 26 (1969) 636-646)? No form is assumed, and what depends on the
//! past, as hysteresis and play do, counts as well. Noise of any colour and a force in time are not alike there.

use crate::decisions::{ANALOGUE_LAGS, ANALOGUE_POINTS, ANALOGUES, MOSTLY};
use crate::result::record_fit::RecordFit;
use phisindy_phys::{Record, System};
use phisindy_signal::{autocorrelation, standard_deviation};
use rayon::prelude::*;

/// What moves in a record, column by column, and in how many samples the fastest of it is no longer like itself.
struct Motion {
    columns: Vec<Vec<f64>>,
    quarter_period: usize,
}

/// A record beside what is left of one of its columns, by sample.
type Remains<'a> = (&'a Motion, &'a [(usize, f64)]);

/// A moment of a record.
struct Point {
    record: usize,
    sample: usize,
    /// The motion there and some time before, each column in parts of its standard deviation.
    history: Vec<f64>,
    left: f64,
}

/// The columns of which most of what free runs leave follows the motion, each with what part of its size that is.
pub(crate) fn columns_with_remains(
    system: &System,
    records: &[Record],
    fits: &[RecordFit],
) -> Vec<(usize, f64)> {
    let motions: Vec<Option<Motion>> = records.iter().zip(fits).map(|of| motion(system, of)).collect();
    let of = |k: usize| {
        let with = |r: &usize| records[*r].columns[k].is_some() && motions[*r].is_some();
        let shown: Vec<usize> = (0..records.len()).filter(with).collect();
        let remains: Vec<Vec<(usize, f64)>> = shown.iter().map(|&r| remains(&fits[r], k)).collect();
        let all: Vec<Remains<'_>> = shown
            .iter()
            .zip(&remains)
            .filter_map(|(&r, left)| Some((motions[r].as_ref()?, left.as_slice())))
            .collect();
        let power = |&r: &usize| {
            records[r].deviation(k).powi(2) * records[r].own_times.count(k, 0..records[r].len()) as f64
        };
        let size: f64 = shown.iter().map(power).sum();
        let left: f64 = all.iter().flat_map(|(_, left)| left.iter()).map(|(_, x)| x * x).sum();
        let follows = of_motion(&all);
        (follows > MOSTLY).then(|| (k, (follows * left / size).sqrt()))
    };
    (0..system.columns()).filter_map(of).collect()
}

/// What a free run leaves of a column, at its own samples.
fn remains(fit: &RecordFit, column: usize) -> Vec<(usize, f64)> {
    let all = fit.residuals[column].iter().copied().enumerate();
    all.filter(|(i, _)| fit.own_times.has(column, *i)).collect()
}

/// The states of a free run and the inputs; none where it failed.
fn motion(system: &System, (record, fit): (&Record, &RecordFit)) -> Option<Motion> {
    let run = fit.run.as_ref()?;
    let states =
        (0..system.states.len()).map(|s| run.states.iter().skip(s).step_by(run.n).copied().collect());
    let inputs = (0..record.inputs.len()).map(|u| record.input_samples(u).into_owned());
    Some(Motion::new(states.chain(inputs).collect()))
}

impl Motion {
    fn new(columns: Vec<Vec<f64>>) -> Motion {
        let of = |column: &Vec<f64>| autocorrelation(column).iter().position(|c| *c <= 0.0);
        let quarter_period = columns.iter().filter_map(of).min().unwrap_or(1).max(1);
        Motion { columns, quarter_period }
    }
}

/// The part of the variance of the remainder that follows the motion: what the analogues of each moment foretell, over
/// the half of the moments that have the nearest ones. Chance foretells nothing.
fn of_motion(records: &[Remains<'_>]) -> f64 {
    let points = points(records);
    let mut forecasts: Vec<(f64, f64, f64)> = points
        .par_iter()
        .map(|point| {
            let (distance, foretold) = foretold(point, &points, records[point.record].0.quarter_period);
            (distance, point.left.powi(2), (point.left - foretold).powi(2))
        })
        .collect();
    // The rest of the motion was seen once.
    forecasts.sort_by(|a, b| a.0.total_cmp(&b.0));
    forecasts.truncate(points.len().div_ceil(2));
    let (whole, missed) = forecasts.iter().fold((0.0, 0.0), |sum, of| (sum.0 + of.1, sum.1 + of.2));
    if whole > 0.0 { (1.0 - missed / whole).max(0.0) } else { 0.0 }
}

/// How far the analogues of a moment are on the mean, and the mean of what was left there. The samples about it are no
/// analogues: their noise is its noise (J. Theiler, Phys. Rev. A 34 (1986) 2427-2432).
fn foretold(point: &Point, all: &[Point], lag: usize) -> (f64, f64) {
    let mut nearest = [(f64::INFINITY, 0.0); ANALOGUES];
    let apart = |other: &&Point| other.record != point.record || other.sample.abs_diff(point.sample) > lag;
    for other in all.iter().filter(apart) {
        let pairs = point.history.iter().zip(&other.history);
        let distance: f64 = pairs.map(|(a, b)| (a - b).powi(2)).sum();
        if distance < nearest[ANALOGUES - 1].0 {
            let place = nearest.partition_point(|(near, _)| *near <= distance);
            nearest[place..].rotate_right(1);
            nearest[place] = (distance, other.left);
        }
    }
    let sum = nearest.iter().fold((0.0, 0.0), |sum, of| (sum.0 + of.0, sum.1 + of.1));
    (sum.0 / ANALOGUES as f64, sum.1 / ANALOGUES as f64)
}

fn points(records: &[Remains<'_>]) -> Vec<Point> {
    let samples: usize = records.iter().map(|(_, left)| left.len()).sum();
    let all = records.iter().flat_map(|(_, left)| left.iter());
    let mean = all.map(|(_, left)| left).sum::<f64>() / samples.max(1) as f64;
    let step = samples.div_ceil(ANALOGUE_POINTS).max(1);
    let columns = records.first().map_or(0, |(motion, _)| motion.columns.len());
    let size = |k: usize| {
        let all = records.iter().flat_map(|(motion, _)| motion.columns[k].iter().copied());
        standard_deviation(&all.collect::<Vec<f64>>())
    };
    let sizes: Vec<f64> = (0..columns).map(size).collect();
    let moving: Vec<usize> = (0..columns).filter(|&k| sizes[k] > 0.0).collect();
    let of = |(record, &(motion, left)): (usize, &Remains<'_>)| -> Vec<Point> {
        let lag = motion.quarter_period;
        let history = |sample: usize| {
            let back = (0..ANALOGUE_LAGS).map(move |l| sample - l * lag);
            back.flat_map(|at| moving.iter().map(move |&k| (k, at)))
                .map(|(k, at)| motion.columns[k][at] / sizes[k])
                .collect()
        };
        let known = left.iter().filter(|(sample, _)| *sample >= (ANALOGUE_LAGS - 1) * lag);
        let point =
            |&(sample, left): &_| Point { record, sample, history: history(sample), left: left - mean };
        known.step_by(step).map(point).collect()
    };
    records.iter().enumerate().flat_map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two tones without a common period, sampled fifty times a second.
    fn moving(left: impl FnMut((usize, (f64, f64))) -> f64) -> f64 {
        let time = (0..3000).map(|i| 0.02 * f64::from(i));
        let (x, v): (Vec<f64>, Vec<f64>) =
            time.map(|t| (t.sin() + 0.5 * (2.6 * t).cos(), t.cos() - 1.3 * (2.6 * t).sin())).unzip();
        let moments = x.iter().copied().zip(v.iter().copied()).enumerate();
        let left: Vec<(usize, f64)> = moments.map(left).enumerate().collect();
        of_motion(&[(&Motion::new(vec![x, v]), &left)])
    }

    #[test]
    fn a_law_of_the_motion_is_seen() {
        assert!(moving(|(_, (_, v))| v.signum()) > 0.9);
        assert!(moving(|(_, (x, _))| x.powi(3)) > 0.9);
    }

    #[test]
    fn a_law_that_remembers_is_seen() {
        let mut z = 0.0;
        // Dahl's element: within a tenth of the way it forgets where it was.
        assert!(
            moving(|(_, (_, v))| {
                z += 0.02 * (v - 10.0 * v.abs() * z);
                z
            }) > 0.8
        );
    }

    #[test]
    fn noise_and_a_force_in_time_are_not() {
        let mut state = 0.0;
        let mut random = phisindy_signal::test_signals::gaussian(3000, 7).into_iter();
        assert_eq!(moving(|_| random.next().unwrap_or(0.0)), 0.0);
        let mut random = phisindy_signal::test_signals::gaussian(3000, 8).into_iter();
        assert_eq!(
            moving(|_| {
                state = 0.99 * state + random.next().unwrap_or(0.0);
                state
            }),
            0.0
        );
        assert_eq!(moving(|(i, _)| i as f64), 0.0);
        assert_eq!(moving(|(i, _)| (0.02 * 314.0 * i as f64).sin()), 0.0);
    }
}
