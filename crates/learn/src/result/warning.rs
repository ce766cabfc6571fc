//! What a careful reader should know of a result, as data. Texts are in [`super::words`].

use super::parameter::FoundParameter;
use super::passivity_violation::PassivityViolation;
use super::quantity::{Quantity, TermId};
use super::record_fit::RecordFit;
use super::verdict::Unfulfilled;
use phisindy_phys::Note;
use phisindy_phys::spec::Optimiser;
use phisindy_signal::Differentiator;

/// A remark on a result. `Display` gives the sentence.
#[derive(Clone, Debug, PartialEq)]
pub enum Warning {
    /// What was done to the data of a record before anything was fitted: a note rather than a doubt.
    DataNote {
        /// Name of the record.
        record: String,
        /// What was done.
        note: Note,
    },
    /// A record holds the samples of another one, and was counted once.
    Copy {
        /// Its name.
        record: String,
        /// The name of the other one.
        of: String,
    },
    /// A sensor is late, which the spec does not say: what it is late by was found beside the rest.
    Late {
        /// Its column.
        column: String,
        /// The constant that says by how much.
        by: String,
        /// Whether that is a delay, not the cutoff of a low-pass.
        delay: bool,
        /// The delay in its standard errors.
        errors: f64,
    },
    /// A number ended at a bound of the spec.
    AtBound {
        /// Which.
        number: Quantity,
        /// The bound, in the unit of the spec.
        value: f64,
    },
    /// The interval of a number reaches from bound to bound: the intervals of others end where it does.
    BoundToBound {
        /// Which.
        number: Quantity,
    },
    /// The interval of a coefficient holds zero.
    MayBeZero {
        /// Of which term.
        term: TermId,
    },
    /// Validate records are predicted much worse than Fit records are fitted.
    ValidationWorse {
        /// Worst NRMSE of the Fit records.
        fit: f64,
        /// Worst NRMSE of the Validate records.
        validate: f64,
    },
    /// The numbers of the fit do not describe a Validate record.
    Disagreement {
        /// The number that differs most, in units of its standard error.
        number: Quantity,
        /// Name of the Validate record.
        record: String,
        /// The number by that record alone, in the unit of the spec.
        alone: f64,
        /// That of the fit.
        fitted: f64,
        /// Their distance in standard errors.
        errors: f64,
    },
    /// Noise of measured inputs moves numbers by more than their standard errors.
    InputNoise {
        /// Names of the inputs.
        inputs: Vec<String>,
        /// What it moves.
        moved: Vec<Bias>,
    },
    /// Other terms in the place of some describe the data nearly as well.
    Alternative {
        /// Each a term of the model and the other one.
        swaps: Vec<(TermId, TermId)>,
        /// By how much the criterion is worse with them.
        worse: f64,
    },
    /// With one term more the data are described nearly as well.
    Further {
        /// The term.
        term: TermId,
        /// By how much the criterion is worse with it.
        worse: f64,
    },
    /// A candidate is not finite everywhere on the data.
    SingularCandidate {
        /// Which.
        term: TermId,
    },
    /// The constants of a law do not fulfil what its file asks for.
    Unfulfilled(Unfulfilled),
    /// A passive law feeds the motion.
    Feeds(PassivityViolation),
    /// The data say nothing about a number.
    Unseen {
        /// Which.
        number: Quantity,
    },
    /// The data do not tell several numbers apart.
    Inseparable {
        /// Which.
        numbers: Vec<Quantity>,
    },
    /// Two numbers are correlated, and at least one of them is known badly.
    Correlated {
        /// The earlier one.
        first: Quantity,
        /// The later one.
        second: Quantity,
        /// Their correlation.
        correlation: f64,
    },
    /// A number would leave its interval with another differentiator.
    Differentiator {
        /// The number that would move most.
        number: Quantity,
        /// With which differentiator.
        with: Differentiator,
        /// By how many half widths of its 95 % interval.
        half_widths: f64,
    },
    /// Samples of the residual depend on each other.
    Coloured {
        /// The part of the samples that count as independent.
        independent: f64,
    },
    /// The residual is small, but its spectrum is not that of noise.
    NotNoise,
    /// A single run drifts away from the data, so records were cut.
    Segmented {
        /// Segments of the record that has most.
        pieces: usize,
    },
    /// The motion forgets its start within the record, so the verdict rests on short predictions and on what
    /// it keeps.
    Chaotic(Chaos),
    /// The start state of a Validate record, and numbers of its own, took more of it than usual: neighbouring
    /// motions part fast, or these numbers are nearly collinear.
    SensitiveStart {
        /// Name of the record.
        record: String,
        /// Samples that the start state was fitted on.
        fitted: usize,
        /// Samples of the record.
        samples: usize,
        /// Whether the record has numbers of its own beside its start state.
        own: bool,
    },
    /// Method step holds constants that the spec lets move.
    HeldConstants {
        /// The optimiser, which cannot move them.
        optimiser: Optimiser,
        /// Their names.
        names: Vec<String>,
    },
    /// Method step holds properties of sensors that the spec lets move.
    HeldSensors,
}

