//! The error of predictions against the time that they look ahead, beside that of a linear model.
//!
//! Predictions start at times spread over a record, each from the state that the filter knows there: of a fit
//! without a force that is the state of its free run. The linear model is the autoregression of all columns
//! and inputs that least squares gives, with as many lags as the states need (L. Ljung, System Identification,
//! 2nd ed., 4.2).

use crate::decisions::{EVEN, HORIZON_STARTS, HORIZON_STEPS};
use crate::linear::{solve_damped, symmetric};
use crate::result::horizon::Horizon;
use crate::result::record_fit::RecordFit;
use crate::trajectory::fit::Fit;
use crate::trajectory::free_run::Solution;
use crate::trajectory::layout::Segment;
use crate::trajectory::problem::Problem;
use phisindy_phys::spec::Role;
use phisindy_phys::{Record, System};
use phisindy_signal::mean_step;
use rayon::prelude::*;
use std::ops::Range;

/// The horizons of all records that a model can run along.
pub(crate) fn horizons(
    fit: &Fit<'_>,
    records: &[Record],
    filled: &[Record],
    solution: &Solution,
    fits: &[RecordFit],
) -> Vec<Horizon> {
    let missed = |r: usize, starts: &[usize]| {
        predicted(fit, &records[r], (&filled[r..=r], &fits[r].start), (solution, r), starts)
    };
    of_all(fit.problem.system, &fit.problem.records, records, fits, &missed)
}

/// How far a model without a random force predicts, by its free runs along the records; the linear model beside it is
/// fitted to the Fit records.
pub fn free_run_horizons(system: &System, records: &[Record], fits: &[RecordFit]) -> Vec<Horizon> {
    let fitted: Vec<&Record> = records.iter().filter(|r| r.role == Role::Fit).collect();
    of_all(system, &fitted, records, fits, &|_, _| None)
}

/// The horizons by what predictions miss, or by the free runs where these say nothing.
fn of_all(
    system: &System,
    fitted: &[&Record],
    records: &[Record],
    fits: &[RecordFit],
    predicted: &(dyn Fn(usize, &[usize]) -> Option<Missed> + Sync),
) -> Vec<Horizon> {
    let linear = Autoregression::fitted(system, fitted);
    let of_record = |r: usize| -> Vec<Horizon> {
        let record = &records[r];
        let starts = starts(record.len());
        let missed = predicted(r, &starts).unwrap_or_else(|| along_the_free_run(&fits[r], record, &starts));
        let baseline =
            linear.as_ref().map_or(vec![], |l| starts.iter().map(|&s| l.missed(record, s)).collect());
        let step = mean_step(&record.time);
        let mut all = vec![];
        for k in (0..record.columns.len()).filter(|&k| record.columns[k].is_some()) {
            let deviation = record.deviation(k);
            let part = |of: &Missed, steps: &Range<usize>| part(of, (record, k), &starts, steps, deviation);
            for steps in horizons_of(record.len()) {
                let Some(nrmse) = part(&missed, &steps) else { continue };
                all.push(Horizon {
                    record: record.name.clone(),
                    column: system.measured(k).0.to_owned(),
                    seconds: step * (steps.end - 1) as f64,
                    nrmse,
                    baseline: part(&baseline, &steps),
                });
            }
        }
        all
    };
    (0..records.len().min(fits.len())).into_par_iter().flat_map_iter(of_record).collect()
}

/// What each prediction misses: by start, column, sample after the start.
type Missed = Vec<Vec<Vec<f64>>>;

/// Where predictions start: spread over the first half, so that each can look ahead over half of the record.
fn starts(samples: usize) -> Vec<usize> {
    let count = HORIZON_STARTS.min(samples / 2).max(1);
    (0..count).map(|j| j * (samples / 2) / count).collect()
}

/// Steps ahead, in decades up to half of the record.
fn horizons_of(samples: usize) -> Vec<Range<usize>> {
    let (mut all, mut from) = (vec![], 1);
    while from < samples / 2 {
        let to = (if from == 1 { 2 } else { from * HORIZON_STEPS }).min(samples / 2 + 1);
        all.push(from..to);
        from = to;
    }
    all
}

