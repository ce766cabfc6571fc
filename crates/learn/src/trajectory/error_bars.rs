//! Error bars of a fit: the sandwich covariance, stretched where residuals are correlated, and intervals by
//! profile likelihood.

use crate::decisions::{DENSE, STAGES};
use crate::linear::{covariance, solve_damped};
use crate::result::estimate::Estimate;
use crate::trajectory::fit::Fit;
use crate::trajectory::problem::Meaning;
use crate::trajectory::profile::interval;
use faer::{Mat, Side};

/// The error bars of a fit.
pub(crate) struct ErrorBars<'a> {
    fit: &'a Fit<'a>,
    /// Covariance of all unknowns, for residuals that are independent; infinite on the diagonal for what the
    /// data do not determine.
    pub(crate) sandwich: Mat<f64>,
    /// The inverse of the cost's curvature.
    curvature: Mat<f64>,
    /// Factor on variances for correlated residuals.
    inflation: f64,
}

impl<'a> ErrorBars<'a> {
    /// Of a fit at its minimum.
    pub(crate) fn new(fit: &'a Fit<'a>) -> ErrorBars<'a> {
        if fit.force.is_some() {
            let curvature = covariance(&fit.normal.matrix);
            let sandwich = correlated_covariance(fit, &curvature);
            return ErrorBars { fit, sandwich, curvature, inflation: 1.0 };
        }
        let inflation = fit.inflation();
        let (sandwich, curvature) =
            of_numbers(fit).unwrap_or_else(|| (robust_covariance(fit), covariance(&fit.normal.matrix)));
        ErrorBars { fit, sandwich, curvature, inflation }
    }

    /// The standard error of an unknown.
    pub(crate) fn error(&self, k: usize) -> f64 {
        (self.sandwich[(k, k)] * self.inflation).sqrt()
    }

    /// An unknown with its interval by profile likelihood.
    pub(crate) fn estimate(&self, k: usize) -> Estimate {
        // Over short segments a run is nearly linear in its numbers, and a profile would fit all their starts
        // anew. Where a motion forgets its start a single run follows a fixed number only along a bent
        // valley. Work that is to end has no time for profiles.
        let ends = self.fit.problem.stop.requested();
        if self.fit.most_pieces() > STAGES[0] || self.fit.problem.chained || ends {
            return self.quadratic(k);
        }
        let (error, curvature) = (self.error(k), self.curvature[(k, k)].sqrt());
        Estimate { value: self.fit.x[k], std_error: error, ci95: interval(self.fit, k, error, curvature) }
    }

    /// An unknown with the interval of a normal distribution.
    pub(crate) fn quadratic(&self, k: usize) -> Estimate {
        Estimate::normal(self.fit.x[k], self.error(k))
    }

    /// The covariance of some unknowns.
    pub(crate) fn covariance(&self, of: &[usize]) -> Vec<Vec<f64>> {
        of.iter().map(|&a| of.iter().map(|&b| self.sandwich[(a, b)] * self.inflation).collect()).collect()
    }
}

/// The sandwich and the inverse of the curvature for all unknowns but the start states of many segments,
/// whose blocks are left infinite. The start states are eliminated: `S = A_nn - A_ns A_ss^-1 A_sn` is the
/// curvature of the numbers `n` (Schur's complement). `None` for few unknowns.
fn of_numbers(fit: &Fit<'_>) -> Option<(Mat<f64>, Mat<f64>)> {
    let all = fit.x.len();
    if all <= DENSE || fit.most_pieces() == 1 {
        return None;
    }
    let Eliminated { starts, numbers, solved: eliminated, schur } = without_starts(fit)?;
    let bread = covariance(&schur);
    let seen: Vec<usize> = (0..numbers.len()).filter(|&k| bread[(k, k)].is_finite()).collect();
    // A^-1 for the numbers that are seen, one column for each.
    let mut inverse = Mat::zeros(all, seen.len());
    for (c, &j) in seen.iter().enumerate() {
        seen.iter().for_each(|&i| inverse[(numbers[i], c)] = bread[(i, j)]);
        for (row, &s) in starts.iter().enumerate() {
            inverse[(s, c)] = -seen.iter().map(|&i| eliminated[i][row] * bread[(i, j)]).sum::<f64>();
        }
    }
    let meat = fit.problem.meat(&fit.x, &fit.weights, None).ok()?;
    let small = inverse.transpose() * &meat * &inverse;
    let unknowns = seen.len() + starts.len();
    let stretch = fit.samples as f64 / fit.samples.saturating_sub(unknowns).max(1) as f64;
    let open = || Mat::from_fn(all, all, |i, j| if i == j { f64::INFINITY } else { 0.0 });
    let (mut sandwich, mut curvature) = (open(), open());
    for (i, &p) in seen.iter().enumerate() {
        for (j, &q) in seen.iter().enumerate() {
            sandwich[(numbers[p], numbers[q])] = small[(i, j)] * stretch;
            curvature[(numbers[p], numbers[q])] = bread[(p, q)];
        }
    }
    Some((sandwich, curvature))
}

