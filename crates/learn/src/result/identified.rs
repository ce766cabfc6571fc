//! What identification returns: terms with error bars, parameters, the fit of every record, a verdict.

use super::held::HeldConstant;
use super::horizon::Horizon;
use super::late_column::LateColumn;
use super::parameter::{FoundParameter, parameter_values};
use super::record_fit::RecordFit;
use super::remainder::Remainder;
use super::term::FoundTerm;
use super::verdict::Verdict;
use super::warning::Warning;
use phisindy_phys::System;
use phisindy_phys::spec::Method;

/// A point on the path of the selection: number of terms and criterion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPoint {
    /// Number of terms.
    pub terms: usize,
    /// Value of the criterion (or the loss, for method step): smaller is better.
    pub criterion: f64,
    /// NRMSE of the free run on the Fit records, where it was computed.
    pub nrmse: Option<f64>,
}

/// The form of the noise of the columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoiseModel {
    /// Does not depend on the signal.
    Additive,
    /// A fraction of the signal.
    Relative,
    /// Both, or different forms in different columns.
    Mixed,
    /// Not estimated: every sample weighs the same.
    Unweighted,
}

/// Why an identification or a training ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopReason {
    /// It came to its end.
    Finished,
    /// The observer stopped it; the result is the best so far.
    Interrupted,
    /// The loss became infinite or not a number (method step).
    LossNotFinite,
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
    /// The form of the noise that the columns were found to have.
    pub noise_model: NoiseModel,
    /// The forces that are left beside the model; empty where free runs leave noise alone.
    pub remainder: Vec<Remainder>,
    /// The path of the selection.
    pub selection: Vec<PathPoint>,
    /// Covariance (SI) of the coefficients of `terms`, then of `parameters`, in their order; empty where the
    /// method does not tell. Infinite on the diagonal is what the data say nothing about.
    pub covariance: Vec<Vec<f64>>,
    /// How far the model predicts; empty where the method does not tell.
    pub horizon: Vec<Horizon>,
    /// The constants that were held, and how the numbers hang on them; empty where the method does not tell.
    pub held: Vec<HeldConstant>,
    /// A column whose sensor looks late, where the spec has no delay for it.
    pub late: Option<LateColumn>,
    /// Twice the negative logarithm of the likelihood of the fitted records but for a constant, to compare models
    /// of the same records; `None` where the method does not tell.
    pub deviance: Option<f64>,
    /// What a careful reader should know.
    pub warnings: Vec<Warning>,
    /// Whether to believe it.
    pub verdict: Verdict,
    /// Why it ended.
    pub stop_reason: StopReason,
}

impl Identified {
    /// Whether the observer stopped it before the end.
    pub fn interrupted(&self) -> bool {
        self.stop_reason == StopReason::Interrupted
    }

    /// The standard error of a number with these derivatives by what was estimated, in the order of the
    /// covariance; `None` where the covariance of one that it depends on is not known.
    pub(crate) fn standard_error(&self, slopes: &[f64]) -> Option<f64> {
        let used: Vec<usize> = (0..slopes.len()).filter(|&k| slopes[k] != 0.0).collect();
        if used.iter().any(|&k| self.covariance.get(k).is_none_or(|row| !row[k].is_finite())) {
            return None;
        }
        let row =
            |&i: &usize| used.iter().map(|&j| slopes[i] * self.covariance[i][j] * slopes[j]).sum::<f64>();
        Some(used.iter().map(row).sum::<f64>().max(0.0).sqrt())
    }

    /// The values of [`System::parameters`] in a record, as far as they were found; the others as the spec
    /// starts them. A Validate record has those that it was given of its own.
    pub fn parameters_of(&self, system: &System, record: usize) -> Vec<f64> {
        let mut values = parameter_values(&self.parameters, system, record);
        let own = self.records.get(record).and_then(|r| r.adapted.as_ref()).map_or(&[][..], |a| &a.values);
        for v in own {
            if let Some(k) = v.id.constant() {
                values[k] = v.value;
            }
        }
        values
    }
}
