//! What a search tried, and what it could not try.

use super::finding::Veto;
use super::placed_law::PlacedLaw;
use crate::decisions::EXPLAINED;
use crate::place::Needs;
use std::fmt;

/// A law that was tried at a place of the model as it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Tried {
    /// Law and place.
    pub at: PlacedLaw,
    /// How much the law lowers the criterion by itself: of the fit where it was fitted, else of the
    /// regression.
    pub score: f64,
    /// The gap that its fit leaves; `None` where others did so much better that it was not fitted.
    pub gap: Option<f64>,
    /// The probability of the law among those that explain the records by themselves; each of its numbers halves what it
    /// had beforehand (Wrinch and Jeffreys 1921, doi 10.1080/14786442108633773). `None` for a law that does not.
    pub probability: Option<f64>,
    /// The evidence that rules it out.
    pub vetoed: Option<Veto>,
}

/// A law that was not tried.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NotTried {
    /// Its id.
    pub law: String,
    /// Why not.
    pub why: WhyNot,
}

/// Why a law was not tried.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum WhyNot {
    /// The model has no place of its kind.
    NoPlace(Needs),
    /// It uses a name that the model does not have.
    UnknownName(String),
    /// Along the records it does what start states and movable constants do, or nothing.
    NotSeen,
    /// It would need numbers outside of its bounds.
    OutOfBounds,
    /// Its forces are not finite along the records.
    NotFinite,
    /// It oscillates, and what is left has no spectral line to start from.
    NoTone,
    /// It has no parameter.
    NothingToFind,
}

impl fmt::Display for WhyNot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            WhyNot::NoPlace(needs) => {
                let what = match needs {
                    Needs::Velocity => "velocity",
                    Needs::Displacement => "velocity with a displacement",
                    Needs::Sensor => "measured column",
                    Needs::Input => "recorded input",
                    Needs::Load => "spring or input whose force could load it",
                };
                write!(f, "the model has no {what}")
            }
            WhyNot::UnknownName(name) => write!(f, "it uses `{name}`, which the model does not have"),
            WhyNot::NotSeen => {
                f.write_str("along these records it does nothing that start states and free numbers do not")
            }
            WhyNot::OutOfBounds => f.write_str("it fits only with parameters outside their bounds"),
            WhyNot::NotFinite => f.write_str("its force is not finite along these records"),
            WhyNot::NoTone => f.write_str("what the model leaves has no frequency of its own"),
            WhyNot::NothingToFind => {
                f.write_str("it has no parameter to find; write it into `known` instead")
            }
        }
    }
}

/// Sets the probability of those that explain the records and are not ruled out: half the difference of the
/// criterion is the logarithm of a ratio of likelihoods. Where none explains, the best of them may be far
/// from right.
pub(crate) fn weighed(all: &mut [Tried]) {
    let counts =
        |t: &Tried| t.gap.is_some_and(|gap| gap < EXPLAINED) && t.vetoed.is_none() && t.score.is_finite();
    let best = all.iter().filter(|t| counts(t)).map(|t| t.score).fold(f64::NEG_INFINITY, f64::max);
    let weight = |t: &Tried| (0.5 * (t.score - best)).exp();
    let sum: f64 = all.iter().filter(|t| counts(t)).map(weight).sum();
    for t in all.iter_mut() {
        t.probability = counts(t).then(|| weight(t) / sum);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn probabilities_are_those_of_the_laws_that_were_fitted() {
        let tried = |score: f64, gap: Option<f64>, vetoed: Option<Veto>| Tried {
            at: PlacedLaw { law: "coulomb".into(), name: "Coulomb friction".into(), at: "v".into() },
            score,
            gap,
            probability: None,
            vetoed,
        };
        let mut all = vec![
            tried(100.0, Some(1.0), None),
            tried(100.0 - 2.0 * 3f64.ln(), Some(1.05), None),
            tried(500.0, Some(0.9), Some(Veto::Pushes)),
            tried(90.0, None, None),
            tried(200.0, Some(5.0), None),
        ];
        weighed(&mut all);
        let found: Vec<Option<f64>> = all.iter().map(|t| t.probability).collect();
        assert!(
            (found[0].unwrap() - 0.75).abs() < 1e-12 && (found[1].unwrap() - 0.25).abs() < 1e-12,
            "{found:?}"
        );
        assert_eq!(found[2..], [None, None, None]);
    }
}
