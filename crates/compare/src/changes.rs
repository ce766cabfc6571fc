//! Which numbers changed between two results.
//!
//! The differences of the estimates are `d ~ N(delta, C)` with `C` the sum of both covariances. Without a change
//! `d' C^-1 d` has the chi-square distribution with as many degrees of freedom as numbers (A. Wald 1943,
//! doi 10.1090/S0002-9947-1943-0012401-3). Where it is too large, the fewest changes are looked for that leave what
//! chance leaves.

use crate::FALSE_ALARMS;
use crate::estimates::Estimates;
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Two explanations of as many numbers are told apart where the data prefer one with these odds, as a 95 % interval
/// tells a number from zero.
const ODDS: f64 = 19.0;
/// Variances smaller than this part of the largest are those of rounding in the inverse of a curvature: the root of the
/// precision of numbers leaves half of their digits.
const ROUNDING: f64 = 1.5e-8;
/// Most changes of which all choices are tried: one more is added to the best of these.
const TRIED_TOGETHER: usize = 3;

/// A number that both results have and that their data determine.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// Its name.
    pub name: String,
    /// Whether the change is that of its logarithm: it has the same sign in both, and zero is ruled out.
    pub relative: bool,
    /// By how much it changed, if nothing else did but what is told (of the logarithm, or in SI).
    pub by: f64,
    /// Standard error of that.
    pub std_error: f64,
    /// Whether it is told: one of the fewest changes that explain all differences.
    pub changed: bool,
}

/// The difference of two results.
#[derive(Clone, Debug, Default)]
pub struct Changes {
    /// The numbers, in the order of the newer result.
    pub differences: Vec<Difference>,
    /// The probability of differences as large as these where nothing changed.
    pub by_chance: f64,
    /// Covariance of what is told, in the order of the differences.
    pub covariance: Vec<Vec<f64>>,
    /// Other choices of as many changes that the data do not rule out.
    pub or: Vec<Vec<String>>,
}

impl Changes {
    /// The numbers that are told.
    pub fn changed(&self) -> impl Iterator<Item = &Difference> {
        self.differences.iter().filter(|difference| difference.changed)
    }

    /// The numbers of the older result after what is told, with its errors; the others stand as they were, without.
    pub fn applied(&self, before: &Estimates) -> Estimates {
        let n = before.numbers.len();
        let mut after = Estimates { covariance: vec![vec![0.0; n]; n], ..before.clone() };
        let places = self.changed().map(|change| Some((before.position(&change.name)?, change)));
        let places: Vec<Option<(usize, &Difference)>> = places.collect();
        // By how much the number moves where its change does.
        let slope = |value: f64, change: &Difference| if change.relative { value } else { 1.0 };
        for &(k, change) in places.iter().flatten() {
            let value = &mut after.values[k];
            *value = if change.relative { *value * change.by.exp() } else { *value + change.by };
        }
        for (i, a) in places.iter().enumerate() {
            for (j, b) in places.iter().enumerate() {
                let (Some((p, a)), Some((q, b))) = (a, b) else { continue };
                after.covariance[*p][*q] =
                    self.covariance[i][j] * slope(after.values[*p], a) * slope(after.values[*q], b);
            }
        }
        after
    }
}

