//! The hidden effects of a set, as in its `truth.json`. The workflow never reads it.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The truth of a set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Truth {
    /// `nothing`, `one`, `two`, `outside` or `constant`.
    pub(crate) kind: String,
    /// The hidden effects; `law` is a name for an effect outside the catalogue.
    pub(crate) effects: Vec<Hidden>,
    /// Other descriptions that are the same force in this record.
    pub(crate) alternatives: Vec<Vec<Placed>>,
    /// Standard deviation of the noise, relative to that of each column.
    pub(crate) noise: f64,
    /// Whether a friction of the truth holds a mass at rest somewhere in the record, and the part of such
    /// samples.
    pub(crate) sticks: bool,
    pub(crate) stuck_share: f64,
    /// Degrees of freedom.
    pub(crate) masses: usize,
    /// The rms difference between the data and the known part with true constants and true start, in units
    /// of the noise.
    pub(crate) gap_before: Gaps,
    /// An estimate of the same on the Fit record after start states and movable constants have absorbed
    /// what they can; null where nothing is hidden.
    pub(crate) gap_fitted: Option<f64>,
    /// The chi square between the truth and the nearest rival with no more free parameters, and that rival;
    /// null without one.
    pub(crate) margin: Option<f64>,
    pub(crate) nearest: String,
    /// The residual of the best one or two laws of the catalogue (rms in units of the noise), for an effect
    /// outside of it.
    pub(crate) remainder: Option<f64>,
    /// Noise of each column, absolute, in SI.
    pub(crate) sigma: BTreeMap<String, f64>,
    /// Movable constants and their true values.
    pub(crate) movable: BTreeMap<String, f64>,
    /// Scale, drive and records for readers.
    pub(crate) rig: String,
    /// Samples of both records.
    pub(crate) samples: [usize; 2],
    /// The part of a force of no catalogue that the best law of the catalogue leaves of it, rms over rms along
    /// the Fit record; null for anything else, and in blind sets.
    pub(crate) apart: Option<f64>,
    /// The chi square that the best law leaves of it in these records, with free start states and constants; null where
    /// `apart` is.
    pub(crate) shown: Option<f64>,
    /// What the noise of the sensors is like.
    pub(crate) noise_kind: String,
}

/// A law at a place with its true values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Hidden {
    pub(crate) law: String,
    pub(crate) at: String,
    pub(crate) parameters: BTreeMap<String, f64>,
    /// The force that is subtracted, in the language of specs.
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
