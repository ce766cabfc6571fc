//! Jumps of level: a displacement that changes from one sample to the next and stays there. A slipping sensor
//! does that, no body does.

use super::scatter;
use phisindy_signal::median;

/// Without a velocity a jump is a step of this many times the scatter of the samples ...
const JUMP: f64 = 10.0;
/// ... and this many times the deviation of the steps beside it ...
const ABRUPT: f64 = 4.0;
/// ... and more than the motion covers in this many steps: less is a sample that was taken late or lost,
/// which shifts the curve in time and not in level.
const LATE: f64 = 2.0;
/// More than one jump in this many samples, or a step that the motion does more often, is motion.
const RARE: usize = 200;
/// With a measured velocity the level is the median over this many samples on either side.
pub(super) const LEVEL: usize = 20;
/// A jump is this many times the scatter of the levels ...
const SHIFT: f64 = 8.0;
/// ... and this many times the largest displacement in one step.
const STEPS: f64 = 3.0;

/// The samples before the jumps of a displacement `x`; `v` is its measured velocity.
pub(super) fn jumps(time: &[f64], x: &[f64], v: Option<&[f64]>) -> Vec<usize> {
    let n = x.len();
    let all = v.map_or_else(|| abrupt(time, x), |v| shifted(time, x, v));
    // Frequent jumps are a motion that is sampled too coarsely.
    if all.len() * RARE <= n { all } else { vec![] }
}

/// Steps far larger than those beside them.
fn abrupt(time: &[f64], x: &[f64]) -> Vec<usize> {
    let least = scatter::of(x);
    let steps: Vec<f64> = x.windows(2).map(|w| w[1] - w[0]).collect();
    let lengths: Vec<f64> = time.windows(2).map(|w| w[1] - w[0]).collect();
    let usual = median(&mut lengths.clone());
    let off = |k: usize| {
        let beside = [k - 3, k - 2, k - 1, k + 1, k + 2, k + 3].map(|j| steps[j]);
        let trend = median(&mut beside.clone());
        let size = (steps[k] - trend).abs();
        let largest = |of: &dyn Fn(f64) -> f64| beside.iter().map(|s| of(*s).abs()).fold(0.0, f64::max);
        let jumps = lengths[k] < 1.5 * usual
            && size > JUMP * least
            && size > ABRUPT * largest(&|s| s - trend)
            && size > LATE * largest(&|s| s);
        (k, size, jumps)
    };
    let all: Vec<(usize, f64, bool)> = (3..steps.len().saturating_sub(3)).map(off).collect();
    let usual = scatter::rarely(all.iter().map(|(_, size, _)| *size).collect(), RARE);
    all.into_iter().filter(|(_, size, jumps)| *jumps && *size >= usual).map(|(k, ..)| k).collect()
}

