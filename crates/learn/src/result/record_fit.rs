//! How a model does on one record.

use super::error::ModelError;
use crate::decisions::NOISE_ONLY;
use phisindy_phys::spec::Role;
use phisindy_signal::noise_level;
use phisindy_sim::Trajectory;

/// How the identified model does on one record, running freely from its fitted start.
#[derive(Clone, Debug)]
pub struct RecordFit {
    /// As in the spec.
    pub name: String,
    /// Fitted or only predicted.
    pub role: Role,
    /// Number of samples.
    pub samples: usize,
    /// How many of them its start state was fitted on, where a tenth of a Validate record did not
    /// determine it: the motion depends strongly on its start.
    pub start_took: Option<usize>,
    /// For each measured state: its name and rms of the free-run residual over the standard deviation of the
    /// column.
    pub nrmse: Vec<(String, f64)>,
    /// For each measured state: its name and the estimated standard deviation of its noise (SI).
    pub noise: Vec<(String, f64)>,
    /// For each state, measured less predicted at the samples of the free run (SI); empty without a column or a
    /// run.
    pub residuals: Vec<Vec<f64>>,
    /// Fitted start state (SI).
    pub start: Vec<f64>,
    /// The free run at the sample times; `None` if it failed.
    pub run: Option<Trajectory>,
    /// Why the free run failed.
    pub failure: Option<ModelError>,
}

impl RecordFit {
    /// The largest NRMSE of all columns that are more than noise; infinite if the run failed. Of a rig at rest
    /// a column is noise, and so is what any model leaves of it.
    pub(crate) fn worst_of_motion(&self) -> f64 {
        if self.run.is_none() {
            return f64::INFINITY;
        }
        let rms = |r: &[f64]| (r.iter().map(|e| e * e).sum::<f64>() / r.len() as f64).sqrt();
        let residuals: Vec<&Vec<f64>> = self.residuals.iter().filter(|r| !r.is_empty()).collect();
        // The column's standard deviation is that of the residual over the NRMSE.
        let rests =
            |k: usize, e: f64| residuals.get(k).is_some_and(|r| noise_level(r) * e > NOISE_ONLY * rms(r));
        let moves = self.nrmse.iter().enumerate().filter(|(k, (_, e))| !rests(*k, *e));
        moves.map(|(_, (_, e))| *e).fold(0.0, f64::max)
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
