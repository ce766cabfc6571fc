//! The role of each column in the model, guessed from its name, its unit and its numbers.

mod evidence;
mod names;

use crate::headings::{Quantity, VELOCITIES, factor};
use crate::rig::Rig;
pub(crate) use evidence::Evidence;
pub(crate) use names::{
    ACCELERATIONS, COMMANDS, COPIES, DISPLACEMENTS, ENCODERS, FORCES, LENGTHS, TORQUES, is_word_of_a_role,
};
use names::{ANGLES, BASES, OUTPUTS};
use std::fmt;

/// The input of the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Input {
    /// No input is measured.
    None,
    /// The motion of the base.
    Base(usize),
    /// The acceleration of the base, beside that of the body.
    BaseAcceleration(usize),
    /// A force or a torque.
    Force(usize),
    /// A signal in proportion to a force, such as a voltage.
    Drive(usize),
    /// The force that a prescribed motion meets: the motion is the input, the force an output.
    Reaction(usize),
}

impl Input {
    /// Index of its column.
    pub fn column(self) -> Option<usize> {
        match self {
            Input::None => None,
            Input::Base(k)
            | Input::BaseAcceleration(k)
            | Input::Force(k)
            | Input::Drive(k)
            | Input::Reaction(k) => Some(k),
        }
    }
}

/// A column that selects rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Selector {
    /// Index of the column.
    pub column: usize,
    /// The value of the rows that are selected.
    pub value: f64,
}

/// Why a role is uncertain. Headings are those of the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Doubt {
    /// The displacement has no unit of length or angle.
    NoUnit(String),
    /// One of two displacements is taken for the base.
    Base(String),
    /// The column is taken for the drive.
    Drive(String),
}

impl fmt::Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Doubt::NoUnit(heading) => write!(
                f,
                "taken for the displacement: the heading `{heading}` has no unit of length or angle"
            ),
            Doubt::Base(heading) => write!(
                f,
                "two displacements and no word which one moves the other: `{heading}` is taken for the base (exchange the two headings if it is not)"
            ),
            Doubt::Drive(heading) => {
                write!(f, "`{heading}` is taken for what drives the motion, in proportion to a force")
            }
        }
    }
}

/// Why no column can be the motion.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NoMotion {
    /// No column varies and holds numbers only.
    NoSignal,
    /// The file lacks a column of the rig that the user says.
    Lacks {
        /// The rig.
        rig: Rig,
        /// What is not there.
        what: &'static str,
    },
}

impl fmt::Display for NoMotion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NoMotion::NoSignal => {
                f.write_str("no column of motion is left: none varies and holds numbers only")
            }
            NoMotion::Lacks { rig, what } => write!(f, "for `--rig {rig}` there is no column of {what}"),
        }
    }
}

/// The roles of the columns, by index.
#[derive(Clone, Debug)]
pub struct Roles {
    /// Displacement or angle; `None` if only a velocity is measured.
    pub displacement: Option<usize>,
    /// Velocity, if no displacement is measured.
    pub velocity: Option<usize>,
    /// Acceleration, if neither is measured.
    pub acceleration: Option<usize>,
    /// The displacement of a second body, between the first one and the base.
    pub wheel: Option<usize>,
    /// The input.
    pub input: Input,
    /// What would be taken for a drive if the user did not say that nothing drives.
    pub denied: Option<usize>,
    /// Whether the motion is an angle.
    pub is_angle: bool,
    /// Selects the rows in which the drive is off or the data are valid.
    pub selector: Option<Selector>,
    /// All velocities.
    pub velocities: Vec<usize>,
    /// All accelerations.
    pub accelerations: Vec<usize>,
    /// Why the displacement is uncertain.
    pub doubt: Option<Doubt>,
    /// Why the input is uncertain.
    pub input_doubt: Option<Doubt>,
}

impl Roles {
    /// The displacement, or else the velocity, or else the acceleration.
    pub(crate) fn moving(&self) -> Option<usize> {
        self.displacement.or(self.velocity).or(self.acceleration)
    }

    /// The columns that the model reads.
    pub fn used(&self) -> impl Iterator<Item = usize> {
        self.moving().into_iter().chain(self.wheel).chain(self.input.column())
    }

