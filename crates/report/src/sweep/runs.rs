//! The runs of a sweep, as a journal keeps them and as a table is made of them.

use phisindy_learn::Truth;
use phisindy_phys::spec::Method;
use serde::{Deserialize, Serialize};

/// A truth with the names of its terms.
#[derive(Clone, Debug)]
pub struct NamedTruth {
    /// Indices and coefficients.
    pub truth: Truth,
    /// Of each term.
    pub names: Vec<TermName>,
}

/// The name of a term, shown as `STATE:candidate`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TermName {
    /// The state whose rate it enters.
    pub state: String,
    /// As it stands in the spec.
    pub candidate: String,
}

impl std::fmt::Display for TermName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{}", self.state, self.candidate)
    }
}

/// One finished run. A damaged line of a journal has no other meaning: every field is there, and no further one.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Run {
    /// Label of its cell.
    pub cell: String,
    /// Its seed.
    pub seed: u64,
    /// Whether the terms are exactly those of the truth.
    pub exact: bool,
    /// What came of it.
    pub verdict: RunVerdict,
    /// For each term of the truth.
    pub found: Vec<Option<Found>>,
    /// For each term of the truth, the least standard error that the data allow.
    pub bound: Vec<Option<f64>>,
    /// Terms that are not in the truth.
    pub spurious: Vec<String>,
    /// Duration in seconds.
    pub seconds: f64,
}

/// What came of a run. A table and the JSON of a sweep say `identified`, `rejected: why` or `failed: why`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RunVerdict {
    /// The model predicts the records.
    #[default]
    Identified,
    /// It does not, or only in part: the word of its verdict, and why.
    Doubted(String),
    /// There is no model, and why.
    Failed(String),
}

impl std::fmt::Display for RunVerdict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            RunVerdict::Identified => f.write_str("identified"),
            RunVerdict::Doubted(why) => f.write_str(why),
            RunVerdict::Failed(why) => write!(f, "failed: {why}"),
        }
    }
}

/// A term of the truth that was found; an end of the interval that is missing is at infinity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Found {
    /// Coefficient.
    pub value: f64,
    /// Lower end of its 95 % interval.
    #[serde(deserialize_with = "Option::deserialize")]
    pub low: Option<f64>,
    /// Upper end.
    #[serde(deserialize_with = "Option::deserialize")]
    pub high: Option<f64>,
}

/// A cell with its finished runs.
#[derive(Clone, Debug)]
pub struct CellRuns<'a> {
    /// What makes the cell differ from the spec, as `PATH=VALUE, ...`; empty for the spec itself.
    pub label: &'a str,
    /// The truth in terms of the dictionary of the cell, or why there is none.
    pub truth: &'a Result<NamedTruth, String>,
    /// Ordered by seed.
    pub runs: &'a [Run],
}

impl<'a> CellRuns<'a> {
    /// Names of true terms that a run did not find.
    pub(super) fn missing(&self, run: &Run) -> Vec<String> {
        let Ok(named) = self.truth else { return vec![] };
        let missing =
            named.names.iter().enumerate().filter(|&(k, _)| run.found.get(k).is_none_or(Option::is_none));
        missing.map(|(_, name)| name.to_string()).collect()
    }
}

/// All runs of a sweep.
#[derive(Clone, Debug)]
pub struct SweepRuns<'a> {
    /// Name of the spec as the user gave it.
    pub spec: &'a str,
    /// Its title; empty if it has none.
    pub title: &'a str,
    /// The method of all runs.
    pub method: Method,
    /// First seed.
    pub first: u64,
    /// Number of seeds.
    pub seeds: u64,
    /// In the order of the table.
    pub cells: Vec<CellRuns<'a>>,
    /// Whether the sweep was stopped before its end.
    pub stopped: bool,
    /// Duration of the work in seconds.
    pub seconds: f64,
}
