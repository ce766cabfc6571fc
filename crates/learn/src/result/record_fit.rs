//! How a model does on one record.

use super::error::ModelError;
use super::quantity::ParameterId;
use crate::decisions::{HALF_WIDTH_95, NOISE_ONLY};
use phisindy_phys::OwnTimes;
use phisindy_phys::spec::Role;
use phisindy_signal::noise_level;
use phisindy_sim::Trajectory;
use std::borrow::Cow;
use std::ops::Range;

/// What a Validate record was given of its own, and which part of the record that took: its start state
/// ([`RecordFit::start`]), the constants that each record has, its sensors.
#[derive(Clone, Debug, PartialEq)]
pub struct Adapted {
    /// Number of the record's first samples that were fitted.
    pub samples: usize,
    /// Times of the first and the last of them (s).
    pub span: (f64, f64),
    /// Numbers of its own beside the start state.
    pub values: Vec<OwnValue>,
    /// Whether the usual part of the record did not determine them: the motion depends strongly on its start.
    pub took_more: bool,
}

/// A number that was fitted to one Validate record alone.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnValue {
    /// Which; it belongs to the record.
    pub id: ParameterId,
    /// As in the spec.
    pub unit: String,
    /// Factor from `unit` to SI.
    pub factor: f64,
    /// Value (SI).
    pub value: f64,
}

/// How the identified model does on one record, running freely from its fitted start.
#[derive(Clone, Debug)]
pub struct RecordFit {
    /// As in the spec.
    pub name: String,
    /// Fitted or only predicted.
    pub role: Role,
    /// Number of samples.
    pub samples: usize,
    /// What a Validate record was given of its own before its free run; `None` for a Fit record, and for one
    /// that continues another one.
    pub adapted: Option<Adapted>,
    /// For each measured state: its name and rms of the free-run residual over the standard deviation of the
    /// column, both over the samples of [`RecordFit::scored`].
    pub nrmse: Vec<(String, f64)>,
    /// For each measured state: its name and the estimated standard deviation of its noise (SI).
    pub noise: Vec<(String, f64)>,
    /// For each state, measured less predicted at the samples of the free run (SI); empty without a column or
    /// a run.
    pub residuals: Vec<Vec<f64>>,
    /// Which of the samples each column has.
    pub own_times: OwnTimes,
    /// Fitted start state (SI).
    pub start: Vec<f64>,
    /// The free run at the sample times; `None` if it failed.
    pub run: Option<Trajectory>,
    /// Why the free run failed.
    pub failure: Option<ModelError>,
    /// The largest NRMSE of a column where each of many short segments is predicted from its own start;
    /// `None` for motion that does not forget its start, which the free run judges.
    pub segments: Option<f64>,
}

impl RecordFit {
    /// The samples that the record is judged by: all of a Fit record, of a Validate record those that it was
    /// not adapted on. A record that was adapted as a whole leaves nothing to predict, and is judged by all
    /// of them.
    pub fn scored(&self) -> Range<usize> {
        let adapted = self.adapted.as_ref().map_or(0, |a| a.samples);
        if adapted < self.samples { adapted..self.samples } else { 0..self.samples }
    }

    /// What the free run leaves of a column at its own samples.
    pub fn own_residual(&self, column: usize) -> Cow<'_, [f64]> {
        self.own_times.of(column, &self.residuals[column])
    }

    /// The residuals of each measured column over the samples that count.
    fn scored_residuals(&self) -> impl Iterator<Item = Vec<f64>> {
        let measured = (0..self.residuals.len()).filter(|&k| !self.residuals[k].is_empty());
        measured.map(|k| {
            let own = self.scored().filter(|&i| self.own_times.has(k, i));
            own.map(|i| self.residuals[k][i]).collect()
        })
    }

    /// For each measured column its index, its NRMSE, and the rms that the run leaves (SI).
    pub(crate) fn left(&self) -> impl Iterator<Item = (usize, f64, f64)> {
        let measured = (0..self.residuals.len()).filter(|&k| !self.residuals[k].is_empty());
        measured.zip(&self.nrmse).zip(self.scored_residuals()).map(|((k, (_, e)), r)| (k, *e, rms(&r)))
    }

    /// The largest NRMSE of all columns that are more than noise; infinite if the run failed. Of a rig at
    /// rest a column is noise, and so is what any model leaves of it.
    pub(crate) fn worst_of_motion(&self) -> f64 {
        if self.run.is_none() {
            return f64::INFINITY;
        }
        let residuals: Vec<Vec<f64>> = self.scored_residuals().collect();
        // The column's standard deviation is that of the residual over the NRMSE.
        let rests =
            |k: usize, e: f64| residuals.get(k).is_some_and(|r| noise_level(r) * e > NOISE_ONLY * rms(r));
        let moves = self.nrmse.iter().enumerate().filter(|(k, (_, e))| !rests(*k, *e));
        moves.map(|(_, (_, e))| *e).fold(0.0, f64::max)
    }

    /// The NRMSE that the record is judged by.
    pub(crate) fn judged(&self) -> f64 {
        // What is fitted must move; what is validated may have come to rest.
        let free = || if self.role == Role::Fit { self.worst() } else { self.worst_of_motion() };
        self.segments.unwrap_or_else(free)
    }

    /// The largest part of a column that the run misses beyond white noise; infinite if the run failed. The white
    /// part is known from half of the spectrum: its lower 95 % bound counts. Of a Fit record that shows nothing but
    /// noise all of it is missed: what is fitted must move.
    pub(crate) fn missed(&self) -> f64 {
        if self.run.is_none() || self.segments.is_some() {
            return self.judged();
        }
        let scored = self.scored();
        let sure = (1.0 - 2.0 * HALF_WIDTH_95 / (scored.len().max(1) as f64).sqrt()).max(0.0);
        let mut residuals = self.scored_residuals();
        let of = |(_, nrmse): &(String, f64)| {
            let Some(residual) = residuals.next() else { return *nrmse };
            let power = residual.iter().map(|e| e * e).sum::<f64>() / residual.len() as f64;
            let white = (noise_level(&residual).powi(2) / power.max(f64::MIN_POSITIVE)).min(1.0);
            let nothing = self.role == Role::Fit && white.sqrt() * nrmse > NOISE_ONLY;
            if nothing { *nrmse } else { nrmse * (1.0 - sure * white).sqrt() }
        };
        self.nrmse.iter().map(of).fold(0.0, f64::max)
    }

    /// The largest NRMSE of all columns; infinite if the run failed.
    pub fn worst(&self) -> f64 {
        if self.run.is_none() {
            f64::INFINITY
        } else {
            self.nrmse.iter().map(|&(_, e)| e).fold(0.0, f64::max)
        }
    }
}

/// The root of the mean square.
fn rms(of: &[f64]) -> f64 {
    (of.iter().map(|e| e * e).sum::<f64>() / of.len() as f64).sqrt()
}
