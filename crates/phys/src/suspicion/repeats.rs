//! Columns that repeat each value for several samples: the logger is faster than the sensor.

/// Fewer runs of equal values tell nothing.
const MIN_RUNS: usize = 30;
/// Percentage of the runs that have the usual length, or one sample more.
const USUAL_PERCENT: usize = 90;
/// Below this percentage of steps with one height a column is not merely quantised.
const QUANTISED_PERCENT: usize = 50;

/// The number of samples for which a column holds each value, if it is more than one.
pub(super) fn repeats(column: &[f64]) -> Option<usize> {
    let mut edges: Vec<usize> = (1..column.len()).filter(|&k| column[k] != column[k - 1]).collect();
    // The first and the last run may be incomplete.
    if edges.len() < MIN_RUNS + 1 {
        return None;
    }
    let mut lengths: Vec<usize> = edges.windows(2).map(|w| w[1] - w[0]).collect();
    lengths.sort_unstable();
    let shortest = lengths[lengths.len() / 20];
    let usual = lengths.iter().filter(|n| (shortest..=shortest + 1).contains(*n)).count();
    if shortest < 2 || 100 * usual < USUAL_PERCENT * lengths.len() {
        return None;
    }
    let height = |&k: &usize| (column[k] - column[k - 1]).abs();
    edges.sort_unstable_by(|a, b| height(a).total_cmp(&height(b)));
    let middle = height(&edges[edges.len() / 2]);
    let alike = edges.iter().filter(|k| (height(k) - middle).abs() < 1e-3 * middle).count();
    (100 * alike < QUANTISED_PERCENT * edges.len()).then_some(lengths[lengths.len() / 2])
}

#[cfg(test)]
mod tests {
    use super::*;
    use phisindy_signal::test_signals::{gaussian, stick_slip};

    fn swing(noise: f64) -> Vec<f64> {
        gaussian(3000, 5).iter().enumerate().map(|(i, e)| (0.03 * i as f64).sin() + noise * e).collect()
    }

    /// The values that were there when they were read, each so many samples later at most.
    fn zero_order_hold(x: &[f64], length: impl Fn(usize) -> usize) -> Vec<f64> {
        let mut out = Vec::new();
        while out.len() < x.len() {
            out.extend(vec![x[out.len()]; length(out.len())]);
        }
        out.truncate(x.len());
        out
    }

    fn rounded(x: &[f64], step: f64) -> Vec<f64> {
        x.iter().map(|v| (v / step).round() * step).collect()
    }

    #[test]
    fn each_value_held_is_told() {
        for noise in [0.0, 0.02] {
            let x = swing(noise);
            assert_eq!(repeats(&zero_order_hold(&x, |_| 4)), Some(4));
            assert_eq!(repeats(&zero_order_hold(&x, |_| 2)), Some(2));
            // Read each 50 ms, written each 20 ms.
            assert_eq!(repeats(&zero_order_hold(&x, |k| 2 + k % 2)), Some(2));
            assert_eq!(repeats(&zero_order_hold(&rounded(&x, 1e-3), |_| 4)), Some(4));
        }
    }

    #[test]
    fn rounding_rest_and_switches_are_not() {
        let (_, resting, speed) = stick_slip();
        let ramp: Vec<f64> = (0..3000).map(|i| f64::from(i) * 1e-3).collect();
        let switched: Vec<f64> = (0..3000).map(|i| f64::from(i / 10 % 2)).collect();
        let columns = [
            swing(0.0),
            swing(0.02),
            rounded(&swing(0.0), 0.1),
            rounded(&swing(0.02), 0.1),
            rounded(&ramp, 4e-3),
            rounded(&resting, 0.02),
            resting,
            speed,
            switched,
        ];
        for (k, column) in columns.iter().enumerate() {
            assert_eq!(repeats(column), None, "{k}");
        }
    }
}
