//! The missing force without a formula: a spline of degree one over displacement, velocity or both, in the
//! linear response. The number of knots and what it depends on are those of the least description length.

use super::front::project;
use crate::decisions::{
    EXPLAINED, FAR_OFF, FORCE_AT_REST, FORCE_DEFLECTIONS, FORCE_KNOTS, FORCE_SURFACE_KNOTS, FORCE_TIME_KNOTS,
    FORCE_TIMES, WORTH,
};
use crate::place::Place;
use crate::result::{Dependence, ForcePoint, MissingForce};
use crate::screen::{Kinematics, PartialRegression, Response, dot, norm};
use phisindy_phys::System;
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

    /// Spline `k` at a value: 1 at its knot, 0 at the others. The one after the last is a step at zero, for
    /// friction.
    fn hat(&self, k: usize, value: f64) -> f64 {
        if k == self.0.len() {
            return sign(value);
        }
        let own = self.0[k];
        let up = if k > 0 { (value - self.0[k - 1]) / (own - self.0[k - 1]) } else { 1.0 };
        let down = if k + 1 < self.0.len() { (self.0[k + 1] - value) / (self.0[k + 1] - own) } else { 1.0 };
        up.min(down).clamp(0.0, 1.0)
    }
}

/// -1, 0 or 1.
fn sign(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
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

/// A force without a formula.
pub(super) struct Free {
    /// The description length, less that of nothing.
    pub(super) length: f64,
    pub(super) force: MissingForce,
    /// Whether a force of displacement and velocity may be all that is missing.
    pub(super) may_explain: bool,
}

/// The force of a place.
pub(super) fn missing_force(
    regression: &PartialRegression,
    at: &Kinematics,
    system: &System,
    place: &Place,
) -> Option<Free> {
    let x = at.has_displacement();
    let mut plains = vec![Plain { regression, at, target: regression.target().to_vec(), holding: None }];
    if at.rested()
        && let Some(holding) = regression.holding(at, system)
    {
        let size = norm(&holding.rows);
        let rows: Vec<f64> = holding.rows.iter().map(|v| v / size).collect();
        let mut target = regression.target().to_vec();
        project(&mut target, &rows);
        plains.push(Plain { regression, at, target, holding: Some(rows) });
    }
    let fits = |knots: (&Knots, &Knots), cells: &[Cell], on: Dependence| -> Vec<Fit> {
        plains.iter().filter_map(|plain| plain.fit(knots, cells, &[], on)).collect()
    };
    let knots = |count: usize| {
        let of = |values: &[Vec<f64>]| Knots::new(values, count);
        (if x { of(&at.displacement) } else { Knots(vec![]) }, of(&at.velocity))
    };
    let mut all: Vec<Fit> = Vec::new();
    for count in FORCE_KNOTS {
        let (xs, vs) = knots(count);
        let over_x: Vec<Cell> = (0..xs.0.len()).map(|k| (Some(k), None)).collect();
        let over_v: Vec<Cell> = (0..=vs.0.len()).map(|k| (None, Some(k))).collect();
        let both: Vec<Cell> = over_x.iter().chain(&over_v).copied().collect();
        all.extend(fits((&xs, &vs), &over_v, Dependence::Velocity));
        if x {
            all.extend(fits((&xs, &vs), &over_x, Dependence::Displacement));
            all.extend(fits((&xs, &vs), &both, Dependence::Sum));
        }
    }
    for count in FORCE_SURFACE_KNOTS.into_iter().filter(|_| x) {
        let (xs, vs) = knots(count);
        let columns = vs.0.len() + 1;
        let cell = |k: usize| (Some(k / columns), Some(k % columns));
        let surface: Vec<Cell> = (0..xs.0.len() * columns).map(cell).collect();
        all.extend(fits((&xs, &vs), &surface, Dependence::Together));
    }
    // One quantity is enough where it leaves no more than the noise.
    let enough = |f: &Fit| {
        matches!(f.on, Dependence::Velocity | Dependence::Displacement) && f.left.sqrt() < EXPLAINED
    };
    let some = all.iter().any(enough);
    let best = all.into_iter().filter(|f| !some || enough(f)).min_by(|a, b| a.length.total_cmp(&b.length))?;
    let left = best.left.sqrt();
    // The response to friction that holds is not exact where a place rests.
    let before = norm(regression.target()) / (regression.target().len().max(1) as f64).sqrt();
    let most = if at.rested() { FAR_OFF.max(FORCE_AT_REST * before) } else { FAR_OFF };
    let may_explain = left <= most;
    let on = match beyond(&plains, at, &best, FORCE_KNOTS[1]) {
        Some(on) => on,
        None if !may_explain => Dependence::More,
        None => best.on,
    };
    let force = MissingForce {
        at: place.at.clone(),
        units: ["m", "m/s", "N"].map(|unit| place.unit(unit, 0.0, system)),
        on,
        left,
        points: best.points,
    };
    Some(Free { length: best.length, force, may_explain })
}

/// What a force depends on that displacement and velocity do not determine, where neither of these alone is
/// enough: the past or the time, if forces of one of them are the shorter description.
fn beyond(plains: &[Plain<'_>], at: &Kinematics, best: &Fit, count: usize) -> Option<Dependence> {
    let one = matches!(best.on, Dependence::Velocity | Dependence::Displacement);
    if !at.has_displacement() || (one && best.left.sqrt() < EXPLAINED) {
        return None;
    }
    let (xs, vs) = (Knots::new(&at.displacement, count), Knots::new(&at.velocity, count));
    let over_x = (0..xs.0.len()).map(|k| (Some(k), None));
    let cells: Vec<Cell> = over_x.chain((0..=vs.0.len()).map(|k| (None, Some(k)))).collect();
    let kinds = [(remembering(at), Dependence::Past), (drifting(at), Dependence::Time)];
    let with = |(more, on): &(Vec<Series>, Dependence)| {
        plains.iter().filter_map(|plain| plain.fit((&xs, &vs), &cells, more, *on)).collect::<Vec<Fit>>()
    };
    let other = kinds.iter().flat_map(with).min_by(|a, b| a.length.total_cmp(&b.length))?;
    (other.length + WORTH < best.length).then_some(other.on)
}

/// A force by record and sample.
type Series = Vec<Vec<f64>>;

/// Forces that remember: springs that slip at a deflection (Prandtl 1928, doi 10.1002/zamm.19280080202), of
/// which any hysteresis that does not depend on the speed is a sum, and springs behind dashpots.
fn remembering(at: &Kinematics) -> Vec<Series> {
    let mut sizes: Vec<f64> = at.displacement.iter().flatten().map(|x| x.abs()).collect();
    sizes.sort_unstable_by(f64::total_cmp);
    let top = sizes.get(sizes.len() * 99 / 100).copied().unwrap_or(0.0);
    let turns = |v: &Vec<f64>| v.windows(2).filter(|w| (w[0] > 0.0) != (w[1] > 0.0)).count();
    let turns: usize = at.velocity.iter().map(turns).sum();
    let swing = at.velocity.iter().map(Vec::len).sum::<usize>() as f64 / turns.max(1) as f64;
    let of = &at.displacement;
    let slips = FORCE_DEFLECTIONS.map(|part| remembered(of, |z, dx| (z + dx).clamp(-part * top, part * top)));
    let relaxes = FORCE_TIMES.map(|part| remembered(of, |z, dx| (z + dx) * (-1.0 / (part * swing)).exp()));
    slips.into_iter().chain(relaxes).collect()
}

/// The state that follows displacements from rest: `next` of a state and what the displacement moves.
fn remembered(displacement: &[Vec<f64>], next: impl Fn(f64, f64) -> f64) -> Series {
    let of = |x: &Vec<f64>| {
        let mut z = 0.0;
        let mut out = vec![0.0; x.len()];
        for i in 1..x.len() {
            z = next(z, x[i] - x[i - 1]);
            out[i] = z;
        }
        out
    };
    displacement.iter().map(of).collect()
}

/// Forces of the motion whose size changes in the course of a record, as a spline over the time.
fn drifting(at: &Kinematics) -> Vec<Series> {
    let knots = FORCE_TIME_KNOTS;
    let over_time = |of: &dyn Fn(f64, f64) -> f64| -> Vec<Series> {
        let along = |k: usize| -> Series {
            let one = |(x, v): (&Vec<f64>, &Vec<f64>)| -> Vec<f64> {
                let last = v.len().max(2) as f64 - 1.0;
                let hat = |i: usize| (1.0 - (i as f64 / last * (knots - 1) as f64 - k as f64).abs()).max(0.0);
                (0..v.len()).map(|i| hat(i) * of(x[i], v[i])).collect()
            };
            at.displacement.iter().zip(&at.velocity).map(one).collect()
        };
        (0..knots).map(along).collect()
    };
    let kinds: [&dyn Fn(f64, f64) -> f64; 4] = [&|_, _| 1.0, &|x, _| x, &|_, v| v, &|_, v| sign(v)];
    kinds.into_iter().flat_map(over_time).collect()
}

/// What is left at a place; where the place rests there is a second view, with friction that holds it.
struct Plain<'a> {
    regression: &'a PartialRegression,
    at: &'a Kinematics,
    target: Vec<f64>,
    /// The response to the holding force, of unit size, projected out.
    holding: Option<Vec<f64>>,
}

impl Plain<'_> {
    /// The response to a force.
    fn response(&self, force: &[Vec<f64>]) -> Option<Response> {
        let mut out = self.regression.response(self.at, force, self.holding.is_some())?;
        if let Some(holding) = &self.holding {
            project(&mut out.rows, holding);
        }
        Some(out)
    }

    /// A force over the cells of a basis, and more forces, by least squares.
    fn fit(
        &self,
        (xs, vs): (&Knots, &Knots),
        cells: &[Cell],
        more: &[Series],
        on: Dependence,
    ) -> Option<Fit> {
        let Plain { regression, at, target: own, .. } = self;
        let force = |&(i, j): &Cell| -> Vec<Vec<f64>> {
            let value = |x: f64, v: f64| i.map_or(1.0, |i| xs.hat(i, x)) * j.map_or(1.0, |j| vs.hat(j, v));
            let along = |(x, v): (&Vec<f64>, &Vec<f64>)| -> Vec<f64> {
                v.iter().enumerate().map(|(s, v)| value(x.get(s).copied().unwrap_or(0.0), *v)).collect()
            };
            at.displacement.iter().zip(&at.velocity).map(along).collect()
        };
        let of_cells = cells.par_iter().map(|cell| (Some(*cell), self.response(&force(cell))));
        let of_more = more.par_iter().map(|force| (None, self.response(force)));
        let responses: Vec<(Option<Cell>, Option<Response>)> = of_cells.chain(of_more).collect();
        let seen: Vec<(Option<Cell>, Response)> =
            responses.into_iter().filter_map(|(c, r)| Some((c, r?))).collect();
        let sizes: Vec<f64> = seen.iter().map(|(_, r)| norm(&r.rows)).collect();
        let n = seen.len();
        let row = |i: usize| -> Vec<f64> {
            (0..=i).map(|j| dot(&seen[i].1.rows, &seen[j].1.rows) / (sizes[i] * sizes[j])).collect()
        };
        let gram: Vec<Vec<f64>> = (0..n).into_par_iter().map(row).collect();
        let m = faer::Mat::from_fn(n, n, |i, j| gram[i.max(j)][i.min(j)] + if i == j { RIDGE } else { 0.0 });
        let right: Vec<f64> = (0..n).map(|i| dot(&seen[i].1.rows, own) / sizes[i]).collect();
        let llt = m.llt(faer::Side::Lower).ok()?;
        use faer::linalg::solvers::Solve;
        let solved = llt.solve(&faer::Mat::from_fn(n, 1, |i, _| right[i]));
        let inverse = llt.solve(&faer::Mat::<f64>::identity(n, n));
        let gain: f64 = (0..n).map(|i| solved[(i, 0)] * right[i]).sum();
        let (before, target) = (dot(regression.target(), regression.target()), dot(own, own));
        let rows = own.len() as f64;
        let left = ((target - gain).max(0.0)) / rows;
        let cost = |ratio: f64| if ratio > 1.0 { rows * (1.0 + ratio.ln()) } else { rows * ratio };
        let length = cost(left) - cost(before / rows) + n as f64 * rows.ln();
        let step = |at: Option<usize>| {
            let own = seen.iter().position(|(cell, _)| *cell == Some((at, Some(vs.0.len()))));
            own.map_or(0.0, |k| solved[(k, 0)] / sizes[k])
        };
        let point = |(k, (cell, _)): (usize, &(Option<Cell>, Response))| {
            let cell = (*cell)?;
            let velocity = cell.1.map(|j| vs.0.get(j).copied());
            // The step is part of the points at either side of it.
            let jump = match velocity {
                Some(None) => return None,
                Some(Some(v)) => step(cell.0) * sign(v),
                None => 0.0,
            };
            Some(ForcePoint {
                displacement: cell.0.map(|i| xs.0[i]),
                velocity: velocity.flatten(),
                force: solved[(k, 0)] / sizes[k] + jump,
                band: HALF_INTERVAL * (inverse[(k, k)] * left.max(1.0)).sqrt() / sizes[k],
            })
        };
        let points = seen.iter().enumerate().filter_map(point).collect();
        length.is_finite().then_some(Fit { on, length, left, points })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A spring that slips is one of the forces that remember.
    #[test]
    fn a_slipping_spring_remembers() {
        let x = vec![0.0, 0.5, 1.0, 0.5, 0.0, -1.0];
        assert_eq!(
            remembered(&[x], |z, dx| (z + dx).clamp(-0.75, 0.75)),
            [[0.0, 0.5, 0.75, 0.25, -0.25, -0.75]]
        );
    }

    #[test]
    fn hats_add_up_to_one() {
        let knots = Knots::new(&[vec![0.0, 1.0, 2.0, 4.0, 9.0]], 4);
        for value in [-1.0, 0.0, 0.3, 1.7, 5.0, 12.0] {
            let sum: f64 = (0..knots.0.len()).map(|k| knots.hat(k, value)).sum();
            assert!((sum - 1.0).abs() < 1e-12, "{value} {sum}");
        }
    }
}