/// Which numbers changed from one result to another.
///
/// ```
/// use phisindy_compare::{Estimates, Number, changes};
/// let of = |values: [f64; 2]| Estimates {
///     numbers: ["k", "Fc"].map(|name| Number { name: name.into(), unit: "".into(), factor: 1.0 }).into(),
///     values: values.into(),
///     covariance: vec![vec![1.0, 0.0], vec![0.0, 1e-4]],
/// };
/// let found = changes(&of([800.0, 0.37]), &of([801.0, 0.30]));
/// assert!(found.changed().map(|change| change.name.as_str()).eq(["Fc"]));
/// ```
pub fn changes(old: &Estimates, new: &Estimates) -> Changes {
    let pairs =
        new.numbers.iter().enumerate().filter_map(|(k, number)| Some((old.position(&number.name)?, k)));
    let compared: Vec<(usize, usize)> = pairs.filter(|&(a, b)| old.knows(a) && new.knows(b)).collect();
    let n = compared.len();
    // What scales several numbers at once, as a force without a reference does, moves their logarithms alike in both.
    let relative: Vec<bool> = compared
        .iter()
        .map(|&(a, b)| {
            old.values[a] * new.values[b] > 0.0 && old.differs_from_zero(a) && new.differs_from_zero(b)
        })
        .collect();
    let slope = |k: usize, value: f64| if relative[k] { 1.0 / value } else { 1.0 };
    let variance = |i: usize, j: usize| {
        let ((a, b), (c, d)) = (compared[i], compared[j]);
        let of = |e: &Estimates, p: usize, q: usize| {
            e.covariance[p][q] * slope(i, e.values[p]) * slope(j, e.values[q])
        };
        of(old, a, c) + of(new, b, d)
    };
    // In units of their standard errors, so that no unit of measurement matters.
    let scale: Vec<f64> = (0..n).map(|i| variance(i, i).sqrt()).collect();
    let covariance = Mat::from_fn(n, n, |i, j| variance(i, j) / (scale[i] * scale[j]));
    let difference = |k: usize| {
        let (before, now) = (old.values[compared[k].0], new.values[compared[k].1]);
        if relative[k] { (now / before).ln() } else { now - before }
    };
    let difference: Vec<f64> = (0..n).map(|k| difference(k) / scale[k]).collect();
    let Some(problem) = Problem::new(&covariance, &difference) else {
        return Changes { by_chance: 1.0, ..Changes::default() };
    };
    let by_chance = problem.by_chance(problem.whole, n);
    let (told, or) = if by_chance >= FALSE_ALARMS { (vec![], vec![]) } else { problem.fewest() };
    let name = |k: usize| new.numbers[compared[k].1].name.clone();
    let told = in_order(told);
    let covariance = problem.left(&told).map_or_else(Vec::new, |Left { covariance: c, .. }| {
        let entry = |i: usize, j: usize| c[(i, j)] * scale[told[i]] * scale[told[j]];
        (0..told.len()).map(|i| (0..told.len()).map(|j| entry(i, j)).collect()).collect()
    });
    let differences = (0..n).filter_map(|k| {
        let changed = told.contains(&k);
        let free = if changed { told.clone() } else { [told.as_slice(), &[k]].concat() };
        let Left { sizes, covariance, .. } = problem.left(&free)?;
        let place = free.iter().position(|&f| f == k)?;
        let error = covariance[(place, place)].max(0.0).sqrt();
        let (by, std_error) = (sizes[place] * scale[k], error * scale[k]);
        Some(Difference { name: name(k), relative: relative[k], by, std_error, changed })
    });
    let or = or.into_iter().map(|choice| choice.into_iter().map(name).collect());
    Changes { differences: differences.collect(), by_chance, covariance, or: or.collect() }
}

/// The same, rising.
fn in_order(mut places: Vec<usize>) -> Vec<usize> {
    places.sort_unstable();
    places
}

/// What is left where some numbers are free.
struct Left {
    /// As `d' C^-1 d` is.
    left: f64,
    /// By how much each of them changed, and the covariance of these.
    sizes: Vec<f64>,
    covariance: Mat<f64>,
}

/// The differences, weighted by the inverse of their covariance; all in units of their standard errors.
struct Problem {
    /// `C^-1` and `C^-1 d`.
    weights: Mat<f64>,
    pull: Vec<f64>,
    /// `d' C^-1 d`.
    whole: f64,
}

impl Problem {
    fn new(covariance: &Mat<f64>, difference: &[f64]) -> Option<Problem> {
        let n = difference.len();
        if n == 0 {
            return None;
        }
        let eigen = covariance.self_adjoint_eigen(Side::Lower).ok()?;
        let (u, s) = (eigen.U(), eigen.S());
        // Beside a direction that the data hardly see, the variance of others is known to rounding errors of its own.
        let least = ROUNDING * (0..n).map(|k| s[k]).fold(0.0, f64::max);
        let weight = |i, j| (0..n).map(|k| u[(i, k)] * u[(j, k)] / s[k].max(least)).sum::<f64>();
        let weights = Mat::from_fn(n, n, weight);
        let pull: Vec<f64> = (0..n).map(|i| (0..n).map(|j| weights[(i, j)] * difference[j]).sum()).collect();
        let whole = pull.iter().zip(difference).map(|(a, b)| a * b).sum();
        Some(Problem { weights, pull, whole })
    }

