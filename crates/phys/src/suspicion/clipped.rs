//! Columns that are cut off at the end of a sensor's range.

/// A ramp has this many steps, equal to this part of one: a sine has such only in many thousands of samples a
/// period.
const RAMP: isize = 6;
const STRAIGHT: f64 = 1e-3;
/// Samples over which a motion is followed to the end of the range.
const APPROACH: usize = 4;

/// The number of clipped samples of a column whose least and greatest values are `min` and `max`; 0 if it is
/// not clipped.
///
/// A run at exactly `min` or `max` is clipped if the column enters it with a large step, more than the
/// quantisation at that end, as a part of a motion that goes on through several samples at that speed (a
/// relay or a pulse arrives in one step), and if it is longer than the runs elsewhere, in which a coarse or
/// slow sensor repeats values.
pub fn clipped(values: &[f64], min: f64, max: f64) -> usize {
    let steps = values.windows(2).map(|w| (w[1] - w[0]).powi(2)).sum::<f64>() / values.len().max(2) as f64;
    let usual = steps.sqrt();
    let (low, high) = (last_step(values, |v| v), last_step(values, |v| -v));
    let (mut inner, mut outer, mut k) = (vec![], vec![], 0);
    while k < values.len() {
        let x = values[k];
        let end = (k..values.len()).find(|&j| values[j] != x).unwrap_or(values.len());
        if x != min && x != max {
            inner.push(end - k);
        } else if k > 0
            && (x - values[k - 1]).abs() > (0.3 * usual).max(1.5 * if x == min { low } else { high })
            && (arrives(values, k, -1) || arrives(values, end - 1, 1))
        {
            outer.push(end - k);
        }
        k = end;
    }
    inner.sort_unstable();
    // A few of hundreds of runs are long by chance.
    let common = inner.get(inner.len() * 98 / 100).copied().unwrap_or(0);
    let cut = outer.iter().filter(|n| **n > 2 * common.max(1));
    let (total, runs) = cut.fold((0, 0), |(total, runs), n| (total + n, runs + 1));
    if runs >= 3 || total >= 20 { total } else { 0 }
}

/// Whether the motion beside a run is a way to its level: over [`APPROACH`] samples from the edge of the run
/// it comes from further away than the last step alone covers. The step that a range cuts off is shorter than
/// the steps before it, so that they cover `APPROACH` times as much or more.
fn arrives(values: &[f64], edge: usize, outward: isize) -> bool {
    let away = |steps: usize| {
        let at = edge.checked_add_signed(outward * steps as isize)?;
        Some((values.get(at)? - values[edge]).abs())
    };
    match (away(1), away(APPROACH)) {
        (Some(last), Some(way)) => way > 0.6 * APPROACH as f64 * last && !is_ramp(values, edge, outward),
        _ => false,
    }
}

/// Whether the way to a run is a straight line, as a generator of trapezoids draws it and no motion.
fn is_ramp(values: &[f64], edge: usize, outward: isize) -> bool {
    let at = |steps: isize| values.get(edge.checked_add_signed(outward * steps)?).copied();
    // The last step may be a part of one.
    let step = |k: isize| Some(at(k + 1)? - at(k)?);
    let Some(first) = step(1) else { return false };
    (2..=RAMP).all(|k| step(k).is_some_and(|s| (s - first).abs() <= STRAIGHT * first.abs()))
}

/// The quantisation step at one end of a column; 0 if its last three levels are not equally far apart.
fn last_step(values: &[f64], order: impl Fn(f64) -> f64) -> f64 {
    let mut ends = [f64::INFINITY; 3];
    for v in values.iter().map(|v| order(*v)) {
        let at = ends.iter().position(|e| v <= *e).filter(|&at| v < ends[at]);
        if let Some(at) = at {
            ends[at..].rotate_right(1);
            ends[at] = v;
        }
    }
    let (step, next) = (ends[1] - ends[0], ends[2] - ends[1]);
    if (step - next).abs() < 0.1 * step { step } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use phisindy_signal::{bounds, test_signals::gaussian};

    fn told(values: &[f64]) -> usize {
        let (min, max) = bounds(values);
        clipped(values, min, max)
    }

    #[test]
    fn motions_that_are_cut_off_are_told() {
        let noise = gaussian(4000, 7);
        for (step, scatter) in [(0.02, 0.0), (0.02, 0.005), (0.1, 0.0), (0.1, 0.02), (0.3, 0.0)] {
            let swing = |i: usize| (step * i as f64).sin() + scatter * noise[i];
            let both: Vec<f64> = (0..4000).map(|i| swing(i).clamp(-0.8, 0.8)).collect();
            let above: Vec<f64> = (0..4000).map(|i| swing(i).min(0.9)).collect();
            assert!(
                told(&both) > 800 && told(&above) > 200,
                "{step} {scatter}: {} {}",
                told(&both),
                told(&above)
            );
        }
    }

    #[test]
    fn relays_pulses_and_turning_points_are_not() {
        let noise = gaussian(4000, 7);
        let relay = |i: usize| {
            if i < 20 {
                0.0
            } else if (i / 70).is_multiple_of(2) {
                13.3
            } else {
                -13.3
            }
        };
        let pulses = |i: usize| if i % 300 < 40 { 5.0 } else { 0.01 * noise[i] };
        // Counts of an encoder, with a clock that is not even.
        let turning = |i: usize| (40.0 * (0.02 * (i as f64 + 0.4 * noise[i])).sin()).round();
        // Up, hold, down, hold, as a generator writes it with six digits.
        let trapezoid = |i: usize| {
            let t = (i % 400) as f64;
            let up = (t / 90.0).min(1.0) - ((t - 200.0) / 90.0).clamp(0.0, 1.0);
            (up * 1e6).round() / 1e6
        };
        let all: [&dyn Fn(usize) -> f64; 4] = [&relay, &pulses, &turning, &trapezoid];
        for (k, f) in all.iter().enumerate() {
            assert_eq!(told(&(0..4000).map(f).collect::<Vec<f64>>()), 0, "{k}");
        }
    }
}
