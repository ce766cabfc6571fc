//! What a law acts on.

/// What a law acts on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Needs {
    /// A velocity.
    Velocity,
    /// A velocity that has a displacement.
    Displacement,
    /// A column of a sensor.
    Sensor,
    /// A recorded input.
    Input,
    /// A force of the known part.
    Load,
}