    /// Signals whose role no name, no unit and no number tells, beside a displacement of which that is true
    /// too: what drives the motion may be among them.
    pub(crate) fn untold(&self, evidence: &Evidence<'_>) -> Vec<usize> {
        // Volts are what any sensor gives.
        let nameless = |k: usize| {
            let heading = evidence.heading(k);
            matches!(heading.quantity, Quantity::Unknown | Quantity::Electric)
                && !is_word_of_a_role(heading)
                && !heading.has_word(COMMANDS)
                && !heading.is_capital_t()
        };
        // Three axes of what? Sensors of phones write them so.
        let axis = |k: usize| matches!(evidence.heading(k).raw.trim(), "x" | "y" | "z");
        let axes: Vec<usize> = evidence.signals().into_iter().filter(|&k| axis(k)).collect();
        if axes.len() == 3 && matches!(self.input, Input::None | Input::Base(_)) {
            return axes;
        }
        let Some(moving) = self.displacement.filter(|&k| nameless(k)) else { return vec![] };
        let free = |&k: &usize| {
            k != moving && nameless(k) && !self.velocities.contains(&k) && !self.accelerations.contains(&k)
        };
        let others: Vec<usize> = evidence.signals().into_iter().filter(free).collect();
        match self.input {
            Input::None if !others.is_empty() => [moving].into_iter().chain(others).collect(),
            Input::Drive(k) if nameless(k) => [moving].into_iter().chain(others).collect(),
            _ => vec![],
        }
    }

    /// Guesses the roles.
    ///
    /// # Errors
    /// No column can be the motion.
    pub(crate) fn guess(evidence: &Evidence<'_>, rig: Option<Rig>) -> Result<Roles, NoMotion> {
        Guess { evidence, signals: evidence.signals(), rig }.roles()
    }
}

struct Guess<'a> {
    evidence: &'a Evidence<'a>,
    /// Columns that hold a signal.
    signals: Vec<usize>,
    /// What the user says.
    rig: Option<Rig>,
}

