//! The missing force without a formula: a spline of degree one over displacement, velocity or both, in the linear
//! response. The number of knots and what it depends on are those of the least description length.

use crate::decisions::{FAR_OFF, FORCE_KNOTS, FORCE_SURFACE_KNOTS};
use crate::result::{Dependence, ForcePoint, MissingForce};
use crate::screen::{Footing, Ground, Response, dot, norm};
use rayon::prelude::*;

/// Weight of a small force for coefficients that the data do not see, relative to those that they see best.
const RIDGE: f64 = 1e-7;
/// 97.5 % quantile of the normal distribution.
const HALF_INTERVAL: f64 = 1.96;

/// Knots of a spline over a quantity, which part its values into equal numbers.
struct Knots(Vec<f64>);

impl Knots {
    fn new(values: &[Vec<f64>], count: usize) -> Knots {
        let mut all: Vec<f64> = values.iter().flatten().copied().collect();
        all.sort_unstable_by(f64::total_cmp);
        let at = |k: usize| all[(all.len() - 1) * k / (count - 1)];
        let mut knots: Vec<f64> = (0..count).map(at).collect();
        knots.dedup();
        Knots(knots)
    }

    /// Spline `k` at a value: 1 at its knot, 0 at the others.
    fn hat(&self, k: usize, value: f64) -> f64 {
        let own = self.0[k];
        let up = if k > 0 { (value - self.0[k - 1]) / (own - self.0[k - 1]) } else { 1.0 };
        let down = if k + 1 < self.0.len() { (self.0[k + 1] - value) / (self.0[k + 1] - own) } else { 1.0 };
        up.min(down).clamp(0.0, 1.0)
    }
}

/// A column of a basis: knots of the displacement, of the velocity.
type Cell = (Option<usize>, Option<usize>);

/// A fitted force.
struct Fit {
    on: Dependence,
    length: f64,
    /// Mean square of what is left.
    left: f64,
    points: Vec<ForcePoint>,
}

/// The force of a place, and the description length of it.
pub(super) fn missing_force(ground: &Ground, at: &Footing, name: &str) -> Option<(f64, MissingForce)> {
    let x = at.has_displacement();
    let knots = |count: usize| {
        let of = |values: &[Vec<f64>]| Knots::new(values, count);
        (if x { of(&at.displacement) } else { Knots(vec![]) }, of(&at.velocity))
    };
    let mut fits: Vec<Fit> = Vec::new();
    for count in FORCE_KNOTS {
        let (xs, vs) = knots(count);
        let over_x: Vec<Cell> = (0..xs.0.len()).map(|k| (Some(k), None)).collect();
        let over_v: Vec<Cell> = (0..vs.0.len()).map(|k| (None, Some(k))).collect();
        let both: Vec<Cell> = over_x.iter().chain(&over_v).copied().collect();
        fits.extend(fit(ground, at, (&xs, &vs), &over_v, Dependence::Velocity));
        if x {
            fits.extend(fit(ground, at, (&xs, &vs), &over_x, Dependence::Displacement));
            fits.extend(fit(ground, at, (&xs, &vs), &both, Dependence::Sum));
        }
    }
    for count in FORCE_SURFACE_KNOTS.into_iter().filter(|_| x) {
        let (xs, vs) = knots(count);
        let cell = |k: usize| (Some(k / vs.0.len()), Some(k % vs.0.len()));
        let surface: Vec<Cell> = (0..xs.0.len() * vs.0.len()).map(cell).collect();
        fits.extend(fit(ground, at, (&xs, &vs), &surface, Dependence::Together));
    }
    let best = fits.into_iter().min_by(|a, b| a.length.total_cmp(&b.length))?;
    let left = best.left.sqrt();
    let on = if left > FAR_OFF { Dependence::More } else { best.on };
    Some((best.length, MissingForce { at: name.to_owned(), on, left, points: best.points }))
}

/// A force over the cells of a basis by least squares.
fn fit(
    ground: &Ground,
    at: &Footing,
    (xs, vs): (&Knots, &Knots),
    cells: &[Cell],
    on: Dependence,
) -> Option<Fit> {
    let force = |&(i, j): &Cell| -> Vec<Vec<f64>> {
        let value = |x: f64, v: f64| i.map_or(1.0, |i| xs.hat(i, x)) * j.map_or(1.0, |j| vs.hat(j, v));
        let along = |(x, v): (&Vec<f64>, &Vec<f64>)| -> Vec<f64> {
            v.iter().enumerate().map(|(s, v)| value(x.get(s).copied().unwrap_or(0.0), *v)).collect()
        };
        at.displacement.iter().zip(&at.velocity).map(along).collect()
    };
    let responses: Vec<Option<Response>> =
        cells.par_iter().map(|cell| ground.response(at, &force(cell), at.rested())).collect();
    let seen: Vec<(Cell, Response)> =
        cells.iter().copied().zip(responses).filter_map(|(c, r)| Some((c, r?))).collect();
    let sizes: Vec<f64> = seen.iter().map(|(_, r)| norm(&r.rows)).collect();
    let n = seen.len();
    let row = |i: usize| -> Vec<f64> {
        (0..=i).map(|j| dot(&seen[i].1.rows, &seen[j].1.rows) / (sizes[i] * sizes[j])).collect()
    };
    let gram: Vec<Vec<f64>> = (0..n).into_par_iter().map(row).collect();
    let m = faer::Mat::from_fn(n, n, |i, j| gram[i.max(j)][i.min(j)] + if i == j { RIDGE } else { 0.0 });
    let right: Vec<f64> = (0..n).map(|i| dot(&seen[i].1.rows, ground.target()) / sizes[i]).collect();
    let llt = m.llt(faer::Side::Lower).ok()?;
    use faer::linalg::solvers::Solve;
    let solved = llt.solve(&faer::Mat::from_fn(n, 1, |i, _| right[i]));
    let inverse = llt.solve(&faer::Mat::<f64>::identity(n, n));
    let gain: f64 = (0..n).map(|i| solved[(i, 0)] * right[i]).sum();
    let target = dot(ground.target(), ground.target());
    let rows = ground.target().len() as f64;
    let left = ((target - gain).max(0.0)) / rows;
    let cost = |ratio: f64| if ratio > 1.0 { rows * (1.0 + ratio.ln()) } else { rows * ratio };
    let length = cost(left) - cost(target / rows) + n as f64 * rows.ln();
    let point = |(k, (cell, _)): (usize, &(Cell, Response))| ForcePoint {
        displacement: cell.0.map(|i| xs.0[i]),
        velocity: cell.1.map(|j| vs.0[j]),
        force: solved[(k, 0)] / sizes[k],
        band: HALF_INTERVAL * (inverse[(k, k)] * left.max(1.0)).sqrt() / sizes[k],
    };
    let points = seen.iter().enumerate().map(point).collect();
    length.is_finite().then_some(Fit { on, length, left, points })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hats_add_up_to_one() {
        let knots = Knots::new(&[vec![0.0, 1.0, 2.0, 4.0, 9.0]], 4);
        for value in [-1.0, 0.0, 0.3, 1.7, 5.0, 12.0] {
            let sum: f64 = (0..knots.0.len()).map(|k| knots.hat(k, value)).sum();
            assert!((sum - 1.0).abs() < 1e-12, "{value} {sum}");
        }
    }
}
