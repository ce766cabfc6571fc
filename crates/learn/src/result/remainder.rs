//! The force that a model leaves.

/// What nobody measured and no law explains, on one body in one record.
#[derive(Clone, Debug, PartialEq)]
pub struct Remainder {
    /// Name of the record.
    pub record: String,
    /// Index of the state on whose rate it acts.
    pub state: usize,
    /// Its root mean square, in the unit of the rate (SI): a force over the inertia of the body.
    pub rms: f64,
    /// This as a part of the root mean square of the whole rate.
    pub share: f64,
    /// The part of the rate's size that follows the motion: a law that is missing.
    pub of_motion: f64,
    /// The stretch of the record (s) in which it is strongest.
    pub strongest: (f64, f64),
    /// The force at the times of the record: time (s), and force in the unit of `rms`.
    pub course: Vec<(f64, f64)>,
}