impl Warning {
    /// Whether it says what was done to the data, rather than what is doubtful.
    pub fn is_note(&self) -> bool {
        matches!(self, Warning::DataNote { .. })
    }

    /// Whether it says that the residual is not noise.
    pub fn doubts_residual(&self) -> bool {
        matches!(self, Warning::Coloured { .. } | Warning::NotNoise)
    }

    /// Whether it says that the model does not describe records that were held back.
    pub fn doubts_validation(&self) -> bool {
        matches!(self, Warning::ValidationWorse { .. } | Warning::Disagreement { .. })
    }
}

/// A warning for every parameter that ended at a bound, and for every one whose interval reaches both.
pub fn at_bounds(parameters: &[FoundParameter]) -> Vec<Warning> {
    let warning = |p: &FoundParameter| {
        let number = || Quantity::Parameter(p.id.clone());
        // A phase may take any value, and an infinite error is told as such.
        let open = p.id.owner.is_none() && p.estimate.std_error.is_finite() && p.reaches_both_bounds();
        match (p.at_bound, open) {
            (true, _) => Some(Warning::AtBound { number: number(), value: p.estimate.value / p.factor }),
            (false, true) => Some(Warning::BoundToBound { number: number() }),
            _ => None,
        }
    };
    parameters.iter().filter_map(warning).collect()
}

/// A warning for every Validate record whose motion hangs on its start and that is judged by its free run.
pub fn sensitive_starts(records: &[RecordFit]) -> Vec<Warning> {
    let warning = |f: &RecordFit| {
        let part = f.adapted.as_ref().filter(|a| a.took_more && f.segments.is_none())?;
        let (record, own) = (f.name.clone(), !part.values.is_empty());
        Some(Warning::SensitiveStart { record, fitted: part.samples, samples: f.samples, own })
    };
    records.iter().filter_map(warning).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::result::record_fit::Adapted;
    use phisindy_phys::spec::Role;

    #[test]
    fn a_start_that_took_half_of_the_record_is_told_and_a_tenth_is_not() {
        let fit = |name: &str, took: Option<usize>| RecordFit {
            name: name.into(),
            role: Role::Validate,
            samples: 400,
            adapted: Some(Adapted {
                samples: took.unwrap_or(40),
                span: (0.0, 1.0),
                values: vec![],
                took_more: took.is_some(),
            }),
            nrmse: vec![("x".into(), 0.1)],
            noise: vec![],
            residuals: vec![],
            own_times: Default::default(),
            start: vec![],
            run: None,
            segments: None,
            failure: None,
        };
        let told = sensitive_starts(&[fit("steady", None), fit("chaotic", Some(200))]);
        let told: Vec<String> = told.iter().map(ToString::to_string).collect();
        assert_eq!(
            told,
            [
                "chaotic: nearby motions diverge so fast that its start state was fitted on 50 % of it, not on a tenth; everything else there is prediction"
            ]
        );
        // Whatever was written down before the run failed.
        assert_eq!(fit("no run", None).worst(), f64::INFINITY);
    }
}

/// A number that noise of inputs moves.
#[derive(Clone, Debug, PartialEq)]
pub struct Bias {
    /// Which.
    pub number: Quantity,
    /// By which part of itself.
    pub part: f64,
    /// In standard errors.
    pub errors: f64,
}

/// What a chain of segments that no single run follows says of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct Chaos {
    /// Segments of the record that has most.
    pub pieces: usize,
    /// The largest Lyapunov exponent along the records (1/s).
    pub exponent: f64,
    /// The worst NRMSE of a column, each segment predicted from its start.
    pub nrmse: f64,
    /// The noise of that column in the same unit.
    pub noise: f64,
    /// The largest difference of a column's mean between data and free run, in standard errors of the two.
    pub mean: f64,
    /// The largest ratio of a column's standard deviation in data and free run, or its inverse.
    pub size: f64,
}
