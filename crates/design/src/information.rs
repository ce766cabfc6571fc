//! What a run would tell: of the models that are left, and of their numbers.
//!
//! What a model predicts is a normal distribution: its mean, the directions in which its uncertain numbers move it, and
//! the noise. All readings are in units of the noise. Outcomes are drawn from each model (D. V. Lindley 1956,
//! doi 10.1214/aoms/1177728069), and each is judged as `gap` will judge it: by the misfit that is left when the numbers are
//! fitted, and the price of the numbers.

use crate::DECIDED;
use crate::rival::Response;
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;

/// Imagined outcomes of a run under each model: the error of a probability is at most 3 %.
const OUTCOMES: usize = 256;
/// A fit of a run takes its start from the run: what was known before is so many times wider, and plays no part.
const FREE: f64 = 100.0;
/// Directions smaller than this part of the largest are rounding.
const ROUNDING: f64 = 1e-12;

/// How well a run tells models apart.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Separation {
    /// The probability that is expected to be left to models that are not the true one.
    pub wrong: f64,
    /// The probability that one model has more than [`DECIDED`] afterwards.
    pub decides: f64,
    /// The same if a model is the true one, and it is that one that has more, for each of them.
    pub right: Vec<f64>,
}

/// How well a run with these responses tells models apart: each with its probability before, and what more readings add to
/// the price of its numbers.
///
/// ```
/// use phisindy_design::{Response, separation};
/// let at = |x: f64| Response { mean: vec![x, -x], spread: vec![], ..Response::default() };
/// let same = separation(&[&at(1.0), &at(1.0)], &[(0.5, 0.0), (0.5, 0.0)]);
/// assert!((same.wrong - 0.5).abs() < 1e-12 && same.decides == 0.0);
/// let far = separation(&[&at(1.0), &at(20.0)], &[(0.5, 0.0), (0.5, 0.0)]);
/// assert!(far.wrong < 1e-9 && far.decides == 1.0);
/// ```
///
/// # Panics
/// The responses differ in length, or there is not one probability for each.
pub fn separation(responses: &[&Response], models: &[(f64, f64)]) -> Separation {
    assert_eq!(responses.len(), models.len(), "one probability for each model");
    let before: Vec<f64> = models.iter().map(|(p, _)| *p).collect();
    let Some(first) = responses.first() else { return Separation::default() };
    // Beyond the space of all differences and spreads the readings are the same noise for every model.
    let differences = responses.iter().map(|r| {
        assert_eq!(r.mean.len(), first.mean.len(), "the same readings");
        r.mean.iter().zip(&first.mean).map(|(a, b)| a - b).collect::<Vec<f64>>()
    });
    let mut vectors: Vec<Vec<f64>> = differences.collect();
    vectors.extend(responses.iter().flat_map(|r| r.spread.iter().chain(&r.starts).cloned()));
    let coordinates = coordinates(&vectors);
    let size = coordinates.nrows();
    let mut next = responses.len();
    let normals: Vec<Normal> = responses
        .iter()
        .enumerate()
        .map(|(l, r)| {
            let both = r.spread.len() + r.starts.len();
            let spread = coordinates.submatrix(0, next, size, both).to_owned();
            next += both;
            Normal::new((0..size).map(|i| coordinates[(i, l)]).collect(), spread, r.starts.len())
        })
        .collect();
    let mut random = Pcg64::seed_from_u64(1);
    let mut normal =
        |count: usize| -> Vec<f64> { (0..count).map(|_| StandardNormal.sample(&mut random)).collect() };
    let (mut wrong, mut right, mut decides) = (0.0, vec![0.0; models.len()], 0.0);
    for (l, model) in normals.iter().enumerate() {
        for _ in 0..OUTCOMES {
            let y = model.outcome(&normal(model.spread.ncols()), &normal(size));
            let log = |(m, (p, price)): (&Normal, &(f64, f64))| p.ln() - 0.5 * m.misfit(&y) - price;
            let logs: Vec<f64> = normals.iter().zip(models).map(log).collect();
            let all = log_sum(&logs);
            let share = 1.0 / OUTCOMES as f64;
            let others = logs.iter().enumerate().filter(|(m, _)| *m != l).map(|(_, log)| (log - all).exp());
            wrong += share * before[l] * others.sum::<f64>();
            let decided = logs.iter().position(|log| (log - all).exp() > DECIDED);
            decides += if decided.is_some() { share * before[l] } else { 0.0 };
            right[l] += if decided == Some(l) { share } else { 0.0 };
        }
    }
    Separation { wrong, decides, right }
}

/// A normal distribution with unit noise beside its spread.
struct Normal {
    mean: Vec<f64>,
    /// As outcomes scatter.
    spread: Mat<f64>,
    /// Of the covariance that a fit assumes: the same, with free starts.
    factor: faer::linalg::solvers::Llt<f64>,
}

