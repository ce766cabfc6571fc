//! Statistics of a single column.

use phisindy_phys::clipped;
use phisindy_signal::{Line, automatic, noise_level_at, standard_deviation, strongest_line};
use std::ops::Range;

/// Most rows for the estimates of noise and stops.
const LONGEST: usize = 200_000;
/// Periods that a stop lasts at least, and samples.
const SHORTEST: f64 = 0.03;
const LEAST: f64 = 5.0;
/// Fewer samples are not averaged: there is nothing to gain.
const FEWEST: usize = 10_000;
/// Most distinct values of a column that selects rows.
const MOST_VALUES: usize = 12;

/// Statistics of a column.
#[derive(Clone, Debug)]
pub struct Statistics {
    /// Least value.
    pub min: f64,
    /// Greatest value.
    pub max: f64,
    /// Standard deviation.
    pub std: f64,
    /// Rows without a number.
    pub missing: usize,
    /// The distinct values in order, if they are few whole numbers.
    pub values: Option<Vec<f64>>,
    /// Number of samples at exactly the minimum or maximum that a moving signal reaches at full speed.
    pub clipped: usize,
    /// Standard deviation of the noise.
    pub noise: f64,
    /// Strongest line of the spectrum, if there is one.
    pub line: Option<Line>,
}

impl Statistics {
    /// Computes the statistics of `values`; noise and line come from the rows `run`, in which `time` does not
    /// go back.
    pub(crate) fn of(time: &[f64], values: &[f64], run: Range<usize>) -> Statistics {
        let good: Vec<f64> = values.iter().copied().filter(|x| x.is_finite()).collect();
        let std = standard_deviation(&good);
        let (min, max) =
            good.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)));
        let run = run.start..run.end.min(run.start + LONGEST);
        let (t, x): (Vec<f64>, Vec<f64>) =
            run.map(|k| (time[k], values[k])).filter(|(t, x)| t.is_finite() && x.is_finite()).unzip();
        let few = few_values(&good);
        let varies = min < max;
        Statistics {
            min,
            max,
            std: if varies { std } else { 0.0 },
            missing: values.len() - good.len(),
            clipped: if few.is_some() { 0 } else { clipped(&good, min, max) },
            noise: if varies && few.is_none() { noise_level_at(&t, &x) } else { 0.0 },
            line: if varies && few.is_none() { strongest_line(&t, &x) } else { None },
            values: few,
        }
    }

    /// Whether the column holds one value only, or none.
    pub(crate) fn is_constant(&self) -> bool {
        // The minimum of an empty column is infinite.
        self.min >= self.max
    }
}

/// The distinct values in order, if they are few whole numbers.
fn few_values(values: &[f64]) -> Option<Vec<f64>> {
    let mut seen: Vec<f64> = Vec::new();
    for &x in values {
        if !seen.contains(&x) {
            if x.fract() != 0.0 || seen.len() == MOST_VALUES {
                return None;
            }
            seen.push(x);
        }
    }
    seen.sort_by(f64::total_cmp);
    Some(seen)
}

/// Where a motion is at rest.
#[derive(Clone, Debug, Default)]
pub struct Stops {
    /// Rows of each stop.
    pub stretches: Vec<Range<usize>>,
    /// Fraction of the rows that are at rest.
    pub fraction: f64,
}

/// Finds the stretches at rest. There the smoothed speed stays below two per cent of its 98th percentile, or
/// below three standard errors (at most five per cent), for longer than a turning point takes.
pub(crate) fn stops(time: &[f64], values: &[f64], frequency: Option<f64>) -> Stops {
    let n = time.len().min(values.len()).min(LONGEST);
    if n == 0 {
        return Stops::default();
    }
    let block = frequency.map_or(1, |f| {
        let step = (time[n - 1] - time[0]) / (n - 1).max(1) as f64;
        // The work of the derivative grows with the samples: the shortest stop keeps five.
        (SHORTEST / f / step / LEAST) as usize
    });
    if block > 1 && n / block > FEWEST {
        let mean = |x: &[f64]| {
            x.chunks_exact(block).map(|c| c.iter().sum::<f64>() / block as f64).collect::<Vec<_>>()
        };
        let coarse = stops(&mean(&time[..n]), &mean(&values[..n]), frequency);
        let stretches = coarse.stretches.iter().map(|s| s.start * block..s.end * block).collect();
        return Stops { stretches, ..coarse };
    }
    let Ok(smooth) = automatic(&time[..n], &values[..n]) else { return Stops::default() };
    let speeds: Vec<f64> = smooth.derivative.iter().map(|v| v.abs()).collect();
    let mut sorted = speeds.clone();
    sorted.sort_by(f64::total_cmp);
    let fast = sorted[(n * 98 / 100).min(n - 1)];
    let level = (0.02 * fast).max((3.0 * smooth.std_error).min(0.05 * fast));
    let step = (time[n - 1] - time[0]) / (n - 1) as f64;
    // A sine is slower than two per cent of its greatest speed for 1.3 per cent of a period, half of it at
    // each turning point.
    let least = frequency.map_or(8.0, |f| SHORTEST / f / step).max(LEAST) as usize;
    let mut stretches = Vec::new();
    let mut k = 0;
    while k < n {
        if speeds[k] > level {
            k += 1;
            continue;
        }
        let end = (k..n).find(|&j| speeds[j] > level).unwrap_or(n);
        if end - k >= least {
            stretches.push(k..end);
        }
        k = end;
    }
    let fraction = stretches.iter().map(|s| s.len()).sum::<usize>() as f64 / n as f64;
    Stops { stretches, fraction }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sine(n: usize) -> (Vec<f64>, Vec<f64>) {
        let time: Vec<f64> = (0..n).map(|k| 0.01 * k as f64).collect();
        let x = time.iter().map(|t| (std::f64::consts::TAU * t).sin()).collect();
        (time, x)
    }

    #[test]
    fn a_cut_sine_is_clipped_and_a_whole_one_is_not() {
        let (time, x) = sine(1000);
        assert_eq!(Statistics::of(&time, &x, 0..1000).clipped, 0);
        let cut: Vec<f64> = x.iter().map(|x| x.clamp(-0.8, 0.8)).collect();
        assert!(Statistics::of(&time, &cut, 0..1000).clipped > 200);
    }

    #[test]
    fn a_sine_does_not_stop_and_pauses_do() {
        let (time, x) = sine(1000);
        assert_eq!(stops(&time, &x, Some(1.0)).stretches.len(), 0);
        // Half a period takes 0.4 s, followed by 0.1 s at rest.
        let resting: Vec<f64> = time
            .iter()
            .map(|t| {
                let half = (2.0 * t).fract() / 2.0;
                let x = (std::f64::consts::PI * (half / 0.4).min(1.0)).cos();
                if t.fract() < 0.5 { x } else { -x }
            })
            .collect();
        let stops = stops(&time, &resting, Some(1.0));
        assert!(stops.stretches.len() > 15 && stops.fraction > 0.1 && stops.fraction < 0.35, "{stops:?}");
    }

    #[test]
    fn a_selector_has_few_whole_values() {
        let (time, x) = sine(100);
        assert!(Statistics::of(&time, &x, 0..100).values.is_none());
        let flag: Vec<f64> = (0..100).map(|k| f64::from(k > 50)).collect();
        assert_eq!(Statistics::of(&time, &flag, 0..100).values, Some(vec![0.0, 1.0]));
        assert!(Statistics::of(&time, &[4.0; 100], 0..100).is_constant());
    }
}
