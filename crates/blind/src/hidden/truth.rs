//! What is hidden in a set, as its `truth.json` says it. The workflow never reads it.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The truth of a set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Truth {
    /// `nothing`, `one`, `two` or `outside`.
    pub(crate) kind: String,
    /// What is hidden; of an effect outside the catalogue, `law` is a word for it.
    pub(crate) effects: Vec<Hidden>,
    /// Other descriptions that are the same force in this record.
    pub(crate) alternatives: Vec<Vec<Placed>>,
    /// Standard deviation of the noise as a share of each column's.
    pub(crate) noise: f64,
    /// Whether a friction of the truth holds a mass somewhere in the record, and for what share of the
    /// samples.
    pub(crate) sticks: bool,
    pub(crate) stuck_share: f64,
    /// Degrees of freedom.
    pub(crate) masses: usize,
    /// Of the known part with its true constants, run from the true start: rms of the difference to the data,
    /// in units of the noise.
    pub(crate) gap_before: Gaps,
    /// About the same on the Fit record once start states and constants that may move have absorbed what they
    /// can; null where nothing is hidden.
    pub(crate) gap_fitted: Option<f64>,
    /// How clearly (chi square) the truth beats the nearest rival that has no more freedom, and which one
    /// that is; null without any.
    pub(crate) margin: Option<f64>,
    pub(crate) nearest: String,
    /// What the best one or two laws of the catalogue leave (rms in units of the noise), for an effect
    /// outside of it.
    pub(crate) remainder: Option<f64>,
    /// Noise of each column, absolute, in SI.
    pub(crate) sigma: BTreeMap<String, f64>,
    /// Constants that may move and their true values.
    pub(crate) movable: BTreeMap<String, f64>,
    /// For people: scale, drive, records.
    pub(crate) rig: String,
    /// Samples of both records.
    pub(crate) samples: [usize; 2],
}

/// A law at a place with the values it was made with.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Hidden {
    pub(crate) law: String,
    pub(crate) at: String,
    pub(crate) parameters: BTreeMap<String, f64>,
    /// The force that is subtracted, in words of the language of specs.
    pub(crate) expression: String,
}

/// A law at a place.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub(crate) struct Placed {
    pub(crate) law: String,
    pub(crate) at: String,
}

/// A gap on both records.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Gaps {
    pub(crate) fit: f64,
    pub(crate) validate: f64,
}
