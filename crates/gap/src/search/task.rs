//! The inputs of a search.

use crate::result::Activity;
use phisindy_phys::LawEntry;

/// The inputs of a search.
pub(crate) struct Search<'a> {
    pub(crate) catalogue: &'a [LawEntry],
    pub(crate) noise: &'a [Vec<f64>],
    /// Gap on Validate records below which no effect is added: the repeatability of the rig.
    pub(crate) floor: f64,
    /// Receives the progress as a fraction and an activity; returns true to stop.
    pub(crate) observe: &'a mut dyn FnMut(f64, Activity) -> bool,
}
