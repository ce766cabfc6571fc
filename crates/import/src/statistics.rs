//! What the numbers of one column look like.

use phisindy_phys::clipped;
use phisindy_signal::{Line, automatic, noise_level, standard_deviation, strongest_line};
use std::ops::Range;

/// Noise and stops are estimated on at most so many rows.
const LONGEST: usize = 200_000;
/// More values than this are no selector.
const MOST_VALUES: usize = 12;

/// Statistics of a column.
#[derive(Clone, Debug)]
pub struct Statistics {
    /// Least value.
    pub(crate) min: f64,
    /// Greatest value.
    pub(crate) max: f64,
    /// Standard deviation.
    pub(crate) std: f64,
    /// Rows without a number.
    pub(crate) missing: usize,
    /// The values, if they are few whole numbers.
    pub(crate) values: Option<Vec<f64>>,
    /// How often the value stands at exactly its extremes while it arrives there in full motion.
    pub(crate) clipped: usize,
    /// Standard deviation of the noise.
    pub(crate) noise: f64,
    /// The strongest line of the spectrum.
    pub(crate) line: Option<Line>,
}

impl Statistics {
    /// Statistics of `values` over `time`, of which `run` is one stretch without a jump.
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
            noise: if varies && few.is_none() { noise_level(&x) } else { 0.0 },
            line: if varies && few.is_none() { strongest_line(&t, &x) } else { None },
            values: few,
        }
    }

    /// Whether nothing ever happens here.
    pub(crate) fn is_dead(&self) -> bool {
        // An empty column has infinity as its least value.
        self.min >= self.max
    }
}

/// The values in order, if they are few and whole.
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

/// Where a motion stands still.
#[derive(Clone, Debug, Default)]
pub struct Stops {
    /// Rows of each stop.
    pub(crate) stretches: Vec<Range<usize>>,
    /// Part of the record, from 0 to 1.
    pub(crate) part: f64,
}

/// The stretches in which a column does not move: its smoothed speed stays below two per cent of its usual greatest one, or below what
/// the noise can do, for longer than a turning point lasts.
pub(crate) fn stops(time: &[f64], values: &[f64], frequency: Option<f64>) -> Stops {
    let n = time.len().min(values.len()).min(LONGEST);
    let Ok(smooth) = automatic(&time[..n], &values[..n]) else { return Stops::default() };
    let speeds: Vec<f64> = smooth.derivative.iter().map(|v| v.abs()).collect();
    let mut sorted = speeds.clone();
    sorted.sort_by(f64::total_cmp);
    let fast = sorted[(n * 98 / 100).min(n - 1)];
    let level = (0.02 * fast).max((3.0 * smooth.std_error).min(0.05 * fast));
    let step = (time[n - 1] - time[0]) / (n - 1) as f64;
    // At its turning points a sine is slower than two per cent of its greatest speed for 1.3 per cent of a period, each time for half of that.
    let least = frequency.map_or(8.0, |f| 0.03 / f / step).max(5.0) as usize;
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
    let part = stretches.iter().map(|s| s.len()).sum::<usize>() as f64 / n as f64;
    Stops { stretches, part }
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
    fn a_sine_does_not_stop_and_held_ends_do() {
        let (time, x) = sine(1000);
        assert_eq!(stops(&time, &x, Some(1.0)).stretches.len(), 0);
        // From end to end in 0.4 s, a tenth of a second at rest there.
        let held: Vec<f64> = time
            .iter()
            .map(|t| {
                let half = (2.0 * t).fract() / 2.0;
                let x = (std::f64::consts::PI * (half / 0.4).min(1.0)).cos();
                if t.fract() < 0.5 { x } else { -x }
            })
            .collect();
        let found = stops(&time, &held, Some(1.0));
        assert!(found.stretches.len() > 15 && found.part > 0.1 && found.part < 0.35, "{found:?}");
    }

    #[test]
    fn a_selector_has_few_whole_values() {
        let (time, x) = sine(100);
        assert!(Statistics::of(&time, &x, 0..100).values.is_none());
        let flag: Vec<f64> = (0..100).map(|k| f64::from(k > 50)).collect();
        assert_eq!(Statistics::of(&time, &flag, 0..100).values, Some(vec![0.0, 1.0]));
        assert!(Statistics::of(&time, &[4.0; 100], 0..100).is_dead());
    }
}
