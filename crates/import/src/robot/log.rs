//! The columns of a log by joint: which one is the place, the speed or the force of which.

use super::tree::{Motion, Robot};
use crate::draft::{PLENTY, count, counts, is_counted, name_columns};
use crate::headings::{ACCELERATIONS as RATES_OF_SPEED, Heading, Quantity, VELOCITIES};
use crate::no_draft::{NoDraft, blocking};
use crate::question::{Answers, Counted, Question};
use crate::roles::{ACCELERATIONS, COMMANDS, COPIES, DISPLACEMENTS, FORCES, TORQUES};
use crate::statistics::Statistics;
use crate::table::{Column, Table};
use crate::time_column::TimeColumn;

/// What a column says of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// Its coordinate.
    Place,
    /// Its speed.
    Speed,
    /// Its force or torque.
    Effort,
    /// The current of its motor.
    Current,
    /// What its motor was told.
    Command,
}

/// A log of a robot.
#[derive(Debug)]
pub struct Log {
    pub(super) table: Table,
    pub(super) time: TimeColumn,
    /// Joint, role and column, at most one of a role for each joint.
    pub(super) roles: Vec<(usize, Role, usize)>,
    /// What the user has to say before a search.
    pub questions: Vec<Question>,
}

impl Log {
    /// Finds the columns of the joints.
    ///
    /// # Errors
    /// No column can be the time, none belongs to a joint, or one of these holds text.
    pub fn of(mut table: Table, robot: &Robot, answers: &Answers) -> Result<Log, NoDraft> {
        name_columns(&mut table, &answers.columns).map_err(NoDraft::Columns)?;
        counts(&mut table, answers);
        let time = TimeColumn::find(&mut table, answers.rate).map_err(NoDraft::Time)?;
        let time = time.with_unit(&mut table, answers.time_unit.as_deref());
        let time = time.usable(&table).map_err(NoDraft::Time)?;
        let mut roles: Vec<(usize, Role, usize)> = vec![];
        for (k, column) in table.columns.iter().enumerate().filter(|(k, _)| *k != time.column) {
            let Some((joint, role)) = robot.role(&column.heading, &table) else { continue };
            if !roles.iter().any(|&(other, of, _)| (other, of) == (joint, role)) {
                roles.push((joint, role, k));
            }
        }
        if !roles.iter().any(|(_, role, _)| matches!(role, Role::Place | Role::Speed)) {
            let names = robot.joints().map(|joint| joint.name.clone()).collect();
            return Err(NoDraft::Joints(names));
        }
        let mut questions: Vec<Question> = time.question(&table).into_iter().collect();
        for &(_, role, k) in &roles {
            let column = &mut table.columns[k];
            if matches!(role, Role::Place | Role::Speed) && is_counted(&column.heading) {
                let unit = answers.unit_of(&column.heading).map(str::to_owned);
                count(column, unit.as_deref());
                let heading = column.heading.raw.clone();
                let of = Counted::Motion { said: true };
                if is_counted(&column.heading) {
                    questions.push(Question::Counts { heading, of });
                    // A spec takes them for radians or metres until somebody says it.
                    column.heading.unit = None;
                }
            }
        }
        let used = |k: usize| roles.iter().any(|&(.., c)| c == k);
        let kept: Vec<Column> =
            table.columns.iter().enumerate().filter(|(k, _)| used(*k)).map(|(_, c)| c.clone()).collect();
        let rows = 0..table.rows();
        let times = &table.columns[time.column].values;
        let statistics: Vec<Statistics> =
            kept.iter().map(|c| Statistics::of(times, &c.values, rows.clone())).collect();
        let alone = Table { columns: kept, ..table.clone() };
        if let Some(mistake) = blocking(&alone, &statistics) {
            return Err(NoDraft::Text(Box::new(mistake)));
        }
        Ok(Log { table, time, roles, questions })
    }

    /// The column of a joint.
    pub(super) fn column(&self, joint: usize, role: Role) -> Option<usize> {
        self.roles.iter().find(|&&(of, own, _)| (of, own) == (joint, role)).map(|&(.., column)| column)
    }

    /// The headings of the columns of a joint.
    pub(super) fn headings(&self, joint: usize) -> Vec<String> {
        let own = self.roles.iter().filter(|(of, ..)| *of == joint);
        own.map(|&(.., c)| format!("`{}`", self.table.columns[c].heading.raw)).collect()
    }

    /// Of so many rows one mean, where there are more than a fit needs.
    pub(super) fn decimation(&self) -> usize {
        self.table.rows().div_ceil(PLENTY).max(1)
    }

    /// Whether a column that the model reads has cells without a number.
    pub(super) fn has_holes(&self) -> bool {
        let empty = |&(.., k): &(usize, Role, usize)| self.table.columns[k].values.iter().any(|x| x.is_nan());
        self.roles.iter().any(empty)
    }
}