impl Normal {
    /// The last columns of `spread`, so many, are starts.
    fn new(mean: Vec<f64>, spread: Mat<f64>, starts: usize) -> Normal {
        let (n, d) = (mean.len(), spread.ncols());
        let size = |j: usize| if j + starts >= d { FREE } else { 1.0 };
        let fitted = Mat::from_fn(n, d, |i, j| size(j) * spread[(i, j)]);
        let covariance = Mat::<f64>::identity(n, n) + &fitted * fitted.transpose();
        let factor = covariance.llt(Side::Lower).expect("one and more in each direction");
        Normal { mean, spread, factor }
    }

    fn outcome(&self, numbers: &[f64], noise: &[f64]) -> Vec<f64> {
        let moved = |i: usize| (0..numbers.len()).map(|j| self.spread[(i, j)] * numbers[j]).sum::<f64>();
        (0..self.mean.len()).map(|i| self.mean[i] + moved(i) + noise[i]).collect()
    }

    /// The least sum of squares that is left where the uncertain numbers are fitted to an outcome, what is known of them
    /// included.
    fn misfit(&self, y: &[f64]) -> f64 {
        let off = Mat::from_fn(y.len(), 1, |i, _| y[i] - self.mean[i]);
        let solved = self.factor.solve(&off);
        (0..y.len()).map(|i| off[(i, 0)] * solved[(i, 0)]).sum()
    }
}

/// Vectors in an orthonormal basis of the space that they span, one column for each.
fn coordinates(vectors: &[Vec<f64>]) -> Mat<f64> {
    let gram = gram(vectors);
    let n = vectors.len();
    // Models that predict the same to the last bit span no space, nor do readings that are no numbers.
    if (0..n).all(|k| gram[(k, k)] == 0.0) || (0..n).any(|k| !gram[(k, k)].is_finite()) {
        return Mat::zeros(0, n);
    }
    let Ok(eigen) = gram.self_adjoint_eigen(Side::Lower) else { return Mat::zeros(0, n) };
    let (values, basis) = (eigen.S(), eigen.U());
    let largest = (0..n).map(|k| values[k]).fold(0.0, f64::max);
    let kept: Vec<usize> = (0..n).filter(|&k| values[k] > ROUNDING * largest).collect();
    Mat::from_fn(kept.len(), n, |i, j| values[kept[i]].sqrt() * basis[(j, kept[i])])
}

fn gram(vectors: &[Vec<f64>]) -> Mat<f64> {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let mut all = Mat::zeros(vectors.len(), vectors.len());
    for i in 0..vectors.len() {
        for j in 0..=i {
            all[(i, j)] = dot(&vectors[i], &vectors[j]);
            all[(j, i)] = all[(i, j)];
        }
    }
    all
}

fn log_sum(logs: &[f64]) -> f64 {
    let largest = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    largest + logs.iter().map(|log| (log - largest).exp()).sum::<f64>().ln()
}

/// What a run makes of the numbers of a model.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Narrowed {
    /// The expected gain of information on all of them (nats).
    pub gain: f64,
    /// For each number its standard error afterwards.
    pub std_errors: Vec<f64>,
}