impl Guess<'_> {
    fn quantity(&self, k: usize) -> Quantity {
        self.evidence.heading(k).quantity
    }

    fn named(&self, k: usize, words: &[&str]) -> bool {
        self.evidence.heading(k).has_word(words)
    }

    /// Whether the unit does not tell the role of the column.
    fn is_unclear(&self, k: usize) -> bool {
        matches!(self.quantity(k), Quantity::Unknown | Quantity::Other | Quantity::Count)
    }

    /// The signals that pass a test.
    fn signals(&self, test: impl Fn(usize) -> bool) -> Vec<usize> {
        self.signals.iter().copied().filter(|&k| test(k)).collect()
    }

    fn roles(&self) -> Result<Roles, NoMotion> {
        let raw = |k: usize| self.evidence.name(k).to_owned();
        // Velocities by unit and by name; those that only the numbers reveal follow below.
        let mut velocities =
            self.signals(|k| matches!(self.quantity(k), Quantity::Speed | Quantity::AngularSpeed));
        velocities.extend(self.signals(|k| self.is_unclear(k) && self.named(k, VELOCITIES)));
        let accelerations = self.signals(|k| {
            self.quantity(k) == Quantity::Acceleration || (self.is_unclear(k) && self.named(k, ACCELERATIONS))
        });
        let rest = self.signals(|k| !velocities.contains(&k) && !accelerations.contains(&k));
        let told = !velocities.is_empty() || !accelerations.is_empty();
        let (mut displacements, doubt) = self.displacements(&rest, told, &velocities);
        // A column that equals the derivative of a displacement is a velocity.
        let derivatives = self.signals(|k| {
            rest.contains(&k)
                && self.is_unclear(k)
                && displacements.iter().any(|&p| p != k && self.evidence.is_derivative(p, k))
        });
        velocities.extend(derivatives);
        displacements.retain(|p| !velocities.contains(p));
        let (displacement, base, mut input_doubt) = self.body_and_base(&displacements);
        let shaken = self.said_base_acceleration(&displacements, &velocities, &accelerations);
        let (base, wheel) = match shaken {
            Some(_) => (None, None),
            None => self.said_base(&displacements, displacement, base)?,
        };
        if self.rig.is_some() {
            input_doubt = None;
        }
        self.said_motion(displacement, velocities.first().copied())?;
        // Beside a displacement a velocity adds nothing: it was usually computed from it, with delay and
        // smoothing. Of several axes the one that moves is meant.
        let velocity = displacement.is_none().then(|| self.most_moving(&velocities)).flatten();
        let is_angle = displacement.or(velocity).is_some_and(|k| self.is_angle(k));
        let moves = displacement.is_some() || velocity.is_some();
        let of_body: Vec<usize> = accelerations.iter().copied().filter(|k| Some(*k) != shaken).collect();
        let acceleration = (!moves).then(|| self.most_moving(&of_body)).flatten();
        if !moves && acceleration.is_none() {
            return Err(NoMotion::NoSignal);
        }
        let beside =
            |k: usize| Some(k) != displacement && !velocities.contains(&k) && !accelerations.contains(&k);
        let seen = self.force(displacement, base, &velocities, &accelerations);
        let force = self.said_force(seen, beside)?;
        let denied = seen.filter(|_| force.is_none());
        // What moves in volts or counts has no mass in kilograms.
        let moving = displacement.or(velocity).or(acceleration);
        let mechanical = moving.is_some_and(|k| {
            !matches!(self.quantity(k), Quantity::Electric | Quantity::Count | Quantity::Other)
        });
        let mut input = match (base, force) {
            (Some(base), _) => Input::Base(base),
            (None, Some(k))
                if mechanical
                    && self.quantity(k) == if is_angle { Quantity::Torque } else { Quantity::Force } =>
            {
                Input::Force(k)
            }
            (None, Some(k)) => Input::Drive(k),
            (None, None) => Input::None,
        };
        if let (Some(Rig::Tester), Some(k)) = (self.rig, force) {
            input = Input::Reaction(k);
        }
        if let Some(base) = shaken {
            input = Input::BaseAcceleration(base);
        }
        if let (Input::Drive(k), None) = (input, &input_doubt) {
            input_doubt = Some(Doubt::Drive(raw(k)));
        }
        let selector = self.selector();
        // In rows with the drive off the input has no effect.
        if selector.is_some() && !matches!(input, Input::Base(_)) {
            (input, input_doubt) = (Input::None, None);
        }
        Ok(Roles {
            displacement,
            velocity,
            acceleration,
            wheel,
            input,
            denied,
            is_angle,
            selector,
            velocities,
            accelerations,
            doubt,
            input_doubt,
        })
    }

    /// Of columns in the unit of the first of them, the one that moves most.
    fn most_moving(&self, columns: &[usize]) -> Option<usize> {
        let first = *columns.first()?;
        let size =
            |k: usize| self.evidence.statistics[k].std * factor(self.evidence.heading(k).unit.as_deref());
        let unclear = |k: usize| self.is_unclear(k) && self.is_unclear(first);
        let alike =
            columns.iter().copied().filter(|&k| self.quantity(k) == self.quantity(first) || unclear(k));
        // Of equal ones the first.
        alike.rev().max_by(|a, b| size(*a).total_cmp(&size(*b)))
    }

    /// Displacements by unit, or else by name. `rest` are the columns that are neither velocities nor
    /// accelerations; `told` says whether there are any of these.
    fn displacements(&self, rest: &[usize], told: bool, velocities: &[usize]) -> (Vec<usize>, Option<Doubt>) {
        let command = |k: usize| self.named(k, COMMANDS);
        let by_unit = |k: usize| matches!(self.quantity(k), Quantity::Length | Quantity::Angle);
        let displacements: Vec<usize> = rest.iter().copied().filter(|&k| by_unit(k) && !command(k)).collect();
        if !displacements.is_empty() {
            return (displacements, None);
        }
        // Typical names of outputs come first: `u` is an input if there is a `y`.
        let free = |k: usize| !command(k) && !matches!(self.quantity(k), Quantity::Force | Quantity::Torque);
        let candidates: Vec<usize> = rest.iter().copied().filter(|&k| free(k)).collect();
        let best = candidates
            .iter()
            .find(|&&k| self.named(k, OUTPUTS) || self.named(k, DISPLACEMENTS))
            .or_else(|| {
                // Beside a velocity a voltage or a current drives.
                let drives = |k: usize| {
                    self.named(k, FORCES)
                        || self.evidence.heading(k).is_capital_t()
                        || (told && self.quantity(k) == Quantity::Electric)
                };
                // Beside a velocity a column without a name is a displacement if it is its integral.
                let moves = |k: usize| !told || velocities.iter().any(|&v| self.evidence.is_derivative(k, v));
                candidates.iter().find(|&&k| !drives(k) && moves(k))
            })
            .or_else(|| (!told).then(|| candidates.first()).flatten())
            .copied();
        let Some(best) = best else { return (vec![], None) };
        // A second column without unit may be the base.
        let twins = candidates.iter().copied().filter(|&k| {
            k != best
                && self.is_unclear(k)
                && self.is_unclear(best)
                && (self.named(k, BASES) || self.named(k, DISPLACEMENTS))
                && !self.named(k, &["in", "input", "u"])
        });
        // What is counted is asked for, and is in counts until then.
        let counted = self.quantity(best) == Quantity::Count;
        let doubt = (!counted).then(|| Doubt::NoUnit(self.evidence.name(best).to_owned()));
        ([best].into_iter().chain(twins).collect(), doubt)
    }

    fn is_angle(&self, k: usize) -> bool {
        // A torque acts on an angle.
        let torque = |&k: &usize| self.quantity(k) == Quantity::Torque || self.named(k, TORQUES);
        let turns = || self.named(k, ANGLES) || (!self.named(k, LENGTHS) && self.signals.iter().any(torque));
        matches!(self.quantity(k), Quantity::Angle | Quantity::AngularSpeed)
            || (self.is_unclear(k) && self.rig.and_then(Rig::turns).unwrap_or_else(turns))
    }

    /// The accelerometer on the base of a rig of which the user says that its base moves, where nothing but
    /// accelerations is measured: the one whose name says so, or else the last.
    fn said_base_acceleration(
        &self,
        displacements: &[usize],
        velocities: &[usize],
        accelerations: &[usize],
    ) -> Option<usize> {
        let alone = displacements.is_empty() && velocities.is_empty() && accelerations.len() > 1;
        let (true, Some(Rig::BaseExcited)) = (alone, self.rig) else { return None };
        let named = accelerations.iter().copied().find(|&k| self.named(k, BASES));
        named.or(accelerations.last().copied())
    }

    /// The base, and the wheel before it, as the rig that the user says has them.
    fn said_base(
        &self,
        displacements: &[usize],
        body: Option<usize>,
        base: Option<usize>,
    ) -> Result<(Option<usize>, Option<usize>), NoMotion> {
        let Some(rig) = self.rig else { return Ok((base, None)) };
        if !rig.has_base() {
            return Ok((None, None));
        }
        let lacks = |what| NoMotion::Lacks { rig, what };
        let last = || displacements.iter().copied().rfind(|k| Some(*k) != body);
        let base = base.or_else(last).ok_or(lacks("the motion of the base"))?;
        let between = || displacements.iter().copied().find(|k| Some(*k) != body && *k != base);
        match rig {
            Rig::QuarterCar => {
                Ok((Some(base), Some(between().ok_or(lacks("the displacement of the wheel"))?)))
            }
            _ => Ok((Some(base), None)),
        }
    }

    /// Whether what moves is what moves of the rig that the user says, as far as its unit tells.
    fn said_motion(&self, displacement: Option<usize>, velocity: Option<usize>) -> Result<(), NoMotion> {
        let Some(rig) = self.rig else { return Ok(()) };
        let lacks = |what| Err(NoMotion::Lacks { rig, what });
        let measured = displacement.or(velocity).map(|moving| self.quantity(moving));
        match (rig.turns(), measured) {
            (Some(true), Some(Quantity::Length | Quantity::Speed)) => lacks("an angle"),
            (Some(false), Some(Quantity::Angle | Quantity::AngularSpeed)) => {
                lacks("a displacement along a line")
            }
            // What it meets is drawn over the way.
            _ if rig == Rig::Tester && displacement.is_none() => lacks("a displacement along a line"),
            _ => Ok(()),
        }
    }

    /// The force or drive as the rig that the user says has it: one that must be there may have any name.
    fn said_force(
        &self,
        force: Option<usize>,
        beside: impl Fn(usize) -> bool,
    ) -> Result<Option<usize>, NoMotion> {
        let Some((rig, driven)) = self.rig.and_then(|rig| Some((rig, rig.is_driven()?))) else {
            return Ok(force);
        };
        if !driven {
            return Ok(None);
        }
        // What a tester reads is a force; what drives another rig may be a current.
        let tester = rig == Rig::Tester;
        let acts = |k: usize| match self.quantity(k) {
            Quantity::Force | Quantity::Unknown => true,
            Quantity::Torque | Quantity::Electric => !tester,
            _ => false,
        };
        let any = || self.signals(|k| beside(k) && acts(k));
        let force = force.filter(|&k| acts(k)).or_else(|| any().first().copied());
        let what = if tester { "a force" } else { "a force, torque, current or voltage" };
        force.map(Some).ok_or(NoMotion::Lacks { rig, what })
    }

    /// The column that says most about the force.
    fn force(
        &self,
        displacement: Option<usize>,
        base: Option<usize>,
        velocities: &[usize],
        accelerations: &[usize],
    ) -> Option<usize> {
        let mut forces = self.signals(|k| {
            let by_unit = matches!(self.quantity(k), Quantity::Force | Quantity::Torque | Quantity::Electric);
            let named = self.named(k, FORCES) || self.evidence.heading(k).is_capital_t();
            let by_name = self.is_unclear(k) && named && !self.named(k, COMMANDS) && Some(k) != base;
            let other = Some(k) == displacement || accelerations.contains(&k) || velocities.contains(&k);
            (by_unit || by_name) && !other
        });
        // Forces and torques first, then voltages and currents. A supply voltage hardly varies.
        let rank = |k: usize| match self.quantity(k) {
            Quantity::Force | Quantity::Torque => 0,
            _ if self.named(k, &["supply", "battery", "temperature"]) => 3,
            Quantity::Electric => 1,
            _ => 2,
        };
        forces.sort_by_key(|&k| rank(k));
        forces.into_iter().find(|&k| rank(k) < 3)
    }

    /// Which of several displacements belongs to the body, and which to the base.
    fn body_and_base(&self, displacements: &[usize]) -> (Option<usize>, Option<usize>, Option<Doubt>) {
        let named = |k: usize| self.named(k, BASES);
        // Equal signals are one sensor in two forms, or a command and its response.
        let same = |p: usize, k: usize| self.evidence.correlation(p, k).abs() > 0.9999;
        let distinct: Vec<usize> = displacements
            .iter()
            .enumerate()
            .filter(|(i, k)| !displacements[..*i].iter().any(|p| same(*p, **k)))
            .map(|(_, k)| *k)
            .collect();
        let body = distinct.iter().copied().find(|k| !named(*k)).or(distinct.first().copied());
        let others = || distinct.iter().copied().filter(|k| Some(*k) != body);
        let Some(body) = body else { return (None, None, None) };
        if let Some(base) = others().find(|k| named(*k)) {
            return (Some(body), Some(base), None);
        }
        let alike = |k: &usize| self.quantity(*k) == self.quantity(body);
        let Some(other) = others().find(alike) else { return (Some(body), None, None) };
        // Of the two, the base moves more like a sine: friction distorts the motion of the body.
        let share = |k: usize| self.evidence.statistics[k].line.map_or(0.0, |l| l.share);
        let (body, other) = if share(body) > share(other) + 0.01 { (other, body) } else { (body, other) };
        (Some(body), Some(other), Some(Doubt::Base(self.evidence.name(other).to_owned())))
    }

    /// A column of zeros and ones that tells when the drive is off or the data are valid.
    fn selector(&self) -> Option<Selector> {
        let on: &[&str] = &["enabled", "enable", "on", "active", "power", "engaged"];
        let good: &[&str] = &["valid", "ok", "good"];
        let Evidence { table, statistics, .. } = self.evidence;
        (0..table.columns.len()).find_map(|column| {
            let value = if self.named(column, on) {
                0.0
            } else if self.named(column, good) {
                1.0
            } else {
                return None;
            };
            let both = statistics[column].values.as_deref() == Some(&[0.0, 1.0]);
            let rows = table.columns[column].values.iter().filter(|x| **x == value).count();
            (both && rows * 20 > table.rows()).then_some(Selector { column, value })
        })
    }
}