/// The numbers of a fit with the start states eliminated.
struct Eliminated {
    starts: Vec<usize>,
    numbers: Vec<usize>,
    /// `A_ss^-1 A_sn`, by number.
    solved: Vec<Vec<f64>>,
    schur: Mat<f64>,
}

/// Eliminates the start states; `None` where the records do not see one.
fn without_starts(fit: &Fit<'_>) -> Option<Eliminated> {
    let meanings = fit.problem.meanings();
    let (starts, numbers): (Vec<usize>, Vec<usize>) =
        (0..fit.x.len()).partition(|&k| meanings[k] == Meaning::Start);
    let a = &fit.normal.matrix;
    let inner = Mat::from_fn(starts.len(), starts.len(), |i, j| a[(starts[i], starts[j])]);
    let column = |&k: &usize| {
        let right: Vec<f64> = starts.iter().map(|&s| a[(s, k)]).collect();
        solve_damped(&inner, &right, 0.0)
    };
    let solved: Vec<Vec<f64>> = numbers.iter().map(column).collect::<Option<_>>()?;
    let schur = Mat::from_fn(numbers.len(), numbers.len(), |i, j| {
        let through: f64 = starts.iter().zip(&solved[j]).map(|(&s, z)| a[(numbers[i], s)] * z).sum();
        a[(numbers[i], numbers[j])] - through
    });
    Some(Eliminated { starts, numbers, solved, schur })
}

/// The inverse of the curvature of the cost for some unknowns that are no start states; infinite on the diagonal for what
/// the records do not see.
pub(crate) fn of_curvature(fit: &Fit<'_>, unknowns: &[usize]) -> Vec<Vec<f64>> {
    let whole = || ((0..fit.x.len()).collect(), covariance(&fit.normal.matrix));
    let (of, inverse) = if fit.x.len() <= DENSE {
        whole()
    } else {
        without_starts(fit).map_or_else(whole, |e| (e.numbers, covariance(&e.schur)))
    };
    let places: Vec<usize> = unknowns.iter().filter_map(|k| of.iter().position(|own| own == k)).collect();
    places.iter().map(|&i| places.iter().map(|&j| inverse[(i, j)]).collect()).collect()
}

/// The sandwich `A^-1 B A^-1`: curvature `A` of the cost, scatter `B` of its gradient, by the residuals that
/// a fit without the sample would leave: beside an event few samples decide, and the fit goes through them.
/// Where the noise model holds it is `A^-1`; directions that the data do not see stay infinite.
pub(crate) fn robust_covariance(fit: &Fit<'_>) -> Mat<f64> {
    let bread = covariance(&fit.normal.matrix);
    let Ok(meat) = fit.problem.meat(&fit.x, &fit.weights, Some(&bread)) else { return bread };
    between(&bread, &meat)
}

/// The sandwich of innovations that hang together: the meat is the long-run variance of the gradient's parts,
/// by Bartlett's kernel (W. K. Newey and K. D. West, Econometrica 55 (1987) 703-708) over the lags of D. W. K.
/// Andrews (Econometrica 59 (1991) 817-858).
fn correlated_covariance(fit: &Fit<'_>, bread: &Mat<f64>) -> Mat<f64> {
    let Ok(scores) = fit.problem.scores(&fit.x, &fit.weights) else { return bread.clone() };
    let n = bread.nrows();
    let mut meat = Mat::zeros(n, n);
    for record in &scores {
        let lags = lags(record);
        // The kernel is a sum over windows: each holds `lags + 1` parts, those beyond the ends are nothing.
        let length = record.len() + lags;
        let mut window = vec![0.0; n];
        for end in 0..length {
            if let Some(part) = record.get(end) {
                window.iter_mut().zip(part).for_each(|(w, s)| *w += s);
            }
            if let Some(part) = (end > lags).then(|| record.get(end - lags - 1)).flatten() {
                window.iter_mut().zip(part).for_each(|(w, s)| *w -= s);
            }
            for i in 0..n {
                (0..n).for_each(|j| meat[(i, j)] += window[i] * window[j] / (lags + 1) as f64);
            }
        }
    }
    // What is believed beforehand is one more reading, which hangs together with no other.
    fit.problem.priors.iter().for_each(|&(k, _, sigma)| meat[(k, k)] += fit.problem.belief / (sigma * sigma));
    between(bread, &meat)
}

