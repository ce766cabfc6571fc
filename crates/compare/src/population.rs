//! Many machines of one kind: how far their numbers spread, and which of them stands out.
//!
//! A number of machine `i` is `v_i ~ N(mu, tau^2 + s_i^2)`: machines differ by `tau`, and `s_i` is the standard error
//! of the estimate. `tau` is that of R. C. Paule and J. Mandel (1982, doi 10.6028/jres.087.022). Who stands out is found
//! by the generalised test of extreme deviates (B. Rosner 1983, doi 10.1080/00401706.1983.10487848), which sees several
//! at once: each is left out in turn before the next is judged.

use crate::FALSE_ALARMS;
use crate::estimates::Estimates;
use crate::shrinkage::Shrinkage;
use statrs::distribution::{ContinuousCDF, StudentsT};

/// How a number is spread over machines, without those that stand out.
#[derive(Clone, Debug, PartialEq)]
pub struct Spread {
    /// The number.
    pub name: String,
    /// Its unit, for people.
    pub unit: String,
    /// How many SI units that unit is.
    pub factor: f64,
    /// The mean over the machines.
    pub mean: f64,
    /// Standard error of the mean.
    pub mean_error: f64,
    /// Standard deviation among machines, the errors of the estimates taken away.
    pub between: f64,
    /// How many machines have it.
    pub machines: usize,
}

/// A number of a machine beside those of the others.
#[derive(Clone, Debug, PartialEq)]
pub struct Beside {
    /// Place of its spread.
    pub spread: usize,
    /// The estimate.
    pub value: f64,
    /// Its standard error.
    pub std_error: f64,
    /// How far it is from the mean, in standard deviations of a machine like the others.
    pub deviation: f64,
    /// Whether it is none like the others.
    pub stands_out: bool,
    /// Value and standard error that know the others: drawn to the mean as far as chance may have moved the
    /// estimate. Those of the estimate itself where it stands out, or of less than four machines.
    pub among_all: (f64, f64),
}

/// A machine.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Member {
    /// Its numbers.
    pub numbers: Vec<Beside>,
}

impl Member {
    /// Whether one of its numbers is none like those of the others.
    pub fn stands_out(&self) -> bool {
        self.numbers.iter().any(|number| number.stands_out)
    }

    /// Its largest deviation.
    pub fn farthest(&self) -> f64 {
        self.numbers.iter().map(|number| number.deviation.abs()).fold(0.0, f64::max)
    }
}

/// Many machines.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Population {
    /// Of each number that at least three machines have.
    pub spreads: Vec<Spread>,
    /// In the order in which their estimates were given.
    pub members: Vec<Member>,
}

impl Population {
    /// The machines, those that stand out first, then by their largest deviation.
    pub fn by_deviation(&self) -> Vec<usize> {
        let mut all: Vec<usize> = (0..self.members.len()).collect();
        let of = |k: usize| (self.members[k].stands_out(), self.members[k].farthest());
        all.sort_by(|&a, &b| of(b).0.cmp(&of(a).0).then(of(b).1.total_cmp(&of(a).1)));
        all
    }
}

/// Fewest machines of which a spread can be told: of two nobody knows which one is the exception.
const FEWEST: usize = 3;

/// Most steps to the root of the spread: each doubles the right digits, after some that cover the size of the errors
/// beside the spread.
const STEPS: usize = 200;

