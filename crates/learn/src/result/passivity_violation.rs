//! Passive laws that feed the motion, as data. Texts are in [`super::words`]; [`super::passivity`] finds
//! them.

/// A passive law that feeds the motion. Numbers are in SI.
#[derive(Clone, Debug, PartialEq)]
pub enum PassivityViolation {
    /// The dry friction at a velocity puts energy into the motion.
    DryFriction {
        /// The velocity, in the language of the specs.
        velocity: String,
        /// The mean of its level along the motion, weighted by the speed: negative where it feeds.
        level: f64,
        /// Its 95 % interval.
        ci95: (f64, f64),
        /// Whether it is the level near rest, where what falls with the speed has no part in it.
        near_rest: bool,
        /// Its unit; empty if the spec does not determine it.
        unit: String,
    },
    /// The linear damping of a velocity is negative, whatever the motion does.
    Damping {
        /// Name of the velocity.
        state: String,
        /// Slope of its rate by itself (1/s): positive.
        slope: f64,
        /// Its 95 % interval; of zero width where the spec holds all of it.
        ci95: (f64, f64),
    },
    /// The only damper of a velocity stands in the known part with the wrong sign, and the fit had to make
    /// its constant negative.
    TurnedSign {
        /// Name of the velocity.
        state: String,
        /// Name of the constant.
        constant: String,
        /// Its value.
        value: f64,
        /// Its 95 % interval.
        ci95: (f64, f64),
        /// Its SI unit; empty for a plain number.
        unit: String,
    },
}

impl PassivityViolation {
    /// Whether it was fitted. What the spec holds is what the user says.
    pub(crate) fn is_fitted(&self) -> bool {
        !matches!(self, PassivityViolation::Damping { ci95, .. } if ci95.0 == ci95.1)
    }
}