impl Robot {
    /// The joint and the role that a heading names.
    fn role(&self, heading: &Heading, table: &Table) -> Option<(usize, Role)> {
        let joints = self.joints().enumerate().map(|(k, joint)| (joint.name.as_str(), k, false));
        let motors = self.motors.iter().map(|motor| (motor.name.as_str(), motor.joint, true));
        // The longest name: `arm` stands in `forearm`, and `joint 1` may be a part of `joint 1 b`.
        let named = joints.chain(motors).filter_map(|(name, joint, motor)| {
            Some((name.len(), joint, motor, without(&heading.raw, name)?))
        });
        let (joint, motor, rest) = match named.max_by_key(|(length, _, motor, _)| (*length, !motor)) {
            Some((_, joint, motor, rest)) => (joint, motor, rest),
            None => {
                let (number, rest) = joint_number(heading)?;
                // Some count from zero.
                let from_zero =
                    table.columns.iter().any(|c| joint_number(&c.heading).is_some_and(|n| n.0 == 0));
                (number.checked_sub(usize::from(!from_zero))?, false, rest)
            }
        };
        if joint >= self.segments.len() {
            return None;
        }
        let words: Vec<&str> = rest.split(|c: char| !c.is_alphanumeric()).filter(|w| !w.is_empty()).collect();
        let has = |list: &[&str]| words.iter().any(|word| list.contains(word));
        if has(COPIES) || has(&["target", "desired", "goal", "setpoint", "ref", "reference"]) {
            return None;
        }
        let turns = self.segments[joint].joint.motion == Motion::Turn;
        let role = match heading.quantity {
            Quantity::Angle if turns => Role::Place,
            Quantity::Length if !turns => Role::Place,
            Quantity::AngularSpeed if turns => Role::Speed,
            Quantity::Speed if !turns => Role::Speed,
            Quantity::Torque if turns => Role::Effort,
            Quantity::Force if !turns => Role::Effort,
            Quantity::Electric if heading.unit.as_deref().is_some_and(|unit| unit.ends_with('A')) => {
                Role::Current
            }
            Quantity::Count if has(SPEEDS) || has(VELOCITIES) => Role::Speed,
            Quantity::Count => Role::Place,
            // What has another unit is another thing.
            Quantity::Unknown if !(has(RATES_OF_SPEED) || has(ACCELERATIONS)) => match () {
                () if has(CURRENTS) => Role::Current,
                () if has(COMMANDS) || has(ORDERS) => Role::Command,
                () if has(EFFORTS) || has(TORQUES) || has(FORCES) => Role::Effort,
                () if has(SPEEDS) || has(VELOCITIES) => Role::Speed,
                () if motor => Role::Command,
                () if words.is_empty() || has(PLACES) || has(DISPLACEMENTS) => Role::Place,
                () => return None,
            },
            _ => return None,
        };
        // What a motor makes reaches its joint through its gear.
        Some((joint, if motor && role == Role::Effort { Role::Command } else { role }))
    }
}

/// Words of logs of robots beside those of other rigs.
const PLACES: &[&str] = &["qpos", "joint", "actual", "state", "th"];
const SPEEDS: &[&str] = &["qvel", "qd", "dq", "qdot"];
const EFFORTS: &[&str] = &["effort", "tau", "qfrc", "trq"];
const ORDERS: &[&str] = &["ctrl", "control", "u"];
const CURRENTS: &[&str] = &["current", "i", "curr", "amp", "amps"];

/// What is left of a heading without this name, in lower case, if it holds that as words of its own.
fn without(heading: &str, name: &str) -> Option<String> {
    let (heading, name) = (heading.to_lowercase(), name.to_lowercase());
    let ends = |c: Option<char>| c.is_none_or(|c| !c.is_alphanumeric());
    let (at, _) = heading.match_indices(&name).find(|(at, _)| {
        ends(heading[..*at].chars().next_back()) && ends(heading[at + name.len()..].chars().next())
    })?;
    (!name.is_empty()).then(|| format!("{} {}", &heading[..at], &heading[at + name.len()..]))
}

/// The number of a joint in a heading, and what stands before it. `position[1]` is no position in a unit.
fn joint_number(heading: &Heading) -> Option<(usize, String)> {
    numbered(&heading.name).or_else(|| numbered(&heading.raw.to_lowercase()))
}

/// The number at the end of a name, and what stands before it: `tau_2`, `position[1]`, `q3`.
fn numbered(name: &str) -> Option<(usize, String)> {
    let name = name.trim_end_matches([']', ')', '_', ' ']);
    let rest = name.trim_end_matches(|c: char| c.is_ascii_digit());
    let number = name[rest.len()..].parse().ok()?;
    (!rest.is_empty()).then(|| (number, rest.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_joints_stand_as_words_of_their_own() {
        assert_eq!(
            without("/joint_states/elbow/position", "elbow").as_deref(),
            Some("/joint_states/ /position")
        );
        assert_eq!(without("joint10_pos", "joint1"), None);
        assert_eq!(numbered("actual_q_0"), Some((0, "actual_q_".to_owned())));
        assert_eq!(numbered("position[12]"), Some((12, "position[".to_owned())));
        assert_eq!(numbered("12"), None);
    }
}