/// Sets many results beside each other.
///
/// ```
/// use phisindy_compare::{Estimates, Number, population};
/// let of = |value: f64| Estimates {
///     numbers: vec![Number { name: "Fc".into(), unit: "N".into(), factor: 1.0 }],
///     values: vec![value],
///     covariance: vec![vec![1e-6]],
/// };
/// let fleet: Vec<Estimates> = [0.50, 0.51, 0.49, 0.505, 0.80, 0.495, 0.50].map(of).into();
/// let found = population(&fleet);
/// let order = found.by_deviation();
/// assert_eq!(order[0], 4);
/// assert!(found.members[4].stands_out() && !found.members[order[1]].stands_out());
/// ```
pub fn population(all: &[Estimates]) -> Population {
    let mut names: Vec<&str> = Vec::new();
    for number in all.iter().flat_map(|e| &e.numbers) {
        if !names.contains(&number.name.as_str()) {
            names.push(&number.name);
        }
    }
    let columns = names.into_iter().map(|name| Column::of(all, name)).filter(|c| c.estimates.len() >= FEWEST);
    let columns: Vec<Column<'_>> = columns.collect();
    let mut members = vec![Member::default(); all.len()];
    let mut spreads = Vec::new();
    for column in &columns {
        let out = column.outliers(FALSE_ALARMS / columns.len() as f64);
        let inner = column.without(&out);
        let (mean, between) = spread(&inner);
        let weight: f64 = inner.iter().map(|(_, s)| 1.0 / (between * between + s * s)).sum();
        let mean_error = (1.0 / weight).sqrt();
        let shrinkage = Shrinkage::new(&inner, between);
        for (k, &(index, value, std_error)) in column.estimates.iter().enumerate() {
            let stands_out = out.contains(&k);
            let whole = between.hypot(std_error);
            let among_all = match &shrinkage {
                Some(shrinkage) if !stands_out => shrinkage.shrunk(value, std_error),
                _ => (value, std_error),
            };
            let deviation = (value - mean) / whole;
            let beside = Beside { spread: spreads.len(), value, std_error, deviation, stands_out, among_all };
            members[index].numbers.push(beside);
        }
        let number = column.number;
        spreads.push(Spread {
            name: number.name.clone(),
            unit: number.unit.clone(),
            factor: number.factor,
            mean,
            mean_error,
            between,
            machines: column.estimates.len(),
        });
    }
    Population { spreads, members }
}

/// A number over all machines that have it.
struct Column<'a> {
    number: &'a crate::Number,
    /// Machine, value, standard error.
    estimates: Vec<(usize, f64, f64)>,
}

