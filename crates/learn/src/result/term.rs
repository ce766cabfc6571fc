//! Terms that were identified.

use super::estimate::Estimate;

/// A term of the dictionary that was selected.
#[derive(Clone, Debug)]
pub struct FoundTerm {
    /// Index into [`phisindy_phys::System::terms`].
    pub term: usize,
    /// Its coefficient.
    pub coefficient: Estimate,
    /// Whether the coefficient ended at a bound of the spec.
    pub at_bound: bool,
    /// Its contribution along the motion; `None` where a Fit record could not be run freely.
    pub contribution: Option<Contribution>,
}

impl FoundTerm {
    /// A term of which only the coefficient is known yet.
    pub fn new(term: usize, coefficient: Estimate) -> FoundTerm {
        FoundTerm { term, coefficient, at_bound: false, contribution: None }
    }
}

/// Contribution of a term along the free runs of the Fit records. Forces where the spec states the inertia of
/// the state, else rates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contribution {
    /// Root mean square of the term (SI); a contact that sticks counts as zero.
    pub rms: f64,
    /// That over the root mean square of all terms of the state together: above 1 where terms work against
    /// each other.
    pub share: f64,
    /// Energy that it takes out of the motion of its state per second (SI), negative if it feeds the motion;
    /// `None` if the state is no velocity.
    pub power: Option<f64>,
    /// The same per cycle; `None` where the motion has no main frequency.
    pub per_cycle: Option<f64>,
}