/// Andrews' number of lags, for autoregressions of first order of the parts of a gradient.
fn lags(scores: &[Vec<f64>]) -> usize {
    let columns = scores.first().map_or(0, Vec::len);
    let (mut numerator, mut denominator) = (0.0, 0.0);
    for k in 0..columns {
        let along = |lag: usize| -> f64 { scores.windows(lag + 1).map(|w| w[0][k] * w[lag][k]).sum() };
        let power = along(0);
        if power <= 0.0 {
            continue;
        }
        let rho = (along(1) / power).clamp(-0.97, 0.97);
        // Each column counts alike, whatever its unit.
        numerator += 4.0 * rho * rho / ((1.0 - rho).powi(6) * (1.0 + rho).powi(2));
        denominator += 1.0 / (1.0 - rho).powi(4);
    }
    let alpha = if denominator > 0.0 { numerator / denominator } else { 0.0 };
    ((1.1447 * (alpha * scores.len() as f64).cbrt()) as usize).min(scores.len() / 2)
}

/// Bread, meat, bread, for what the data see. With `bread = L L'` it is `L (L' meat L) L'`: numbers that trade off may be
/// known a thousand times better together than alone, and in the plain product the small variance is lost in the rounding
/// of the large ones, or comes out negative.
fn between(bread: &Mat<f64>, meat: &Mat<f64>) -> Mat<f64> {
    let n = bread.nrows();
    let seen: Vec<usize> = (0..n).filter(|&k| bread[(k, k)].is_finite()).collect();
    let m = seen.len();
    let mut out = Mat::from_fn(n, n, |i, j| if i == j { f64::INFINITY } else { 0.0 });
    if seen.is_empty() {
        return out;
    }
    // In parts of each error, so that no unit of measurement matters.
    let size: Vec<f64> = seen.iter().map(|&k| bread[(k, k)].sqrt()).collect();
    let part = |of: f64, i: usize, j: usize| if of == 0.0 { 0.0 } else { of / (size[i] * size[j]) };
    let correlation = Mat::from_fn(m, m, |i, j| part(bread[(seen[i], seen[j])], i, j));
    let Ok(eigen) = correlation.self_adjoint_eigen(Side::Lower) else { return bread.clone() };
    let (u, s) = (eigen.U(), eigen.S());
    let root = Mat::from_fn(m, m, |i, k| u[(i, k)] * s[k].max(0.0).sqrt());
    let scaled = Mat::from_fn(m, m, |i, j| meat[(seen[i], seen[j])] * size[i] * size[j]);
    let inner = root.transpose() * &scaled * &root;
    let sandwich = &root * &inner * root.transpose();
    for (i, &a) in seen.iter().enumerate() {
        for (j, &b) in seen.iter().enumerate() {
            out[(a, b)] = 0.5 * (sandwich[(i, j)] + sandwich[(j, i)]) * size[i] * size[j];
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn where_nothing_is_seen_all_is_open() {
        let open = Mat::from_fn(2, 2, |i, j| if i == j { f64::INFINITY } else { 0.0 });
        assert!(between(&open, &Mat::identity(2, 2))[(1, 1)].is_infinite());
    }

    /// Four numbers whose common scale is hardly known: each pair of them is known 3000 times better than each alone.
    #[test]
    fn what_is_known_of_numbers_together_is_not_lost_beside_what_is_not() {
        let half = 0.5;
        let q = [
            [half, half, half, half],
            [half, -half, half, -half],
            [half, half, -half, -half],
            [half, -half, -half, half],
        ];
        let sizes = [1e-7, 1.0, 0.5, 0.3];
        let entry = |i: usize, j: usize| (0..4).map(|k| sizes[k] * q[k][i] * q[k][j]).sum::<f64>();
        let a = Mat::from_fn(4, 4, entry);
        // Other errors than those that the cost believes in.
        let meat = Mat::from_fn(4, 4, |i, j| 1.3 * a[(i, j)]);
        let found = between(&covariance(&a), &meat);
        for (k, size) in sizes.iter().enumerate() {
            let along: f64 =
                (0..4).map(|i| (0..4).map(|j| q[k][i] * found[(i, j)] * q[k][j]).sum::<f64>()).sum();
            assert!((along * size / 1.3 - 1.0).abs() < 1e-4, "direction {k}: {along} for {}", 1.3 / size);
        }
    }
}
