//! Whether to believe a result. Texts are in [`super::words`].

use super::error::ModelError;
use super::record_fit::RecordFit;
use super::term::FoundTerm;
use crate::decisions::WORST_NRMSE;
use phisindy_phys::System;
use phisindy_phys::spec::Role;

/// Whether to believe a result.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// The model predicts the records.
    Identified,
    /// It does not.
    Rejected(Rejection),
}

/// Why a model is rejected. `Display` gives the sentence.
#[derive(Clone, Debug, PartialEq)]
pub enum Rejection {
    /// No term of the dictionary is left.
    NoTerms {
        /// Name of each record and NRMSE of the known part alone.
        known: Vec<(String, f64)>,
    },
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
    /// The model does no better with the identified part than without it.
    NoBetter,
}

/// Rejected when nothing survives, a free run fails or misses, or the identified part is no better than
/// nothing. `without` are the free runs of the known part alone.
pub(crate) fn verdict(
    system: &System,
    terms: &[FoundTerm],
    fits: &[RecordFit],
    without: &[RecordFit],
) -> Verdict {
    match rejection(system, terms, fits, without) {
        Some(why) => Verdict::Rejected(why),
        None => Verdict::Identified,
    }
}

fn rejection(
    system: &System,
    terms: &[FoundTerm],
    fits: &[RecordFit],
    without: &[RecordFit],
) -> Option<Rejection> {
    if terms.is_empty() && !system.terms.is_empty() {
        let known = without.iter().map(|f| (f.name.clone(), f.worst())).collect();
        return Some(Rejection::NoTerms { known });
    }
    for fit in fits {
        if let Some(failure) = &fit.failure {
            return Some(Rejection::RunFails { record: fit.name.clone(), failure: failure.clone() });
        }
        // What is fitted must move; what is validated may have come to rest.
        let nrmse = if fit.role == Role::Fit { fit.worst() } else { fit.worst_of_motion() };
        if nrmse > WORST_NRMSE {
            return Some(Rejection::RunMisses { record: fit.name.clone(), nrmse });
        }
    }
    let mean = |fits: &[RecordFit]| fits.iter().map(RecordFit::worst).sum::<f64>() / fits.len().max(1) as f64;
    (!terms.is_empty() && mean(without) <= mean(fits)).then_some(Rejection::NoBetter)
}
