//! Plain statistics of samples.

/// Standard deviation with divisor n; 0 for an empty column.
///
/// ```
/// assert_eq!(phisindy_signal::standard_deviation(&[1.0, 3.0]), 1.0);
/// ```
pub fn standard_deviation(values: &[f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt()
}

/// The least and the greatest value; `(inf, -inf)` for an empty column. NaN is ignored.
///
/// ```
/// assert_eq!(phisindy_signal::bounds(&[2.0, -1.0, 0.5]), (-1.0, 2.0));
/// ```
pub fn bounds(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)))
}

/// The largest absolute value; 0 for an empty column.
pub(crate) fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0_f64, |m, v| m.max(v.abs()))
}

/// The median; 0 for an empty column. Reorders the values.
pub fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let (middle, odd) = (values.len() / 2, values.len() % 2 == 1);
    let (low, &mut upper, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    if odd {
        return upper;
    }
    let lower = low.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    0.5 * (lower + upper)
}
