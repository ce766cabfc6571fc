//! Whether to believe a result. Texts are in [`super::words`].

use super::error::ModelError;
use super::passivity_violation::PassivityViolation;
use super::quantity::{ParameterId, Quantity};
use super::record_fit::RecordFit;
use super::term::FoundTerm;
use crate::decisions::{COMPLETE, WORST_NRMSE};
use phisindy_phys::System;

/// Whether to believe a result.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// The model predicts the records: what it leaves is noise.
    Identified,
    /// What was identified holds, and a force is left beside it.
    Named,
    /// It fits, and says nothing of these numbers: their intervals hold zero, or reach from bound to bound.
    Undetermined(Vec<Quantity>),
    /// The records are not of one machine.
    Contradictory(Contradiction),
    /// It does not predict them.
    Rejected(Rejection),
}

impl Verdict {
    /// Whether what was identified may be used.
    pub fn holds(&self) -> bool {
        matches!(self, Verdict::Identified | Verdict::Named)
    }

    /// The word of the result.
    pub fn word(&self) -> &'static str {
        match self {
            Verdict::Identified => "identified",
            Verdict::Named => "named",
            Verdict::Undetermined(_) => "undetermined",
            Verdict::Contradictory(_) => "contradictory",
            Verdict::Rejected(_) => "rejected",
        }
    }

    /// Why it is no better, in a sentence; `None` where it is identified.
    pub fn reason(&self) -> Option<String> {
        match self {
            Verdict::Identified => None,
            Verdict::Named => Some("a force is left beside what was identified".to_owned()),
            Verdict::Undetermined(numbers) => {
                let names: Vec<String> = numbers.iter().map(ToString::to_string).collect();
                Some(format!("the records do not determine {}", names.join(", ")))
            }
            Verdict::Contradictory(why) => Some(why.to_string()),
            Verdict::Rejected(why) => Some(why.to_string()),
        }
    }
}

/// Two records that ask for different numbers of one machine. `Display` gives the sentence.
#[derive(Clone, Debug, PartialEq)]
pub struct Contradiction {
    /// Which number.
    pub number: Quantity,
    /// Names of the two records.
    pub records: [String; 2],
    /// What each of them alone asks for, in the unit of the spec.
    pub values: [f64; 2],
    /// How far apart these are, in standard errors of their difference.
    pub errors: f64,
}

/// A law whose constants do not fulfil what its file asks for.
#[derive(Clone, Debug, PartialEq)]
pub struct Unfulfilled {
    /// The law, by its id in the catalogue.
    pub law: String,
    /// What is wrong with it, in words of its file.
    pub because: String,
    /// Laws that it contains, by id, simplest first.
    pub simpler: Vec<String>,
    /// Whether chance puts the constants so far beyond less often than once in twenty times.
    pub certain: bool,
}

/// Why a fit did not move. `Display` gives the sentence.
#[derive(Clone, Debug, PartialEq)]
pub enum FitFailure {
    /// An expression of the rates has no finite slope where the motion starts, so no derivative of the misfit
    /// is finite.
    Singular {
        /// The expression, in the language of the specs.
        expression: String,
        /// Name of the state that it depends on.
        state: String,
        /// Value of that state there (SI).
        value: f64,
    },
    /// No step from the start values lowers the misfit.
    Stuck,
}

/// Why a model is rejected. `Display` gives the sentence.
#[derive(Clone, Debug, PartialEq)]
pub enum Rejection {
    /// No term of the dictionary is left, although something is missing.
    NoTerms {
        /// Name of each record and NRMSE of the known part alone.
        known: Vec<(String, f64)>,
    },
    /// The fit did not move from where it started.
    FitFailed(FitFailure),
    /// The free run of a record fails.
    RunFails {
        /// Name of the record.
        record: String,
        /// Why.
        failure: ModelError,
    },
    /// The free run of a record misses the data.
    RunMisses {
        /// Name of the record.
        record: String,
        /// Its NRMSE.
        nrmse: f64,
    },
    /// The constants of a law do not fulfil what its file asks for.
    Unfulfilled(Unfulfilled),
    /// A passive law was fitted so that it feeds the motion.
    Feeds(PassivityViolation),
    /// What is left follows the motion: a law is missing.
    LawMissing {
        /// Name of the record.
        record: String,
        /// Name of the state on whose rate the force acts, or of the output.
        of: String,
        /// Whether it is an output.
        output: bool,
        /// What part of the size of the rate or of the output the motion accounts for.
        share: f64,
    },
    /// The model does no better with the identified part than without it.
    NoBetter,
    /// The known part alone leaves nothing but noise, and laws that were asked for follow the noise.
    NothingMissing,
    /// A number of a law ended at the end of what the law allows, and something is left.
    LawAtBound {
        /// Which.
        number: ParameterId,
        /// Where it ended, in `unit`.
        value: f64,
        /// As in the spec.
        unit: String,
    },
}

/// Rejected when nothing survives although something is missing, a free run fails or misses, or the
/// identified part is no better than nothing. `without` are the free runs of the known part alone,
/// `only_noise` says that the fit leaves nothing but noise.
pub(crate) fn verdict(
    system: &System,
    terms: &[FoundTerm],
    fits: &[RecordFit],
    without: &[RecordFit],
    only_noise: bool,
) -> Verdict {
    match rejection(system, terms, fits, without, only_noise) {
        Some(why) => Verdict::Rejected(why),
        None => Verdict::Identified,
    }
}

fn rejection(
    system: &System,
    terms: &[FoundTerm],
    fits: &[RecordFit],
    without: &[RecordFit],
    only_noise: bool,
) -> Option<Rejection> {
    // A known part that leaves nothing to be named is a right model, not a wrong one.
    let complete = only_noise || fits.iter().all(|f| f.worst() < COMPLETE);
    if terms.is_empty() && !system.terms.is_empty() && !complete {
        let known = without.iter().map(|f| (f.name.clone(), f.worst())).collect();
        return Some(Rejection::NoTerms { known });
    }
    for fit in fits {
        if let Some(failure) = &fit.failure {
            return Some(Rejection::RunFails { record: fit.name.clone(), failure: failure.clone() });
        }
        if fit.missed() > WORST_NRMSE {
            return Some(Rejection::RunMisses { record: fit.name.clone(), nrmse: fit.judged() });
        }
    }
    let left = |f: &RecordFit| f.segments.unwrap_or_else(|| f.worst());
    let mean = |fits: &[RecordFit]| fits.iter().map(left).sum::<f64>() / fits.len().max(1) as f64;
    (!terms.is_empty() && mean(without) <= mean(fits)).then_some(Rejection::NoBetter)
}
