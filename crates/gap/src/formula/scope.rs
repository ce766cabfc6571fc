//! Where a formula is looked for.

use crate::model::TrialModel;
use crate::place::{Place, Site};

/// Where a formula is looked for, and in which quantities.
#[derive(Clone, Debug)]
pub(crate) struct Scope {
    pub(crate) place: Place,
    pub(crate) displacement: bool,
    pub(crate) velocity: bool,
    /// Only a spring or a damper.
    pub(crate) linear: bool,
}

impl Scope {
    /// Every place of a model where a force can act, in all that the force may depend on.
    pub(super) fn everywhere(model: &TrialModel, linear: bool) -> Vec<Scope> {
        let forces = model.places().iter().filter(|p| matches!(p.site, Site::Force { .. }));
        forces.map(|place| Scope::at(place, linear)).collect()
    }

    /// A place, in all that a force there may depend on.
    pub(super) fn at(place: &Place, linear: bool) -> Scope {
        Scope { place: place.clone(), displacement: true, velocity: true, linear }
    }

    /// The same in a model with nodes of its own.
    pub(super) fn of(&self, model: &TrialModel) -> Vec<Scope> {
        let here = model.places().iter().filter(|p| p.is(&self.place));
        here.map(|place| Scope { place: place.clone(), ..*self }).collect()
    }
}