/// What a run with this response makes of numbers that its directions of spread move by `moves`, one row for each
/// direction (K. Chaloner, I. Verdinelli 1995, doi 10.1214/ss/1177009939).
///
/// ```
/// use phisindy_design::{Response, narrowed};
/// // A number known to 2 moves a hundred readings by as much as their noise where it moves by 2: a tenth of that is left.
/// let response = Response { mean: vec![0.0; 100], spread: vec![vec![1.0; 100]], ..Response::default() };
/// let known = narrowed(&response, &[vec![2.0]]);
/// assert!((known.std_errors[0] - 2.0 / 101f64.sqrt()).abs() < 1e-12);
/// ```
///
/// # Panics
/// There is not one row of `moves` for each direction.
pub fn narrowed(response: &Response, moves: &[Vec<f64>]) -> Narrowed {
    let (d, s) = (response.spread.len(), response.starts.len());
    assert_eq!(d, moves.len(), "one row for each direction");
    if d == 0 {
        return Narrowed::default();
    }
    // Starts first: what is left in the lower block of the factor is of the numbers alone.
    let all: Vec<Vec<f64>> = response.starts.iter().chain(&response.spread).cloned().collect();
    let before = |i: usize| if i < s { FREE.powi(-2) } else { 1.0 };
    let precision = Mat::from_fn(s + d, s + d, |i, j| if i == j { before(i) } else { 0.0 }) + gram(&all);
    let Ok(factor) = precision.llt(Side::Lower) else { return Narrowed::default() };
    let gain = (s..s + d).map(|i| factor.L()[(i, i)].ln()).sum();
    let numbers = moves.first().map_or(0, Vec::len);
    let std_error = |k: usize| {
        let by = Mat::from_fn(s + d, 1, |j, _| if j < s { 0.0 } else { moves[j - s][k] });
        let left = factor.solve(&by);
        (0..s + d).map(|j| by[(j, 0)] * left[(j, 0)]).sum::<f64>().max(0.0).sqrt()
    };
    Narrowed { gain, std_errors: (0..numbers).map(std_error).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    /// Two models whose means are `apart` noises from each other in one reading, and nothing is uncertain: by numerical
    /// integration.
    #[test]
    fn what_is_left_to_the_wrong_model_is_its_integral() {
        for (apart, p) in [(0.5, 0.5), (2.0, 0.3), (4.0, 0.76)] {
            let at = |x: f64| Response { mean: vec![x], spread: vec![], ..Response::default() };
            let found = separation(&[&at(0.0), &at(apart)], &[(p, 0.0), (1.0 - p, 0.0)]);
            let density = |y: f64, m: f64| (-0.5 * (y - m).powi(2)).exp() / std::f64::consts::TAU.sqrt();
            let step = 1e-3;
            let due: f64 = (-8000..14000)
                .map(|i| {
                    let y = f64::from(i) * step;
                    let (a, b) = (p * density(y, 0.0), (1.0 - p) * density(y, apart));
                    step * 2.0 * a * b / (a + b).max(f64::MIN_POSITIVE)
                })
                .sum();
            // The scatter of 256 outcomes for each.
            assert_abs_diff_eq!(found.wrong, due, epsilon = 0.03);
        }
    }

    /// A model that holds the true one loses no more than the price of its further number.
    #[test]
    fn a_richer_model_is_left_with_its_price() {
        let sine: Vec<f64> = (0..200).map(|i| 3.0 * (0.1 * f64::from(i)).sin()).collect();
        let poor = Response { mean: vec![0.0; 200], spread: vec![], ..Response::default() };
        let rich = Response { spread: vec![sine], ..poor.clone() };
        let price = 0.5 * 2000f64.ln();
        let found = separation(&[&poor, &rich], &[(0.5, 0.0), (0.5, price)]);
        // Its number lowers the misfit by chi square of one degree, which is below 2 (price - ln 19) in 80.9 % of outcomes.
        assert_abs_diff_eq!(found.right[0], 0.809, epsilon = 0.08);
        let without = separation(&[&poor, &rich], &[(0.5, 0.0), (0.5, 0.0)]);
        assert!(without.right[0] == 0.0, "{without:?}");
    }

    /// One model alone without uncertain numbers, and models that are the same.
    #[test]
    fn where_nothing_differs_nothing_is_told() {
        let still = Response { mean: vec![1.0; 10], spread: vec![], ..Response::default() };
        let alone = separation(&[&still], &[(1.0, 0.0)]);
        assert_eq!((alone.wrong, alone.decides), (0.0, 1.0));
        let same = separation(&[&still, &still], &[(0.5, 0.0), (0.5, 0.0)]);
        assert_abs_diff_eq!(same.wrong, 0.5, epsilon = 1e-12);
        assert_eq!(narrowed(&still, &[]), Narrowed::default());
    }

    /// A number that moves the readings as a start does is known no better afterwards: by the closed form of two unknowns.
    #[test]
    fn what_a_free_start_can_imitate_narrows_nothing() {
        let (level, slope) = (vec![1.0; 100], (0..100).map(|i| f64::from(i) / 100.0).collect::<Vec<f64>>());
        let with = |spread: &Vec<f64>, start: &Vec<f64>| {
            let spread = vec![spread.clone()];
            let response =
                Response { mean: vec![0.0; 100], spread, starts: vec![start.clone()], stops: vec![] };
            narrowed(&response, &[vec![2.0]]).std_errors[0]
        };
        assert_abs_diff_eq!(with(&level, &level), 2.0, epsilon = 1e-3);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        let (a, b, c) = (dot(&slope, &slope), dot(&slope, &level), 1e-4 + dot(&level, &level));
        let due = 2.0 / (1.0 + a - b * b / c).sqrt();
        assert_abs_diff_eq!(with(&slope, &level), due, epsilon = 1e-12);
    }

    #[test]
    fn what_an_uncertain_number_can_imitate_tells_nothing() {
        let sine: Vec<f64> = (0..200).map(|i| 3.0 * (0.1 * f64::from(i)).sin()).collect();
        let cosine: Vec<f64> = (0..200).map(|i| 3.0 * (0.1 * f64::from(i)).cos()).collect();
        let model = |mean: &[f64], spread: &[f64]| Response {
            mean: mean.to_vec(),
            spread: vec![spread.iter().map(|x| 1e3 * x).collect()],
            ..Response::default()
        };
        let zero = vec![0.0; 200];
        let alike = [(0.5, 0.0), (0.5, 0.0)];
        let imitated = separation(&[&model(&zero, &sine), &model(&sine, &sine)], &alike);
        let seen = separation(&[&model(&zero, &cosine), &model(&sine, &cosine)], &alike);
        assert!(imitated.wrong > 0.49 && imitated.decides < 0.01, "{imitated:?}");
        assert!(seen.decides > 0.99 && seen.right.iter().all(|r| *r > 0.99), "{seen:?}");
    }
}
