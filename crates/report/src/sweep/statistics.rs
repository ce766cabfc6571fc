//! Statistics of the runs of one cell.

use super::runs::{NamedTruth, Run, SweepRuns, TermName};

/// Statistics of one cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Statistics {
    /// Finished runs.
    pub runs: usize,
    /// Runs with exactly the true terms.
    pub exact: usize,
    /// For each term of the truth.
    pub coefficients: Vec<Coefficient>,
}

/// One coefficient over all runs in which its term was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Coefficient {
    /// Of its term.
    pub name: TermName,
    /// True value.
    pub truth: f64,
    /// Number of runs that found the term.
    pub found: usize,
    /// Median of the estimates.
    pub median: Option<f64>,
    /// Root mean square of their errors.
    pub rmse: Option<f64>,
    /// The least standard error that the data allow (Cramer-Rao), root mean square over the same runs.
    pub bound: Option<f64>,
    /// Fraction of these runs whose 95 % interval contains the truth.
    pub coverage: Option<f64>,
}

impl Statistics {
    /// The statistics; `runs` are ordered by seed, so that the sums are reproducible.
    pub fn of(named: &NamedTruth, runs: &[Run]) -> Statistics {
        let one = |(k, name): (usize, &TermName)| {
            let truth = named.truth.coefficients[k];
            let with = || runs.iter().filter_map(|run| Some((run, run.found.get(k).copied().flatten()?)));
            let found = with().count();
            let mean = |sum: f64, count: usize| (count > 0).then(|| sum / count as f64);
            let mut values: Vec<f64> = with().map(|(_, f)| f.value).collect();
            values.sort_by(f64::total_cmp);
            let squares = values_in_order(with().map(|(_, f)| (f.value - truth).powi(2)));
            let bounds: Vec<f64> =
                with().filter_map(|(run, _)| run.bound.get(k).copied().flatten()).collect();
            let holds = with().filter(|(_, f)| {
                f.low.is_none_or(|low| low <= truth) && f.high.is_none_or(|high| truth <= high)
            });
            Coefficient {
                name: name.clone(),
                truth,
                found,
                median: median(&values),
                rmse: mean(squares, found).map(f64::sqrt),
                bound: mean(bounds.iter().map(|b| b * b).sum(), bounds.len()).map(f64::sqrt),
                coverage: mean(holds.count() as f64, found),
            }
        };
        Statistics {
            runs: runs.len(),
            exact: runs.iter().filter(|r| r.exact).count(),
            coefficients: named.names.iter().enumerate().map(one).collect(),
        }
    }

    /// The largest error of a median, relative to the truth.
    pub fn worst_median(&self) -> Option<f64> {
        largest(self.coefficients.iter().map(|c| Some((c.median? - c.truth).abs() / c.truth.abs())))
    }

    /// The largest ratio of error to bound.
    pub fn worst_ratio(&self) -> Option<f64> {
        largest(self.coefficients.iter().map(|c| Some(c.rmse? / c.bound?)))
    }

    /// Least and largest coverage.
    pub fn coverage(&self) -> Option<(f64, f64)> {
        let least = largest(self.coefficients.iter().map(|c| c.coverage.map(|x| -x)))?;
        Some((-least, largest(self.coefficients.iter().map(|c| c.coverage))?))
    }
}

impl SweepRuns<'_> {
    /// The statistics of each cell, or why there are none.
    pub(super) fn statistics(&self) -> Vec<Result<Statistics, String>> {
        let of = self.cells.iter().map(|cell| match cell.truth {
            Ok(named) => Ok(Statistics::of(named, cell.runs)),
            Err(why) => Err(why.clone()),
        });
        of.collect()
    }
}

fn values_in_order(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |sum, x| sum + x)
}

/// The largest value; none if one is missing.
fn largest(values: impl Iterator<Item = Option<f64>>) -> Option<f64> {
    let all: Option<Vec<f64>> = values.collect();
    all?.into_iter().reduce(f64::max)
}

fn median(sorted: &[f64]) -> Option<f64> {
    let n = sorted.len();
    (n > 0).then(|| if n % 2 == 1 { sorted[n / 2] } else { 0.5 * (sorted[n / 2 - 1] + sorted[n / 2]) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sweep::Found;
    use phisindy_learn::Truth;

    #[test]
    fn only_runs_that_found_a_term_count_for_it() {
        let named = NamedTruth {
            truth: Truth { terms: vec![0], coefficients: vec![1.0] },
            names: vec![TermName { state: "y".into(), candidate: "1".into() }],
        };
        let run = |value: Option<f64>| Run {
            exact: value.is_some(),
            found: vec![value.map(|v| Found { value: v, low: Some(v - 0.15), high: None })],
            bound: vec![Some(0.1)],
            ..Run::default()
        };
        let runs = [run(Some(0.9)), run(None), run(Some(1.2)), run(Some(1.1)), run(Some(0.9))];
        let all = Statistics::of(&named, &runs);
        let c = &all.coefficients[0];
        assert_eq!((all.runs, all.exact, c.found, c.median), (5, 4, 4, Some(1.0)));
        // Errors are -0.1, 0.2, 0.1, -0.1; only 1.2 - 0.15 lies above the truth.
        assert!((c.rmse.expect("found") - (0.07_f64 / 4.0).sqrt()).abs() < 1e-15);
        assert_eq!((c.coverage, c.bound), (Some(0.75), Some(0.1_f64.powi(2).sqrt())));
        let none = Statistics::of(&named, &[run(None)]);
        assert_eq!((none.coefficients[0].median, none.worst_median(), none.coverage()), (None, None, None));
    }
}
