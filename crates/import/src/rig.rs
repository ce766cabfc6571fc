//! The kind of rig that a file is of, where the user says it.

use std::fmt;

/// A kind of rig.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rig {
    /// A body that a force or a drive moves along a line.
    Slider,
    /// An angle that gravity pulls back.
    Pendulum,
    /// A rotor that a torque, a current or a voltage turns; nothing pulls it back.
    Motor,
    /// A body on a base that moves.
    BaseExcited,
    /// A body on a wheel on a road.
    QuarterCar,
    /// A motion that is prescribed, and the force that it meets.
    Tester,
    /// An angle that a drive turns and gravity pulls.
    RobotJoint,
    /// Nothing drives it.
    Free,
}

impl Rig {
    /// All kinds, with the names that users give them.
    pub const ALL: [(&'static str, Rig); 8] = [
        ("slider", Rig::Slider),
        ("pendulum", Rig::Pendulum),
        ("motor", Rig::Motor),
        ("base-excited", Rig::BaseExcited),
        ("quarter-car", Rig::QuarterCar),
        ("tester", Rig::Tester),
        ("robot-joint", Rig::RobotJoint),
        ("free", Rig::Free),
    ];

    /// The kind of this name.
    ///
    /// # Errors
    /// In words: the names that there are.
    ///
    /// ```
    /// use phisindy_import::Rig;
    /// assert_eq!(Rig::parse("base-excited"), Ok(Rig::BaseExcited));
    /// assert!(Rig::parse("crane").unwrap_err().contains("quarter-car"));
    /// ```
    pub fn parse(text: &str) -> Result<Rig, String> {
        let own = Rig::ALL.iter().find(|(name, _)| *name == text.trim()).map(|(_, rig)| *rig);
        own.ok_or_else(|| format!("one of {}", Rig::ALL.map(|(name, _)| name).join(", ")))
    }

    /// Whether its base moves.
    pub(crate) fn has_base(self) -> bool {
        matches!(self, Rig::BaseExcited | Rig::QuarterCar)
    }

    /// Whether a force or a drive must be measured; none if it may be.
    pub(crate) fn is_driven(self) -> Option<bool> {
        match self {
            Rig::Slider | Rig::Motor | Rig::Tester | Rig::RobotJoint => Some(true),
            Rig::BaseExcited | Rig::QuarterCar | Rig::Free => Some(false),
            Rig::Pendulum => None,
        }
    }

    /// Whether it turns; none if it may.
    pub(crate) fn turns(self) -> Option<bool> {
        match self {
            Rig::Pendulum | Rig::Motor | Rig::RobotJoint => Some(true),
            Rig::Slider | Rig::QuarterCar | Rig::Tester => Some(false),
            Rig::BaseExcited | Rig::Free => None,
        }
    }

    /// Whether gravity pulls it back; none where the data may tell.
    pub(crate) fn hangs(self) -> Option<bool> {
        match self {
            Rig::Pendulum | Rig::RobotJoint => Some(true),
            Rig::Free => None,
            _ => Some(false),
        }
    }
}

impl fmt::Display for Rig {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = Rig::ALL.iter().find(|(_, rig)| rig == self).map_or("", |(name, _)| name);
        f.write_str(name)
    }
}
