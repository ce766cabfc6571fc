//! Columns that are cut off at the end of a sensor's range.

/// The number of clipped samples of a column whose least and greatest values are `min` and `max`; 0 if it is
/// not clipped.
///
/// A run at exactly `min` or `max` is clipped if the column enters it with a large step, more than the
/// quantisation at that end, and if it is longer than the runs elsewhere, in which a coarse or slow sensor
/// repeats values.
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
