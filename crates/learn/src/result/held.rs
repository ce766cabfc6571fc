//! Constants that were held, and what hangs on them.

use super::quantity::Quantity;

/// A constant of the spec that the fit held.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldConstant {
    /// As in the spec.
    pub name: String,
    /// By how many per cent each number that was found moves if the constant is one per cent larger;
    /// not finite for a number that is not told from zero.
    pub moves: Vec<(Quantity, f64)>,
}
