//! What a search works with.

use crate::result::Activity;
use phisindy_phys::LawEntry;

/// What the search works with.
pub(crate) struct Search<'a> {
    pub(crate) catalogue: &'a [LawEntry],
    pub(crate) noise: &'a [Vec<f64>],
    /// Gap on Validate records below which nothing is added: what the rig repeats to.
    pub(crate) floor: f64,
    /// Is told of the progress, a fraction and what is being done; true to stop.
    pub(crate) observe: &'a mut dyn FnMut(f64, Activity) -> bool,
}
