//! What identification returns: terms with error bars, parameters, the fit of every record, a verdict.

use phisindy_phys::System;
use phisindy_phys::spec::{Method, Role};
use phisindy_signal::noise_level;
use phisindy_sim::Trajectory;

/// A number with its uncertainty.
///
/// ```
/// let mass = phisindy_learn::Estimate::normal(2.0, 0.1);
/// assert!((mass.ci95.1 - 2.196).abs() < 1e-4);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Best value (SI).
    pub value: f64,
    /// Standard error; infinite where the data say nothing.
    pub std_error: f64,
    /// 95 % interval.
    pub ci95: (f64, f64),
}

impl Estimate {
    /// With the interval of a normal distribution.
    pub fn normal(value: f64, std_error: f64) -> Estimate {
        let reach = 1.959_963_984_540_054 * std_error;
        Estimate { value, std_error, ci95: (value - reach, value + reach) }
    }
}

/// A term of the dictionary that survived.
#[derive(Clone, Debug)]
pub struct FoundTerm {
    /// Index into [`phisindy_phys::System::terms`].
    pub term: usize,
    /// Its coefficient.
    pub coefficient: Estimate,
    /// Whether the coefficient ended at a bound of the spec.
    pub at_bound: bool,
    /// What it does along the motion; `None` where a Fit record could not be run freely.
    pub contribution: Option<Contribution>,
}

impl FoundTerm {
    /// A term of which only the coefficient is known yet.
    pub fn new(term: usize, coefficient: Estimate) -> FoundTerm {
        FoundTerm { term, coefficient, at_bound: false, contribution: None }
    }
}

/// What a term does along the free runs of the Fit records. Forces where the spec states the inertia of the state, else rates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contribution {
    /// Root mean square of the term (SI); a contact that sticks counts as zero.
    pub rms: f64,
    /// That over the root mean square of all terms of the state together: above 1 where terms work against each other.
    pub share: f64,
    /// Energy that it takes out of the motion of its state per second (SI), negative if it feeds the motion; `None` if the state is no velocity.
    pub power: Option<f64>,
    /// The same per cycle; `None` where the motion has no main frequency.
    pub per_cycle: Option<f64>,
}

/// A parameter that was allowed to move.
#[derive(Clone, Debug)]
pub struct FoundParameter {
    /// `k`, or `x.offset` for a sensor parameter; with ` [record]` behind it where each record has its own.
    pub name: String,
    /// As in the spec.
    pub unit: String,
    /// Factor from `unit` to SI.
    pub factor: f64,
    /// Value (SI).
    pub estimate: Estimate,
    /// Bounds (SI).
    pub bounds: (f64, f64),
    /// Whether it ended at one of them.
    pub at_bound: bool,
    /// Index into [`phisindy_phys::System::parameters`], and the record it belongs to; `None` for sensor parameters.
    pub parameter: Option<usize>,
    /// The record it belongs to, where each has its own.
    pub record: Option<usize>,
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
    /// How many of them its start state was fitted on, where a tenth of a Validate record did not tell it: the motion hangs on its start.
    pub start_took: Option<usize>,
    /// For each measured state: its name and rms of the free-run residual over the standard deviation of the column.
    pub nrmse: Vec<(String, f64)>,
    /// For each measured state: its name and the estimated standard deviation of its noise (SI).
    pub noise: Vec<(String, f64)>,
    /// For each state, measured less predicted at the samples of the free run (SI); empty without a column or a run.
    pub residuals: Vec<Vec<f64>>,
    /// Fitted start state (SI).
    pub start: Vec<f64>,
    /// The free run at the sample times; `None` if it failed.
    pub run: Option<Trajectory>,
    /// Why the free run failed.
    pub failure: Option<String>,
}

/// A remark for every Validate record whose motion hangs on its start.
pub fn sensitive_starts(records: &[RecordFit]) -> Vec<String> {
    let of = |f: &RecordFit| {
        let part = 100.0 * f.start_took? as f64 / f.samples.max(1) as f64;
        Some(format!(
            "{}: neighbouring motions part so fast that its start state was fitted on {part:.0} % of it, not on a tenth; everything else there is prediction",
            f.name
        ))
    };
    records.iter().filter_map(of).collect()
}