    /// The probability of as much where chance alone differs.
    fn by_chance(&self, left: f64, freedom: usize) -> f64 {
        if freedom == 0 {
            1.0
        } else {
            ChiSquared::new(freedom as f64).map_or(1.0, |chi| chi.sf(left.max(0.0)))
        }
    }

    /// What is left where these numbers are free.
    fn left(&self, free: &[usize]) -> Option<Left> {
        let m = free.len();
        let part = Mat::from_fn(m, m, |i, j| self.weights[(free[i], free[j])]);
        let pull = Mat::from_fn(m, 1, |i, _| self.pull[free[i]]);
        let factor = part.llt(Side::Lower).ok()?;
        let (size, covariance) = (factor.solve(&pull), factor.solve(Mat::<f64>::identity(m, m)));
        let left = self.whole - (pull.transpose() * &size)[(0, 0)];
        Some(Left { left, sizes: (0..m).map(|i| size[(i, 0)]).collect(), covariance })
    }

    /// The fewest numbers whose change leaves what chance leaves: the best choice of them, and others that
    /// are as good.
    fn fewest(&self) -> (Vec<usize>, Vec<Vec<usize>>) {
        let all = self.pull.len();
        let mut choices: Vec<Vec<usize>> = (0..all).map(|k| vec![k]).collect();
        for count in 1..=all {
            let fits = choices.iter().filter_map(|choice| Some((self.left(choice)?.left, choice.clone())));
            let mut fits: Vec<_> = fits.filter(|(left, _)| left.is_finite()).collect();
            fits.sort_by(|a, b| a.0.total_cmp(&b.0));
            let Some((least, best)) = fits.first().cloned() else { break };
            if self.by_chance(least, all - count) >= FALSE_ALARMS || count == all {
                let near = fits[1..].iter().take_while(|(left, _)| left - least < 2.0 * ODDS.ln());
                return (best, near.map(|(_, choice)| choice.clone()).collect());
            }
            let from = if count < TRIED_TOGETHER { choices } else { vec![best] };
            choices = Vec::new();
            for choice in &from {
                let first = if count < TRIED_TOGETHER { choice[count - 1] + 1 } else { 0 };
                choices.extend(
                    (first..all).filter(|k| !choice.contains(k)).map(|k| [choice.as_slice(), &[k]].concat()),
                );
            }
        }
        (vec![], vec![])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Number;
    use approx::assert_relative_eq;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_pcg::Pcg64;

    fn of(values: &[f64], covariance: Vec<Vec<f64>>) -> Estimates {
        let number = |k: usize| Number { name: format!("p{k}"), unit: String::new(), factor: 1.0 };
        Estimates { numbers: (0..values.len()).map(number).collect(), values: values.to_vec(), covariance }
    }

    fn diagonal(sizes: &[f64]) -> Vec<Vec<f64>> {
        let n = sizes.len();
        (0..n).map(|i| (0..n).map(|j| if i == j { sizes[i] * sizes[i] } else { 0.0 }).collect()).collect()
    }

    /// Of numbers that trade off, the one that moved is told although both estimates did.
    #[test]
    fn a_change_of_one_number_is_no_change_of_those_that_trade_off_with_it() {
        let tied = vec![vec![1.0, 0.99], vec![0.99, 1.0]];
        let (old, new) = (of(&[10.0, 20.0], tied.clone()), of(&[10.3, 15.3], tied));
        let found = changes(&old, &new);
        let told: Vec<bool> = found.differences.iter().map(|d| d.changed).collect();
        assert_eq!(told, [false, true]);
        // By hand, of the logarithms: given that p0 did not move, p1 moved by its own difference less its slope on
        // that of p0.
        let (variance, shared, of_p0) = (
            1.0 / 400.0 + 1.0 / 15.3f64.powi(2),
            0.99 * (1.0 / 200.0 + 1.0 / (10.3 * 15.3)),
            0.01 + 1.0 / 10.3f64.powi(2),
        );
        let by = (15.3f64 / 20.0).ln() - shared / of_p0 * (10.3f64 / 10.0).ln();
        assert_relative_eq!(found.differences[1].by, by, max_relative = 1e-9);
        let error = (variance - shared * shared / of_p0).sqrt();
        assert_relative_eq!(found.differences[1].std_error, error, max_relative = 1e-9);
    }

    /// Both records know all numbers but for a common scale; that the scale is another in each is no change.
    #[test]
    fn a_change_beside_an_unknown_scale_is_as_sure_as_without() {
        let (values, changed) = ([2.0, 800.0, 0.7], [2.0, 800.0, 0.56]);
        let of_scale = |values: [f64; 3], scale: f64| {
            let values = values.map(|v| v * scale);
            let entry =
                |i: usize, j: usize| values[i] * values[j] * (0.09 + f64::from(u8::from(i == j)) * 1e-6);
            of(&values, (0..3).map(|i| (0..3).map(|j| entry(i, j)).collect()).collect())
        };
        let found = changes(&of_scale(values, 1.0), &of_scale(changed, 1.2));
        assert_eq!(found.changed().map(|d| d.name.as_str()).collect::<Vec<_>>(), ["p2"]);
        assert!(found.differences[2].std_error < 0.003, "{:?}", found.differences);
        assert_relative_eq!(found.differences[2].by, 0.8f64.ln(), epsilon = 1e-5);
    }

    /// False alarms are as rare as is said, for numbers in any units.
    #[test]
    fn unchanged_machines_are_called_changed_as_often_as_is_said() {
        let mut rng = Pcg64::seed_from_u64(11);
        let sizes = [1e-6, 1.0, 3e5, 0.02];
        let mut draw = || sizes.map(|s| s * Distribution::<f64>::sample(&StandardNormal, &mut rng));
        let alarms = (0..4000).filter(|_| {
            let (old, new) = (of(&draw(), diagonal(&sizes)), of(&draw(), diagonal(&sizes)));
            changes(&old, &new).changed().next().is_some()
        });
        // 40 expected, standard deviation 6.3.
        let count = alarms.count();
        assert!((18..=62).contains(&count), "{count}");
    }

    /// The model of the newer record is that of the older with what is told, and no other number moves.
    #[test]
    fn what_is_told_is_applied_and_nothing_else() {
        let (old, new) = (
            of(&[2.0, 800.0, 0.7, 0.0], diagonal(&[0.01, 1.0, 0.001, 0.1])),
            of(&[2.01, 776.0, 0.56, 0.05], diagonal(&[0.01, 1.0, 0.001, 0.1])),
        );
        let found = changes(&old, &new);
        assert_eq!(found.changed().map(|d| d.name.as_str()).collect::<Vec<_>>(), ["p1", "p2"]);
        let after = found.applied(&old);
        assert_eq!((after.values[0], after.values[3]), (2.0, 0.0));
        assert_relative_eq!(after.values[1], 776.0, max_relative = 1e-9);
        assert_relative_eq!(after.values[2], 0.56, max_relative = 1e-9);
        assert_eq!((after.std_error(0), after.std_error(3)), (0.0, 0.0));
        // Both records err: of the logarithms in parts of each value.
        let of_both = 776.0 * (1.0 / 800.0_f64).hypot(1.0 / 776.0);
        assert_relative_eq!(after.std_error(1), of_both, max_relative = 1e-9);
    }

    #[test]
    fn what_the_data_do_not_determine_is_not_compared() {
        let blind = vec![vec![f64::INFINITY, 0.0], vec![0.0, 1.0]];
        let found = changes(&of(&[0.0, 0.0], blind.clone()), &of(&[9.0, 0.1], blind));
        assert_eq!((found.differences.len(), found.changed().count()), (1, 0));
        assert_eq!(changes(&Estimates::default(), &Estimates::default()).by_chance, 1.0);
    }
}