/// Root mean square of what is missed so many steps ahead, in parts of the deviation.
fn part(
    missed: &Missed,
    (record, column): (&Record, usize),
    starts: &[usize],
    steps: &Range<usize>,
    deviation: f64,
) -> Option<f64> {
    let seen = missed.iter().zip(starts).flat_map(|(of, start)| {
        let own = of.get(column).and_then(|of| of.get(steps.clone())).unwrap_or(&[]);
        let sample = start + steps.start;
        own.iter().enumerate().filter(move |(i, _)| record.own_times.has(column, sample + i)).map(|(_, e)| e)
    });
    let squares: Vec<f64> = seen.map(|e| e * e).collect();
    let rms = (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt();
    (!squares.is_empty() && deviation > 0.0 && rms.is_finite()).then(|| rms / deviation)
}

/// The residual of the free run after each start.
fn along_the_free_run(fit: &RecordFit, record: &Record, starts: &[usize]) -> Missed {
    let half = record.len() / 2 + 1;
    let after =
        |column: &Vec<f64>, s: usize| column.get(s..(s + half).min(column.len())).unwrap_or(&[]).to_vec();
    starts.iter().map(|&s| fit.residuals.iter().map(|column| after(column, s)).collect()).collect()
}

/// What runs of a model that leaves a force miss, from the states that the filter knows; `None` of a model
/// without one.
fn predicted(
    fit: &Fit<'_>,
    record: &Record,
    (filled, start): (&[Record], &[f64]),
    (solution, r): (&Solution, usize),
    starts: &[usize],
) -> Option<Missed> {
    let force = fit.force.as_ref()?.of_another();
    let problem = Problem::new(fit.problem.system, &fit.problem.terms, &[record], &[1]).ok()?;
    let mut x = solution.guess(&problem, r, filled);
    let whole = problem.segments[0];
    let n = fit.problem.system.states.len();
    // A record that was not fitted begins where its columns are: what a free run makes of another one may be far off.
    if record.role == Role::Fit {
        x[whole.start..][..n].copy_from_slice(start.get(..n)?);
    }
    let noise = vec![fit.noise[0].clone()];
    let (pass, _) = problem.filtered(0, &x, &noise, (&force.groups, &force.intensities[0]))?;
    let times: Vec<f64> = pass.along(0).map(|(t, ..)| t).collect();
    let states: Vec<Vec<f64>> = (0..n).map(|k| pass.along(k).map(|(_, v, _)| v).collect()).collect();
    let of_start = |&s: &usize| -> Option<Vec<Vec<f64>>> {
        let i = times.partition_point(|t| *t < record.time[s]).min(times.len().checked_sub(1)?);
        let mut from = x.clone();
        (0..n).for_each(|k| from[whole.start + k] = states[k][i]);
        let to = (s + record.len() / 2 + 1).min(record.len());
        let segment = Segment { samples: (s, to), ..whole };
        let run = problem.trajectory(&segment, &from).ok()?;
        let readings = problem.readings(0, &from, &run);
        let miss = |(column, read): (&Option<Vec<f64>>, &Vec<f64>)| {
            let column = column.as_deref().map_or(&[][..], |c| &c[s..to]);
            column.iter().zip(read).map(|(y, p)| y - p).collect()
        };
        Some(record.columns.iter().zip(&readings).map(miss).collect())
    };
    Some(starts.par_iter().filter_map(of_start).collect())
}

/// `y_i = sum_j A_j y_(i-j) + sum_j B_j u_(i-j) + c` for all columns together.
struct Autoregression {
    columns: Vec<usize>,
    lags: usize,
    /// By column: coefficients of a row.
    rows: Vec<Vec<f64>>,
}

impl Autoregression {
    /// By least squares over the records; `None` where these have no common columns, no common times or no even steps.
    fn fitted(system: &System, records: &[&Record]) -> Option<Autoregression> {
        let has = |k: &usize| records.iter().all(|r| r.columns[*k].is_some());
        let columns: Vec<usize> = (0..system.columns()).filter(has).collect();
        let even = |r: &&Record| {
            let step = mean_step(&r.time);
            r.time.windows(2).all(|t| ((t[1] - t[0]) / step - 1.0).abs() < EVEN)
        };
        if columns.is_empty() || !records.iter().all(|r| even(r) && r.own_times.are_common()) {
            return None;
        }
        let lags = system.states.len().div_ceil(columns.len()).max(1);
        let mut model = Autoregression { columns, lags, rows: vec![] };
        let width = lags * (model.columns.len() + system.inputs.len()) + system.inputs.len() + 1;
        let (mut triangle, mut right) =
            (vec![0.0; width * (width + 1) / 2], vec![vec![0.0; width]; model.columns.len()]);
        for record in records {
            let inputs = inputs(record);
            let columns: Vec<&[f64]> =
                model.columns.iter().map(|&k| record.columns[k].as_deref().unwrap_or_default()).collect();
            for i in lags..record.len() {
                let row = model.row(&columns, &inputs, i);
                let mut at = 0;
                for (a, left) in row.iter().enumerate() {
                    for value in &row[a..] {
                        triangle[at] += left * value;
                        at += 1;
                    }
                    right.iter_mut().zip(&columns).for_each(|(of, y)| of[a] += left * y[i]);
                }
            }
        }
        let matrix = symmetric(&triangle, width);
        model.rows =
            right.iter().map(|b| solve_damped(&matrix, b, f64::EPSILON.sqrt())).collect::<Option<_>>()?;
        Some(model)
    }

    /// What a sample is made of: the samples and inputs before it, the inputs at it, and one.
    fn row(&self, columns: &[&[f64]], inputs: &[Vec<f64>], i: usize) -> Vec<f64> {
        let before = columns.iter().copied().chain(inputs.iter().map(Vec::as_slice));
        let lagged = before.flat_map(|values| (1..=self.lags).map(move |j| values[i - j]));
        lagged.chain(inputs.iter().map(|u| u[i])).chain([1.0]).collect()
    }

    /// What its prediction from the samples before a start misses.
    fn missed(&self, record: &Record, start: usize) -> Vec<Vec<f64>> {
        let start = start.max(self.lags);
        let to = (start + record.len() / 2 + 1).min(record.len());
        let measured = |k: &usize| record.columns[*k].clone().unwrap_or_default();
        let truth: Vec<Vec<f64>> = self.columns.iter().map(measured).collect();
        let mut missed = vec![vec![]; record.columns.len()];
        if truth.iter().any(Vec::is_empty) {
            return missed;
        }
        let (inputs, mut own) = (inputs(record), truth.clone());
        self.columns.iter().for_each(|&k| missed[k].push(0.0));
        for i in start..to {
            let row = self.row(&own.iter().map(Vec::as_slice).collect::<Vec<_>>(), &inputs, i);
            for (c, by) in self.rows.iter().enumerate() {
                own[c][i] = row.iter().zip(by).map(|(value, by)| value * by).sum();
                missed[self.columns[c]].push(truth[c][i] - own[c][i]);
            }
        }
        missed
    }
}

/// The inputs at the samples of a record.
fn inputs(record: &Record) -> Vec<Vec<f64>> {
    record.inputs.iter().map(|u| record.time.iter().map(|&t| u.value(t)).collect()).collect()
}
