//! The use that a draft makes of each column.

use crate::roles::{COMMANDS, Evidence, Input, Roles};
use crate::time_column::is_counter;
use std::fmt;

/// The use of a column. Headings are those of the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Usage {
    /// The time.
    Time,
    /// Mostly text.
    Text,
    /// Numbers and text.
    MixedText,
    /// The angle, a state.
    Angle,
    /// The displacement, a state.
    Displacement,
    /// The velocity, a state.
    Velocity,
    /// The motion of the base, an input.
    Base,
    /// The acceleration of the base, an input.
    BaseAcceleration,
    /// The force, an input.
    Force,
    /// The drive, an input.
    Drive,
    /// The motion that is prescribed, an input.
    Prescribed,
    /// The force that it meets, an output.
    Reaction,
    /// No cell has a value.
    Empty,
    /// More than half of it is missing.
    Missing,
    /// One value only.
    Constant,
    /// Counts rows or tells the time.
    Counter,
    /// Another column has its heading.
    Namesake,
    /// A copy of the column with this heading.
    Copy(String),
    /// Noise only.
    Noise,
    /// Selects rows.
    Selector,
    /// A velocity beside the displacement.
    UnusedVelocity,
    /// The acceleration of the model.
    Accelerometer,
    /// An acceleration.
    Acceleration,
    /// Could select rows.
    FewValues,
    /// A command, perhaps proportional to a column that is used.
    Command(Option<String>),
    /// Anything else, perhaps proportional to a column that is used.
    Unused(Option<String>),
}

impl fmt::Display for Usage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = match self {
            Usage::Time => "time",
            Usage::Text => "words, not used",
            Usage::MixedText => "not used: words stand among the numbers",
            Usage::Angle => "the angle, state theta",
            Usage::Displacement => "the displacement, state x",
            Usage::Velocity => "the velocity",
            Usage::Accelerometer => "the acceleration, output a",
            Usage::Base => "the motion of the base, input u",
            Usage::BaseAcceleration => "the acceleration of the base, input ab",
            Usage::Force => "the force, input F",
            Usage::Drive => "the drive, input F",
            Usage::Prescribed => "the motion that is prescribed, input x",
            Usage::Reaction => "the force that it meets, output F",
            Usage::Empty => "empty",
            Usage::Missing => "not used: more than half of it is missing",
            Usage::Constant => "constant, not used",
            Usage::Counter => "counts rows or tells the time, not used",
            Usage::Namesake => "not used: another column has its heading",
            Usage::Copy(of) => return write!(f, "not used: another form of `{of}`"),
            Usage::Noise => "nothing but noise, not used",
            Usage::Selector => "selects rows",
            Usage::UnusedVelocity => "a velocity, not used: it follows from the displacement",
            Usage::Acceleration => "an acceleration, not used",
            Usage::FewValues => "a few whole numbers: can select rows",
            Usage::Command(_) => "a command, not used",
            Usage::Unused(_) => "not used",
        };
        f.write_str(text)?;
        match self {
            Usage::Command(Some(of)) | Usage::Unused(Some(of)) => {
                write!(f, ", which is proportional to `{of}`")
            }
            _ => Ok(()),
        }
    }
}

impl Usage {
    /// The use of column `k`.
    pub(crate) fn of(k: usize, evidence: &Evidence<'_>, roles: &Roles) -> Usage {
        let (column, statistics) = (&evidence.table.columns[k], &evidence.statistics[k]);
        let rows = evidence.table.rows();
        let name = |p: usize| evidence.name(p).to_owned();
        if k == evidence.time.column {
            Usage::Time
        } else if column.text_cells * 2 > rows {
            Usage::Text
        } else if column.text_cells > 0 {
            Usage::MixedText
        } else if let Some(used) = Usage::in_model(k, roles) {
            used
        } else if statistics.missing == rows {
            Usage::Empty
        } else if statistics.missing * 2 >= rows {
            Usage::Missing
        } else if statistics.is_constant() {
            Usage::Constant
        } else if is_counter(column) {
            Usage::Counter
        } else if evidence.is_namesake(k) {
            Usage::Namesake
        } else if let Some(original) = evidence.original(k) {
            Usage::Copy(name(original))
        } else if evidence.is_noise(k) {
            Usage::Noise
        } else if roles.selector.as_ref().is_some_and(|f| f.column == k) {
            Usage::Selector
        } else if roles.velocities.contains(&k) {
            Usage::UnusedVelocity
        } else if roles.accelerations.contains(&k) {
            Usage::Acceleration
        } else if statistics.values.is_some() {
            Usage::FewValues
        } else {
            let proportional = proportional(k, evidence, roles).map(name);
            let command = evidence.heading(k).has_word(COMMANDS);
            if command { Usage::Command(proportional) } else { Usage::Unused(proportional) }
        }
    }

    /// The use of a column that the model reads.
    fn in_model(k: usize, roles: &Roles) -> Option<Usage> {
        if Some(k) == roles.displacement {
            if let Input::Reaction(_) = roles.input {
                return Some(Usage::Prescribed);
            }
            return Some(if roles.is_angle { Usage::Angle } else { Usage::Displacement });
        }
        if Some(k) == roles.velocity {
            return Some(Usage::Velocity);
        }
        if Some(k) == roles.acceleration {
            return Some(Usage::Accelerometer);
        }
        match roles.input {
            Input::Base(b) if b == k => Some(Usage::Base),
            Input::BaseAcceleration(b) if b == k => Some(Usage::BaseAcceleration),
            Input::Force(b) if b == k => Some(Usage::Force),
            Input::Drive(b) if b == k => Some(Usage::Drive),
            Input::Reaction(b) if b == k => Some(Usage::Reaction),
            _ => None,
        }
    }
}

/// The column of the model to which column `k` is proportional.
fn proportional(k: usize, evidence: &Evidence<'_>, roles: &Roles) -> Option<usize> {
    roles.used().find(|&p| {
        p != k
            && evidence.statistics[p].values.is_none()
            && !evidence.statistics[k].is_constant()
            && evidence.correlation(p, k).abs() > 0.9999
    })
}
