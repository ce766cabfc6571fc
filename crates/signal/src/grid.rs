//! Time grids: their step, and columns on a uniform one.

/// The mean step of a time grid.
///
/// # Panics
/// Fewer than two samples.
///
/// ```
/// assert_eq!(phisindy_signal::mean_step(&[0.0, 1.0, 3.0]), 1.5);
/// ```
pub fn mean_step(time: &[f64]) -> f64 {
    (time[time.len() - 1] - time[0]) / (time.len() - 1) as f64
}

/// The step of a grid that is uniform to `tolerance` (a part of the step); none for an empty grid.
pub(crate) fn uniform_step(time: &[f64], tolerance: f64) -> Option<f64> {
    let first = time.first()?;
    let step = mean_step(time);
    let even = time.iter().enumerate().all(|(i, t)| (t - first - i as f64 * step).abs() <= tolerance * step);
    even.then_some(step)
}

/// A column at `n` times from the first one on, `step` apart, by straight lines between its samples.
pub(crate) fn linear_resampled(time: &[f64], values: &[f64], step: f64, n: usize) -> Vec<f64> {
    let mut even = Vec::with_capacity(n);
    let mut k = 0;
    for i in 0..n {
        let t = time[0] + i as f64 * step;
        while k + 2 < time.len() && time[k + 1] < t {
            k += 1;
        }
        let part = ((t - time[k]) / (time[k + 1] - time[k])).clamp(0.0, 1.0);
        even.push(values[k] + part * (values[k + 1] - values[k]));
    }
    even
}

/// Samples at other times that increase, on the straight line between two neighbours; exact where a time is that of a
/// sample.
///
/// ```
/// assert_eq!(phisindy_signal::on_straight_lines(&[0.0, 1.0, 3.0], &[0.0, 2.0, 6.0], &[0.5, 1.0, 2.0]), [1.0, 2.0, 4.0]);
/// ```
pub fn on_straight_lines(from: &[f64], values: &[f64], to: &[f64]) -> Vec<f64> {
    let mut k = 0;
    let at = |t: &f64| {
        while k + 2 < from.len() && from[k + 1] <= *t {
            k += 1;
        }
        match from.get(k + 1) {
            _ if *t == from[k] => values[k],
            Some(next) if t == next => values[k + 1],
            Some(next) => values[k] + (t - from[k]) / (next - from[k]) * (values[k + 1] - values[k]),
            None => f64::NAN,
        }
    };
    to.iter().map(at).collect()
}
