//! The missing force where no law and no formula explains it.

/// What a missing force depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dependence {
    /// On the velocity alone.
    Velocity,
    /// On the displacement alone.
    Displacement,
    /// On both, one force added to the other.
    Sum,
    /// On both together.
    Together,
    /// At the same displacement and velocity it differs with what went before.
    Past,
    /// At the same displacement and velocity it changes in the course of a record.
    Time,
    /// Displacement and velocity do not determine it.
    More,
}

impl Dependence {
    /// Name in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Dependence::Velocity => "velocity",
            Dependence::Displacement => "displacement",
            Dependence::Sum => "displacement + velocity",
            Dependence::Together => "displacement and velocity",
            Dependence::Past => "the past",
            Dependence::Time => "time",
            Dependence::More => "more than displacement and velocity",
        }
    }
}

/// A point of the curve of a force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForcePoint {
    /// Displacement (SI) if the curve is over it.
    pub displacement: Option<f64>,
    /// Velocity (SI) if the curve is over it.
    pub velocity: Option<f64>,
    /// The force that is subtracted (SI).
    pub force: f64,
    /// Half the 95 % interval.
    pub band: f64,
}

/// The missing force along the motion, without a formula.
#[derive(Clone, Debug, PartialEq)]
pub struct MissingForce {
    /// The place, as [`crate::Place::at`], at which a force explains most.
    pub at: String,
    /// The units of the place, in which people read displacement, velocity and force; the points are in SI.
    pub units: [String; 3],
    /// What it depends on.
    pub on: Dependence,
    /// What the best force of displacement and velocity leaves, rms in units of the noise.
    pub left: f64,
    /// The curve, at the knots of a spline. A part in proportion to a constant of the model that may move is
    /// taken up by that constant.
    pub points: Vec<ForcePoint>,
}
