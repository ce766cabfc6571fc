//! Local cubics by least squares (A. Savitzky and M. Golay 1964, doi 10.1021/ac60214a047): value, slope and
//! curvature of a measured column, smoothed just enough for a picture.

use phisindy_signal::{mean_step, strongest_line};

/// Least and most samples of a window at each side of its middle.
const SIDES: (usize, usize) = (3, 400);
/// The window grows until the noise of the force is this part of the largest force.
const GOAL: f64 = 0.05;
/// No window is longer than this part of the main period: a cubic does not follow more.
const PART: f64 = 0.125;

/// A column with a window.
pub(crate) struct LocalCubic<'a> {
    time: &'a [f64],
    values: &'a [f64],
    side: usize,
    step: f64,
}

impl<'a> LocalCubic<'a> {
    /// With a window that suits the noise. `noise` is the standard deviation of a sample times the inertia
    /// over the largest force; `twice` says that the second derivative is wanted, otherwise the first. `None`
    /// for too few samples.
    pub(crate) fn new(time: &'a [f64], values: &'a [f64], noise: f64, twice: bool) -> Option<LocalCubic<'a>> {
        let step = mean_step(time);
        let period = strongest_line(time, values).map_or(f64::INFINITY, |l| 1.0 / l.frequency);
        let most = ((0.5 * PART * period / step) as usize).clamp(SIDES.0, SIDES.1);
        if time.len() < 4 * SIDES.0 || step.is_nan() || step <= 0.0 {
            return None;
        }
        let with = |side: usize| LocalCubic { time, values, side, step };
        let error = |side: &usize| noise * with(*side).error(1 + usize::from(twice));
        Some(with((SIDES.0..most).find(|side| error(side) <= GOAL).unwrap_or(most)))
    }

    /// Standard deviation of its value (0), slope (1) or curvature (2) over that of a sample: of a parabola through n
    /// samples 1/sqrt(n), sqrt(12/n^3) and sqrt(720/n^5), per step and per step squared (Savitzky and Golay 1964).
    pub(crate) fn error(&self, order: usize) -> f64 {
        let n = (2 * self.side + 1) as f64;
        match order {
            0 => n.powf(-0.5),
            1 => 12f64.sqrt() / n.powf(1.5) / self.step,
            _ => 720f64.sqrt() / n.powf(2.5) / self.step.powi(2),
        }
    }

    /// Half the length of the window (s).
    pub(crate) fn half_width(&self) -> f64 {
        self.side as f64 * self.step
    }

    /// Value, slope and curvature at a sample; `None` near the ends of the record.
    pub(crate) fn at(&self, i: usize) -> Option<[f64; 3]> {
        let from = i.checked_sub(self.side)?;
        let window = from..(i + self.side < self.time.len()).then_some(i + self.side + 1)?;
        let scale = self.half_width();
        // Normal equations of 1, u, u^2, u^3 with u = (t - t_i)/scale, with the right side as a fifth column.
        let mut rows = [[0.0; 5]; 4];
        for k in window {
            let u = (self.time[k] - self.time[i]) / scale;
            let powers = [1.0, u, u * u, u * u * u, self.values[k] - self.values[i]];
            for (a, row) in rows.iter_mut().enumerate() {
                row.iter_mut().zip(powers).for_each(|(cell, p)| *cell += powers[a] * p);
            }
        }
        let [value, slope, curvature, _] = solved(rows)?;
        Some([value + self.values[i], slope / scale, 2.0 * curvature / scale.powi(2)])
    }
}

/// Gaussian elimination of a positive definite system of four equations.
fn solved(mut rows: [[f64; 5]; 4]) -> Option<[f64; 4]> {
    for k in 0..4 {
        let pivot = rows[k];
        if pivot[k].is_nan() || pivot[k] <= 0.0 {
            return None;
        }
        for row in rows.iter_mut().skip(k + 1) {
            let factor = row[k] / pivot[k];
            row.iter_mut().zip(pivot).for_each(|(cell, p)| *cell -= factor * p);
        }
    }
    let mut out = [0.0; 4];
    for k in (0..4).rev() {
        let known: f64 = (k + 1..4).map(|j| rows[k][j] * out[j]).sum();
        out[k] = (rows[k][4] - known) / rows[k][k];
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_is_followed_exactly_on_an_uneven_grid() {
        let time: Vec<f64> = (0..60).map(|k| 0.01 * f64::from(k) + 0.002 * f64::from(k % 3)).collect();
        let values: Vec<f64> = time.iter().map(|t| 1.0 + 2.0 * t - 3.0 * t * t + 4.0 * t.powi(3)).collect();
        let cubic = LocalCubic::new(&time, &values, 1e-9, true).expect("enough samples");
        let t = time[30];
        let due = [values[30], 2.0 - 6.0 * t + 12.0 * t * t, -6.0 + 24.0 * t];
        for (is, due) in cubic.at(30).expect("inside").into_iter().zip(due) {
            assert!((is - due).abs() < 1e-9, "{is} {due}");
        }
        assert!(cubic.at(0).is_none() && cubic.at(59).is_none());
    }

    #[test]
    fn more_noise_makes_a_longer_window_up_to_a_part_of_the_period() {
        let time: Vec<f64> = (0..2000).map(|k| 0.001 * f64::from(k)).collect();
        let values: Vec<f64> = time.iter().map(|t| (10.0 * t).sin()).collect();
        let width = |noise: f64| LocalCubic::new(&time, &values, noise, true).expect("samples").half_width();
        let period = std::f64::consts::TAU / 10.0;
        assert!(width(1e-9) < width(1e-6) && width(1e-6) <= width(1.0));
        assert!(width(1.0) <= 0.5 * PART * period + 1e-3);
    }
}
