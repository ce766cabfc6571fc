//! Decimation of long lines: of the samples on one column of pixels only the first, the least, the largest
//! and the last are visible.

/// The points that draw the same line at a width of `columns` pixels between `from` and `to`; `x` must not
/// decrease.
pub(crate) fn decimated(points: &[(f64, f64)], (from, to): (f64, f64), columns: usize) -> Vec<(f64, f64)> {
    if points.len() <= 4 * columns {
        return points.to_vec();
    }
    let column = |x: f64| ((x - from) / (to - from) * columns as f64).floor() as i64;
    let mut out: Vec<(f64, f64)> = Vec::with_capacity(4 * columns);
    for pixel in points.chunk_by(|a, b| column(a.0) == column(b.0)) {
        let by = |better: fn(f64, f64) -> bool| {
            (1..pixel.len()).fold(0, |best, k| if better(pixel[k].1, pixel[best].1) { k } else { best })
        };
        let mut kept = [0, by(|a, b| a < b), by(|a, b| a > b), pixel.len() - 1];
        kept.sort_unstable();
        for (i, &k) in kept.iter().enumerate() {
            if i == 0 || k != kept[i - 1] {
                out.push(pixel[k]);
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spike_survives_and_the_rest_is_short() {
        let n = 200_000;
        let mut points: Vec<(f64, f64)> =
            (0..n).map(|k| (f64::from(k), (0.001 * f64::from(k)).sin())).collect();
        points[123_456].1 = 50.0;
        points[77_777].1 = -50.0;
        let short = decimated(&points, (0.0, f64::from(n)), 600);
        assert!(short.len() <= 4 * 600, "{}", short.len());
        assert!(short.contains(&points[123_456]) && short.contains(&points[77_777]));
        assert!(short.contains(&points[0]) && short.contains(&points[n as usize - 1]));
        assert!(short.windows(2).all(|p| p[0].0 < p[1].0));
    }

    #[test]
    fn short_columns_stay() {
        let points = [(0.0, 1.0), (1.0, 2.0)];
        assert_eq!(decimated(&points, (0.0, 1.0), 600), points);
    }
}