/// Samples after which the level of `x` less the integral of `v` changes.
fn shifted(time: &[f64], x: &[f64], v: &[f64]) -> Vec<usize> {
    let n = x.len();
    if n < 8 * LEVEL {
        return vec![];
    }
    let mut integral = 0.0;
    let mut rest = vec![x[0]];
    for k in 1..n {
        integral += 0.5 * (v[k] + v[k - 1]) * (time[k] - time[k - 1]);
        rest.push(x[k] - integral);
    }
    let level = |from: usize| median(&mut rest[from..from + LEVEL].to_vec());
    let shift = |k: usize| level(k + 1) - level(k + 1 - LEVEL);
    let coarse: Vec<(usize, f64)> =
        (LEVEL - 1..n - LEVEL).step_by(LEVEL / 4).map(|k| (k, shift(k).abs())).collect();
    let scatter = median(&mut coarse.iter().map(|(_, s)| *s).collect::<Vec<f64>>()) / 0.6745;
    let fastest = v.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let longest = |k: usize| (k + 1 - LEVEL..k + LEVEL).map(|j| time[j + 1] - time[j]).fold(0.0, f64::max);
    let told = |k: usize, size: f64| {
        size > SHIFT * scatter
            && size > STEPS * fastest * longest(k)
            && size > STEPS * scatter::near(x, k, LEVEL)
    };
    let mut all: Vec<usize> = Vec::new();
    for &(k, size) in coarse.iter().filter(|(k, size)| told(*k, *size)) {
        // The largest single step near the largest shift.
        let near = (k.max(2 * LEVEL) - LEVEL..(k + LEVEL).min(n - LEVEL)).max_by(|a, b| {
            let own = |j: usize| (rest[j + 1] - rest[j]).abs();
            own(*a).total_cmp(&own(*b))
        });
        let steps = |at: &usize| {
            let whole = shift(*at);
            told(*at, whole.abs()) && whole.abs() > 0.8 * size && (rest[at + 1] - rest[*at]) / whole > 0.5
        };
        if let Some(at) = near.filter(steps)
            && all.last().is_none_or(|last| at > last + LEVEL)
        {
            all.push(at);
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use phisindy_signal::test_signals::{gaussian, stick_slip};

    /// Time, displacement and velocity of a harmonic motion with noise of this standard deviation.
    fn swing(noise: f64) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let time: Vec<f64> = (0..3000).map(|i| 0.01 * f64::from(i)).collect();
        let noisy = |seed: u64, f: fn(f64) -> f64| {
            time.iter().zip(gaussian(3000, seed)).map(|(t, e)| f(*t) + noise * e).collect()
        };
        let (x, v) = (noisy(3, |t| (3.0 * t).sin()), noisy(4, |t| 3.0 * (3.0 * t).cos()));
        (time, x, v)
    }

    #[test]
    fn a_level_that_shifts_is_told() {
        for (noise, size) in [(0.0, 0.3), (0.01, 0.3), (0.05, 1.0)] {
            let (time, mut x, v) = swing(noise);
            x[1234..].iter_mut().for_each(|x| *x += size);
            assert_eq!(jumps(&time, &x, None), [1233], "{noise}");
            assert_eq!(jumps(&time, &x, Some(&v)), [1233], "{noise}");
        }
        // Six times the noise is detected only with a velocity.
        let (time, mut x, v) = swing(0.05);
        x[1234..].iter_mut().for_each(|x| *x += 0.3);
        assert_eq!(jumps(&time, &x, None), []);
        let told = jumps(&time, &x, Some(&v));
        assert!(told.len() == 1 && told[0].abs_diff(1233) < LEVEL, "{told:?}");
    }

    /// A laser whose samples are taken late now and then: each shifts the curve by a part of one step.
    #[test]
    fn late_samples_are_no_jumps() {
        let (time, ..) = swing(0.0);
        let late = |k: usize| if k % 97 == 40 { 0.009 } else { 0.0 };
        let mut clock = 0.0;
        let x: Vec<f64> = (0..3000)
            .map(|k| {
                clock += late(k);
                (3.0 * (time[k] + clock)).sin()
            })
            .collect();
        let noisy: Vec<f64> = x.iter().zip(gaussian(3000, 6)).map(|(x, e)| x + 2e-5 * e).collect();
        assert_eq!((jumps(&time, &x, None), jumps(&time, &noisy, None)), (vec![], vec![]));
    }

    #[test]
    fn fast_motion_spikes_and_holes_are_no_jumps() {
        let (time, x, v) = swing(0.02);
        assert_eq!((jumps(&time, &x, None), jumps(&time, &x, Some(&v))), (vec![], vec![]));
        let mut spiked = x.clone();
        spiked[700] = 5.0;
        assert_eq!((jumps(&time, &spiked, None), jumps(&time, &spiked, Some(&v))), (vec![], vec![]));
        let cut = |c: &[f64]| [&c[..1000], &c[1100..]].concat();
        assert_eq!(jumps(&cut(&time), &cut(&x), None), []);
        assert_eq!(jumps(&cut(&time), &cut(&x), Some(&cut(&v))), []);
        // Slip phases of four samples.
        let slips: Vec<f64> = (0..3000)
            .map(|i| (i / 100) as f64 + [0.0, 0.15, 0.5, 0.85].get(i % 100).copied().unwrap_or(1.0))
            .collect();
        assert_eq!(jumps(&time, &slips, None), []);
        let (time, x, v) = stick_slip();
        assert_eq!((jumps(&time, &x, None), jumps(&time, &x, Some(&v))), (vec![], vec![]));
        // Impacts at which the velocity reverses between two samples.
        let (time, ..) = swing(0.0);
        let bounce: Vec<f64> = time.iter().map(|t| (3.0 * t).sin().abs()).collect();
        let turns: Vec<f64> = time.iter().map(|t| 3.0 * (3.0 * t).cos() * (3.0 * t).sin().signum()).collect();
        assert_eq!(jumps(&time, &bounce, Some(&turns)), []);
    }
}
