//! The result of a sweep as JSON: the keys are a contract with users.
//!
//! Keys are in alphabetical order, which is the order of the fields here. Numbers that are not finite become
//! null.

use super::runs::{CellRuns, SweepRuns};
use super::statistics::Statistics;
use serde::Serialize;
use std::collections::BTreeMap;

/// A sweep. The numbers of a single cell stand here, those of several cells in `cells`.
#[derive(Serialize)]
struct Outcome<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    cell: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    cells: Option<Vec<CellOut<'a>>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    coefficients: Option<BTreeMap<String, CoefficientOut>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<&'a str>,
    exact_support: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    failures: Option<Vec<FailureOut<'a>>>,
    method: &'a str,
    runs: usize,
    seconds: f64,
    seed: u64,
    seeds: u64,
    spec: &'a str,
    stopped: bool,
    title: &'a str,
    version: &'a str,
}

#[derive(Serialize)]
struct CellOut<'a> {
    cell: &'a str,
    coefficients: BTreeMap<String, CoefficientOut>,
    /// Why the cell has no truth to compare with.
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<&'a str>,
    exact_support: usize,
    failures: Vec<FailureOut<'a>>,
    runs: usize,
}

#[derive(Serialize)]
struct CoefficientOut {
    bound: Option<f64>,
    coverage95: Option<f64>,
    found: usize,
    median: Option<f64>,
    rmse: Option<f64>,
    truth: f64,
}

#[derive(Serialize)]
struct FailureOut<'a> {
    missing: Vec<String>,
    seed: u64,
    spurious: &'a [String],
    verdict: String,
}

/// The result on one line.
pub(super) fn line(sweep: &SweepRuns<'_>) -> String {
    let statistics = sweep.statistics();
    let mut cells: Vec<CellOut<'_>> =
        sweep.cells.iter().zip(&statistics).map(|(cell, statistics)| cell_out(cell, statistics)).collect();
    let mut outcome = Outcome {
        cell: None,
        cells: None,
        coefficients: None,
        error: None,
        exact_support: cells.iter().map(|c| c.exact_support).sum(),
        failures: None,
        method: sweep.method.name(),
        runs: cells.iter().map(|c| c.runs).sum(),
        seconds: sweep.seconds,
        seed: sweep.first,
        seeds: sweep.seeds,
        spec: sweep.spec,
        stopped: sweep.stopped,
        title: sweep.title,
        version: env!("CARGO_PKG_VERSION"),
    };
    if cells.len() == 1 {
        let CellOut { cell, coefficients, error, failures, .. } = cells.remove(0);
        outcome = Outcome {
            cell: Some(cell),
            coefficients: Some(coefficients),
            error,
            failures: Some(failures),
            ..outcome
        };
    } else {
        outcome.cells = Some(cells);
    }
    // This cannot fail: all keys are strings, and numbers that are not finite become null.
    serde_json::to_string(&outcome).unwrap_or_default()
}

fn cell_out<'a>(cell: &CellRuns<'a>, statistics: &'a Result<Statistics, String>) -> CellOut<'a> {
    let (runs, exact_support) = statistics.as_ref().map_or((0, 0), |s| (s.runs, s.exact));
    let coefficients = statistics.as_ref().map_or(&[][..], |s| &s.coefficients).iter().map(|c| {
        let out = CoefficientOut {
            bound: c.bound,
            coverage95: c.coverage,
            found: c.found,
            median: c.median,
            rmse: c.rmse,
            truth: c.truth,
        };
        (c.name.to_string(), out)
    });
    let failures = cell.runs.iter().filter(|r| !r.exact).map(|run| FailureOut {
        missing: cell.missing(run),
        seed: run.seed,
        spurious: &run.spurious,
        verdict: run.verdict.to_string(),
    });
    CellOut {
        cell: cell.label,
        coefficients: coefficients.collect(),
        error: statistics.as_ref().err().map(String::as_str),
        exact_support,
        failures: failures.collect(),
        runs,
    }
}
