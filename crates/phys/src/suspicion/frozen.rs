//! Frozen stretches: a logger repeats its last value.

use super::scatter;
use phisindy_signal::{bounds, noise_level, quantum, rounding_error, standard_deviation};
use std::ops::Range;

/// Fewer equal samples are not frozen.
const SHORTEST: usize = 5;
/// Runs that occur by chance in one of this many records are not frozen either.
const CHANCE: f64 = 1e6;
/// A sensor whose noise is below this part of its motion may show a body at rest as one value.
const OWN: f64 = 1e-3;
/// The noise beside a stretch is taken over this many samples on either side ...
const BESIDE: usize = 6;
/// ... and is this many counts of the sensor: an encoder has none at rest or where it turns.
const COUNTS: f64 = 3.0;
/// A step of this many times those beside it returns to the motion.
const CATCH_UP: f64 = 4.0;

/// Stretches of equal values that a body at rest does not explain: the column has noise everywhere else, or
/// jumps at their ends.
pub(super) fn frozen(column: &[f64]) -> Vec<Range<usize>> {
    let n = column.len();
    let (min, max) = bounds(column);
    let mut runs: Vec<Range<usize>> = Vec::new();
    let mut k = 0;
    while k < n {
        let end = (k..n).find(|&j| column[j] != column[k]).unwrap_or(n);
        runs.push(k..end);
        k = end;
    }
    // The share of repeated values: large for a coarse sensor.
    let repeated = runs.iter().filter(|r| r.len() > 1).count();
    let often = (repeated + 1) as f64 / (runs.len() + 1) as f64;
    let by_chance = |r: &Range<usize>| (CHANCE * n as f64).ln() / -often.max(repeats_beside(column, r)).ln();
    let noise = noise_level(column);
    let own = OWN * standard_deviation(column);
    let noisy = noise > 2.0 * rounding_error(column) && noise > own;
    let count = quantum(column, 2).unwrap_or(0.0);
    let frozen = |r: &Range<usize>| {
        let value = column[r.start];
        let noisy = noisy && noise_beside(column, r) > own.max(COUNTS * count);
        let long = r.len() >= SHORTEST && (r.len() - 1) as f64 > by_chance(r);
        // Clipped columns repeat their extremes. Noise that grows with the motion vanishes at zero.
        long && value != min && value != max && (noisy && value != 0.0 || catches_up(column, r))
    };
    runs.into_iter().filter(|r| r.len() < n && frozen(r)).collect()
}

/// The share of repeated values beside a stretch: a coarse sensor repeats them where the motion turns.
fn repeats_beside(column: &[f64], stretch: &Range<usize>) -> f64 {
    let reach = (3 * stretch.len()).max(BESIDE);
    let before = stretch.start.saturating_sub(reach).max(1)..stretch.start;
    let after = stretch.end + 1..(stretch.end + reach).min(column.len());
    let (mut all, mut repeated) = (0_usize, 0_usize);
    for k in before.chain(after) {
        all += 1;
        repeated += usize::from(column[k] == column[k - 1]);
    }
    repeated as f64 / all.max(1) as f64
}

/// Noise of the samples beside a stretch, on the side where there is less of it. A body that comes to rest
/// has hardly any there, if its sensor shows none at rest.
fn noise_beside(column: &[f64], stretch: &Range<usize>) -> f64 {
    let before = stretch.start.saturating_sub(BESIDE)..stretch.start;
    let after = stretch.end..(stretch.end + BESIDE).min(column.len());
    let sides = [before, after].into_iter().filter(|side| side.len() == BESIDE);
    sides.map(|side| scatter::within(column, side)).fold(f64::INFINITY, f64::min)
}

/// Whether the motion went on meanwhile: the step out of the stretch is many times those beside it. A large step into
/// it alone is a body that slips and comes to rest.
fn catches_up(column: &[f64], stretch: &Range<usize>) -> bool {
    if stretch.start < 5 || stretch.end + 5 > column.len() {
        return false;
    }
    let step = |k: usize| (column[k] - column[k - 1]).abs();
    let beside = |range: Range<usize>| range.map(step).fold(0.0, f64::max);
    let usual = beside(stretch.start - 4..stretch.start).max(beside(stretch.end + 1..stretch.end + 5));
    // A body at rest before its motion begins is not frozen.
    usual > 0.0 && beside(stretch.start - 4..stretch.start) > 0.0 && step(stretch.end) > CATCH_UP * usual
}

