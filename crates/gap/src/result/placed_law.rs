//! The name of a law at a place.

use crate::place::Effect;

/// A law at a place, by name.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct PlacedLaw {
    /// The law's id.
    pub law: String,
    /// The law's name, as it stands in a sentence.
    pub name: String,
    /// The place, as [`crate::Place::at`].
    pub at: String,
}

impl PlacedLaw {
    pub(crate) fn of(effect: &Effect) -> PlacedLaw {
        let entry = &effect.entry;
        PlacedLaw { law: entry.id.clone(), name: entry.law.name.clone(), at: effect.place.at.clone() }
    }
}