impl<'a> Column<'a> {
    fn of(all: &'a [Estimates], name: &str) -> Column<'a> {
        let places = || all.iter().enumerate().filter_map(|(i, e)| Some((i, e, e.position(name)?)));
        let number = places().next().map(|(_, e, k)| &e.numbers[k]);
        let estimates =
            places().filter(|(_, e, k)| e.knows(*k)).map(|(i, e, k)| (i, e.values[k], e.std_error(k)));
        Column { number: number.expect("the name is one of theirs"), estimates: estimates.collect() }
    }

    fn without(&self, out: &[usize]) -> Vec<(f64, f64)> {
        let inner = self.estimates.iter().enumerate().filter(|(k, _)| !out.contains(k));
        inner.map(|(_, &(_, value, error))| (value, error)).collect()
    }

    /// Places of those that stand out.
    fn outliers(&self, share: f64) -> Vec<usize> {
        let n = self.estimates.len();
        let (mut out, mut found) = (Vec::new(), 0);
        // Those that are left, and their places.
        let mut left = self.without(&[]);
        let mut places: Vec<usize> = (0..n).collect();
        // More than half of them are no exceptions.
        for i in 1..n.div_ceil(2) {
            let (mean, between) = spread(&left);
            let deviations = left.iter().map(|&(v, s)| (v - mean).abs() / between.hypot(s)).enumerate();
            let Some((k, largest)) = deviations.max_by(|a, b| a.1.total_cmp(&b.1)) else { break };
            out.push(places.remove(k));
            left.remove(k);
            if largest > critical(n, i, share) {
                found = i;
            }
        }
        out.truncate(found);
        out
    }
}

/// Rosner's critical value of the `i`-th of `n` (his eq. 2.5).
fn critical(n: usize, i: usize, share: f64) -> f64 {
    let left = (n - i) as f64;
    let freedom = left - 1.0;
    if freedom < 1.0 {
        return f64::INFINITY;
    }
    let tail = share / (2.0 * (left + 1.0));
    let t = StudentsT::new(0.0, 1.0, freedom).map_or(f64::INFINITY, |t| -t.inverse_cdf(tail));
    left * t / ((freedom + t * t) * (left + 1.0)).sqrt()
}

/// Mean and standard deviation among machines by values and their standard errors (Paule and Mandel).
fn spread(all: &[(f64, f64)]) -> (f64, f64) {
    let mean = |between: f64| {
        let weighed = all.iter().map(|(v, s)| (v / (between + s * s), 1.0 / (between + s * s)));
        let (sum, weight) = weighed.fold((0.0, 0.0), |(a, b), (x, w)| (a + x, b + w));
        sum / weight
    };
    let freedom = all.len() as f64 - 1.0;
    // The excess of the weighed squares falls with the variance and is convex: Newton's steps from zero go up to its
    // root and not beyond (R. DerSimonian and R. Kacker 2007, doi 10.1016/j.cct.2006.04.004).
    let mut between = 0.0;
    for _ in 0..STEPS {
        let m = mean(between);
        let (mut excess, mut fall) = (-freedom, 0.0);
        for (v, s) in all {
            let weight = 1.0 / (between + s * s);
            let square = (v - m).powi(2) * weight;
            excess += square;
            fall += square * weight;
        }
        let step = excess / fall;
        if step <= f64::EPSILON * between || !step.is_finite() {
            break;
        }
        between += step;
    }
    (mean(between), between.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Number;
    use approx::assert_relative_eq;
    use rand::SeedableRng;
    use rand_distr::{Distribution, Normal};
    use rand_pcg::Pcg64;

    fn fleet(values: &[[f64; 2]], errors: [f64; 2]) -> Vec<Estimates> {
        let number = |name: &str| Number { name: name.into(), unit: String::new(), factor: 1.0 };
        let covariance = vec![vec![errors[0].powi(2), 0.0], vec![0.0, errors[1].powi(2)]];
        let of = |v: &[f64; 2]| Estimates {
            numbers: vec![number("k"), number("Fc")],
            values: v.to_vec(),
            covariance: covariance.clone(),
        };
        values.iter().map(of).collect()
    }

    /// Machines that spread by 2 % and estimates that err by 1 %.
    fn drawn(n: usize, seed: u64) -> Vec<[f64; 2]> {
        let mut rng = Pcg64::seed_from_u64(seed);
        let (machine, error) =
            (Normal::new(0.0, 0.02).expect("a spread"), Normal::new(0.0, 0.01).expect("a spread"));
        let mut draw = |size: f64| size * (1.0 + machine.sample(&mut rng) + error.sample(&mut rng));
        (0..n).map(|_| [draw(800.0), draw(0.5)]).collect()
    }

    #[test]
    fn worn_machines_come_first_and_spread_is_that_of_the_others() {
        let mut values = drawn(200, 3);
        let worn = [7, 60, 61, 130, 199];
        worn.iter().for_each(|&k| values[k][1] *= 0.8);
        let found = population(&fleet(&values, [8.0, 0.005]));
        let order = found.by_deviation();
        let mut first = order[..5].to_vec();
        first.sort_unstable();
        assert_eq!(first, worn);
        assert!(!found.members[order[5]].stands_out());
        // The standard error of a standard deviation from 195 is 5 %, and the errors are half of the spread.
        assert_relative_eq!(found.spreads[1].between, 0.01, max_relative = 0.2);
    }

    #[test]
    fn a_fleet_of_equals_has_no_exception() {
        let alarms = (0..400).filter(|seed| {
            population(&fleet(&drawn(20, 100 + seed), [8.0, 0.005])).members.iter().any(Member::stands_out)
        });
        // 4 expected.
        let count = alarms.count();
        assert!(count <= 10, "{count}");
    }

    /// Rosner's table 1: n = 50, two-sided 5 %: 3.13 for the first, 3.10 for the fourth.
    #[test]
    fn critical_values_are_those_of_the_paper() {
        assert_relative_eq!(critical(50, 1, 0.05), 3.13, epsilon = 0.01);
        assert_relative_eq!(critical(50, 4, 0.05), 3.10, epsilon = 0.01);
    }
}