#[cfg(test)]
mod tests {
    use super::*;
    use phisindy_signal::test_signals::{gaussian, stick_slip};

    /// A harmonic motion with noise of this standard deviation.
    fn swing(noise: f64) -> Vec<f64> {
        let swing = |i: usize| (0.03 * i as f64).sin();
        gaussian(3000, 5).iter().enumerate().map(|(i, e)| swing(i) + noise * e).collect()
    }

    fn holding(mut x: Vec<f64>, stretches: &[Range<usize>]) -> Vec<f64> {
        for r in stretches {
            let value = x[r.start];
            x[r.clone()].fill(value);
        }
        x
    }

    #[test]
    fn repeated_values_are_told() {
        let stretches = [500..540, 1200..1206, 2000..2030];
        assert_eq!(frozen(&holding(swing(0.02), &stretches)), stretches);
        // Without noise, by the way back to the motion: in a turning point there is none.
        assert_eq!(frozen(&holding(swing(0.0), &[1250..1290, 2000..2030])), [1250..1290, 2000..2030]);
        // A sensor that drops out.
        let mut x = swing(0.02);
        x[700..706].fill(0.0);
        assert_eq!(frozen(&x), vec![700..706; 1]);
    }

    /// An encoder whose noise comes from its clock: none at rest, and few counts at a turning point.
    #[test]
    fn stops_and_turning_points_of_encoders_are_not_told() {
        let noise = gaussian(6000, 4);
        // Half a swing, then a rest as long as that, and so on to ever smaller swings.
        let moved = |t: f64| {
            let (half, part) = ((t / 400.0).floor(), (t % 400.0 / 200.0).min(1.0));
            let end = |k: f64| 0.7 * (-0.9_f64).powi(k as i32);
            let (from, to) = (end(half), end(half + 1.0));
            0.5 * (from + to) + 0.5 * (from - to) * (std::f64::consts::PI * part).cos()
        };
        let late = |i: usize| (i as f64 + 0.6 * noise[i]).max(0.0);
        for count in [1.5e-3, 1e-5] {
            let stick: Vec<f64> = (0..6000).map(|i| (moved(late(i)) / count).round() * count).collect();
            assert_eq!(frozen(&stick), [], "{count}");
        }
        // It creeps by counts, slips by six of them, and rests.
        let creeps = |i: usize| match i % 400 {
            k @ 0..200 => (k / 10) as f64,
            _ => 26.0,
        };
        let slips: Vec<f64> = (0..4000).map(|i| 4e-4 * (creeps(i) + 26.0 * (i / 400) as f64)).collect();
        assert_eq!(frozen(&slips), []);
        // The difference quotient of an encoder in steps of 0.47, which flickers in motion.
        let speed = |i: usize| 2.9 * (0.02 * i as f64).sin() * (1.0 - 1.5e-4 * i as f64) + 0.2 * noise[i];
        let quotient: Vec<f64> = (0..6000).map(|i| (speed(i) / 0.47).round() * 0.47).collect();
        assert_eq!(frozen(&quotient), []);
    }

    #[test]
    fn rest_and_coarse_steps_are_not_told() {
        let round =
            |x: Vec<f64>, step: f64| x.iter().map(|v| (v / step).round() * step).collect::<Vec<f64>>();
        let clamped: Vec<f64> = swing(0.02).iter().map(|v| v.clamp(-0.9, 0.9)).collect();
        let (_, resting, speed) = stick_slip();
        // Noise that grows with the speed, of a body that sticks half of the time.
        let slips = |i: usize| {
            let s = (0.03 * i as f64).sin();
            s.signum() * (s.abs() - 0.5).max(0.0)
        };
        let relative =
            gaussian(3000, 9).iter().enumerate().map(|(i, e)| slips(i) * (1.0 + 0.1 * e)).collect();
        let columns = [
            swing(0.02),
            swing(0.0),
            round(swing(0.02), 0.1),
            round(swing(0.0), 0.1),
            round(swing(0.02), 1e-3),
            clamped,
            round(resting.clone(), 0.02),
            resting,
            speed,
            relative,
            (0..3000).map(slips).collect(),
        ];
        for (k, column) in columns.iter().enumerate() {
            assert_eq!(frozen(column), [], "{k}");
        }
    }
}
