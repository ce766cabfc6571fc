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

/// Where a function of one variable is least between two values, to `width`: the golden section (J. Kiefer, Proc. Amer. Math.
/// Soc. 4 (1953) 502, doi 10.1090/S0002-9939-1953-0055639-3).
///
/// ```
/// let x = phisindy_signal::lowest_point(0.0, 3.0, 1e-6, |x| (x - 1.2f64).powi(2));
/// assert!((x - 1.2).abs() < 1e-6);
/// ```
pub fn lowest_point(mut a: f64, mut b: f64, width: f64, mut f: impl FnMut(f64) -> f64) -> f64 {
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut left, mut right) = (b - ratio * (b - a), a + ratio * (b - a));
    let (mut low, mut high) = (f(left), f(right));
    while b - a > width {
        if low < high {
            (b, right, high) = (right, left, low);
            left = b - ratio * (b - a);
            low = f(left);
        } else {
            (a, left, low) = (left, right, high);
            right = a + ratio * (b - a);
            high = f(right);
        }
    }
    0.5 * (a + b)
}