/// A column of which this part of its standard deviation is noise shows no motion.
const NOISE: f64 = 0.8;

impl RecordFit {
    /// The largest NRMSE of all columns that are more than noise; infinite if the run failed. Of a rig at rest a column is noise, and so is what any model leaves of it.
    pub(crate) fn worst_of_motion(&self) -> f64 {
        if self.run.is_none() {
            return f64::INFINITY;
        }
        let rms = |r: &[f64]| (r.iter().map(|e| e * e).sum::<f64>() / r.len() as f64).sqrt();
        let residuals: Vec<&Vec<f64>> = self.residuals.iter().filter(|r| !r.is_empty()).collect();
        // The column's standard deviation is that of the residual over the NRMSE.
        let rests = |k: usize, e: f64| residuals.get(k).is_some_and(|r| noise_level(r) * e > NOISE * rms(r));
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

/// A point on the way to the structure: so many terms, so good.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPoint {
    /// Number of terms.
    pub terms: usize,
    /// Value of the criterion (or the loss, for method step): smaller is better.
    pub criterion: f64,
    /// NRMSE of the free run on the Fit records, where it was computed.
    pub nrmse: Option<f64>,
}

/// Whether to believe it.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// The model predicts the records.
    Identified,
    /// It does not; why, in words.
    Rejected(String),
}

/// What was identified.
#[derive(Clone, Debug)]
pub struct Identified {
    /// How.
    pub method: Method,
    /// In the order of the dictionary.
    pub terms: Vec<FoundTerm>,
    /// In the order of the spec, sensor parameters last.
    pub parameters: Vec<FoundParameter>,
    /// In the order of the spec.
    pub records: Vec<RecordFit>,
    /// `relative`, `additive`, ...
    pub noise_model: String,
    /// The path of the selection.
    pub selection: Vec<PathPoint>,
    /// Covariance (SI) of the coefficients of `terms`, then of `parameters`, in their order; empty where the method does not tell. Infinite on the diagonal is
    /// what the data say nothing about.
    pub covariance: Vec<Vec<f64>>,
    /// What a careful reader should know, in words.
    pub warnings: Vec<String>,
    /// Whether to believe it.
    pub verdict: Verdict,
    /// Whether it was stopped by the user before the end.
    pub stopped: bool,
}

impl Identified {
    /// The values of [`System::parameters`] in a record, as far as they were found; the others as the spec starts them.
    pub fn parameters_of(&self, system: &System, record: usize) -> Vec<f64> {
        let mut values: Vec<f64> = system.parameters.iter().map(|p| p.start).collect();
        for p in self.parameters.iter().filter(|p| p.record.is_none_or(|r| r == record)) {
            if let Some(k) = p.parameter {
                values[k] = p.estimate.value;
            }
        }
        values
    }
}

/// Why nothing could be identified at all.
#[derive(Clone, Debug, PartialEq)]
pub enum LearnError {
    /// The records do not suit the method: what to do, in words.
    Data(String),
    /// The numerics failed: time, state and cause in words.
    Numerics(String),
}

impl std::fmt::Display for LearnError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            LearnError::Data(text) | LearnError::Numerics(text) => write!(f, "{text}"),
        }
    }
}

impl std::error::Error for LearnError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_start_that_took_half_of_the_record_is_told_and_a_tenth_is_not() {
        let fit = |name: &str, start_took| RecordFit {
            name: name.into(),
            role: Role::Validate,
            samples: 400,
            start_took,
            nrmse: vec![("x".into(), 0.1)],
            noise: vec![],
            residuals: vec![],
            start: vec![],
            run: None,
            failure: None,
        };
        let told = sensitive_starts(&[fit("steady", None), fit("chaotic", Some(200))]);
        assert_eq!(
            told,
            [
                "chaotic: neighbouring motions part so fast that its start state was fitted on 50 % of it, not on a tenth; everything else there is prediction"
            ]
        );
        // Whatever was written down before the run failed.
        assert_eq!(fit("no run", None).worst(), f64::INFINITY);
    }
}
