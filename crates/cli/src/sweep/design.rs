//! What a table of a sweep needs beside its runs, as its journals keep it: a merge reads no spec.

use phisindy_learn::Truth;
use phisindy_phys::spec::Method;
use phisindy_report::sweep::{NamedTruth, TermName};
use serde::{Deserialize, Serialize};

/// A whole sweep, whatever part of it a journal holds.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Design {
    title: String,
    step: bool,
    /// First seed.
    pub(crate) first: u64,
    /// Number of seeds.
    pub(crate) seeds: u64,
    cells: Vec<DesignCell>,
}

/// A cell: its label, and its truth or why there is none.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct DesignCell {
    label: String,
    names: Vec<TermName>,
    coefficients: Vec<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    error: Option<String>,
}

impl Design {
    /// That of some cells.
    pub(crate) fn new<'a>(
        title: &str,
        method: Method,
        (first, seeds): (u64, u64),
        cells: impl Iterator<Item = (&'a str, &'a Result<NamedTruth, String>)>,
    ) -> Design {
        let cell = |(label, truth): (&str, &Result<NamedTruth, String>)| {
            let label = label.to_owned();
            match truth {
                Ok(NamedTruth { truth, names }) => DesignCell {
                    label,
                    names: names.clone(),
                    coefficients: truth.coefficients.clone(),
                    error: None,
                },
                Err(why) => {
                    DesignCell { label, names: vec![], coefficients: vec![], error: Some(why.clone()) }
                }
            }
        };
        let step = method == Method::Step;
        Design { title: title.to_owned(), step, first, seeds, cells: cells.map(cell).collect() }
    }

    /// Whether it can be that of a sweep: what a damaged line says may be JSON and make no sense.
    pub(crate) fn makes_sense(&self) -> bool {
        let cell = |c: &DesignCell| c.names.len() == c.coefficients.len();
        self.seeds.checked_sub(1).is_some_and(|more| self.first.checked_add(more).is_some())
            && self.cells.iter().all(cell)
    }

    /// Whether a run with this seed belongs to it.
    pub(crate) fn holds(&self, seed: u64) -> bool {
        seed.checked_sub(self.first).is_some_and(|place| place < self.seeds)
    }

    /// The title of the case.
    pub(crate) fn title(&self) -> &str {
        &self.title
    }

    /// The method of all runs.
    pub(crate) fn method(&self) -> Method {
        if self.step { Method::Step } else { Method::Trajectory }
    }

    /// Labels and truths. The places of terms in their dictionaries are not kept: no table names them.
    pub(crate) fn cells(&self) -> Vec<(String, Result<NamedTruth, String>)> {
        let one = |c: &DesignCell| {
            let coefficients = c.coefficients.clone();
            let truth = Truth { terms: (0..coefficients.len()).collect(), coefficients };
            let truth = match &c.error {
                Some(why) => Err(why.clone()),
                None => Ok(NamedTruth { truth, names: c.names.clone() }),
            };
            (c.label.clone(), truth)
        };
        self.cells.iter().map(one).collect()
    }
}
