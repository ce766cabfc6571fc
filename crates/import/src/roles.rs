//! What each column is for: a guess from its name, its unit and its numbers.

mod evidence;
mod names;

use crate::headings::{Quantity, SPEEDS};
pub(crate) use evidence::Evidence;
pub(crate) use names::ORDERS;
use names::{ACCELERATIONS, BASES, FORCES, OUTPUTS, PLACES};
use std::fmt;

/// What acts on the body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Input {
    /// Nothing that is measured.
    None,
    /// The motion of what it hangs on.
    Base(usize),
    /// A force or torque in its own unit.
    Force(usize),
    /// Something proportional to a force: a voltage, a number without unit.
    Drive(usize),
}

impl Input {
    /// Its column.
    pub fn column(self) -> Option<usize> {
        match self {
            Input::None => None,
            Input::Base(k) | Input::Force(k) | Input::Drive(k) => Some(k),
        }
    }
}

/// A column that selects rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Selector {
    /// Which column.
    pub column: usize,
    /// The value to take.
    pub value: f64,
}

/// Why a role may be another one. Headings are those of the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Doubt {
    /// This displacement has no unit of length or angle.
    NoUnit(String),
    /// Of two displacements this one is taken for the base.
    Base(String),
    /// This column is taken for what drives.
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

/// Why no column is the motion.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NoMotion {
    /// No column varies and holds numbers only.
    NoSignal,
    /// Only this acceleration is measured.
    Acceleration(String),
}

impl fmt::Display for NoMotion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NoMotion::NoSignal => {
                f.write_str("no column of motion is left: none varies and holds numbers only")
            }
            NoMotion::Acceleration(heading) => {
                write!(f, "`{heading}` is an acceleration, and no displacement or velocity is measured")
            }
        }
    }
}

/// The parts that the columns play.
#[derive(Clone, Debug)]
pub struct Roles {
    /// The displacement; none if only a velocity is measured.
    pub place: Option<usize>,
    /// The velocity, where there is no displacement.
    pub speed: Option<usize>,
    /// What acts.
    pub input: Input,
    /// Whether it is an angle.
    pub angle: bool,
    /// Rows that the guess for a drive that can be switched off takes.
    pub flag: Option<Selector>,
    /// All columns of velocities.
    pub speeds: Vec<usize>,
    /// All columns of accelerations.
    pub accelerations: Vec<usize>,
    /// Why the place may be another column.
    pub doubt: Option<Doubt>,
    /// Why the input may be another column, or none.
    pub input_doubt: Option<Doubt>,
}

impl Roles {
    /// The column of the displacement, or else of the velocity.
    pub(crate) fn moving(&self) -> Option<usize> {
        self.place.or(self.speed)
    }

    /// The columns that the model reads.
    pub fn used(&self) -> impl Iterator<Item = usize> {
        self.place.into_iter().chain(self.speed).chain(self.input.column())
    }

    /// Guesses from everything that is known.
    ///
    /// # Errors
    /// There is no motion.
    pub(crate) fn guess(evidence: &Evidence<'_>) -> Result<Roles, NoMotion> {
        Guess { evidence, signals: evidence.signals() }.roles()
    }
}

struct Guess<'a> {
    evidence: &'a Evidence<'a>,
    /// The columns with a signal in them.
    signals: Vec<usize>,
}

impl Guess<'_> {
    fn quantity(&self, k: usize) -> Quantity {
        self.evidence.heading(k).quantity
    }

    fn named(&self, k: usize, words: &[&str]) -> bool {
        self.evidence.heading(k).says(words)
    }

    /// Whether neither the unit says what the column is.
    fn unsaid(&self, k: usize) -> bool {
        matches!(self.quantity(k), Quantity::Unsaid | Quantity::Other)
    }

    /// Those signals that pass a test.
    fn signals(&self, test: impl Fn(usize) -> bool) -> Vec<usize> {
        self.signals.iter().copied().filter(|&k| test(k)).collect()
    }

    fn roles(&self) -> Result<Roles, NoMotion> {
        let raw = |k: usize| self.evidence.name(k).to_owned();
        // Velocities: by unit, by name, or because the numbers say so.
        let mut speeds =
            self.signals(|k| matches!(self.quantity(k), Quantity::Speed | Quantity::AngularSpeed));
        speeds.extend(self.signals(|k| self.unsaid(k) && self.named(k, SPEEDS)));
        let accelerations = self.signals(|k| {
            self.quantity(k) == Quantity::Acceleration || (self.unsaid(k) && self.named(k, ACCELERATIONS))
        });
        let rest = self.signals(|k| !speeds.contains(&k) && !accelerations.contains(&k));
        let (mut places, doubt) = self.places(&rest, !speeds.is_empty());
        // The numbers know a velocity, whatever it is called.
        let derivatives = self.signals(|k| {
            rest.contains(&k)
                && self.unsaid(k)
                && places.iter().any(|&p| p != k && self.evidence.is_derivative(p, k))
        });
        speeds.extend(derivatives);
        places.retain(|p| !speeds.contains(p));
        let (place, base, mut input_doubt) = self.place_and_base(&places);
        let angle = place.or(speeds.first().copied()).is_some_and(|k| self.is_angle(k));
        // A velocity helps only where there is no displacement: programs compute it from that, late and smoothed.
        let speed = place.is_none().then(|| speeds.first().copied()).flatten();
        if place.is_none() && speed.is_none() {
            return Err(accelerations
                .first()
                .map_or(NoMotion::NoSignal, |&k| NoMotion::Acceleration(raw(k))));
        }
        let force = self.force(place, base, &speeds, &accelerations);
        let mut input = match (base, force) {
            (Some(base), _) => Input::Base(base),
            (None, Some(k)) if self.quantity(k) == if angle { Quantity::Torque } else { Quantity::Force } => {
                Input::Force(k)
            }
            (None, Some(k)) => Input::Drive(k),
            (None, None) => Input::None,
        };
        if let (Input::Drive(k), None) = (input, &input_doubt) {
            input_doubt = Some(Doubt::Drive(raw(k)));
        }
        let flag = self.flag();
        // With the motor off its input says nothing.
        if flag.is_some() && !matches!(input, Input::Base(_)) {
            (input, input_doubt) = (Input::None, None);
        }
        Ok(Roles { place, speed, input, angle, flag, speeds, accelerations, doubt, input_doubt })
    }

    /// Displacements, by unit or else by name, out of those columns that are neither velocities nor accelerations.
    fn places(&self, rest: &[usize], any_speed: bool) -> (Vec<usize>, Option<Doubt>) {
        let order = |k: usize| self.named(k, ORDERS);
        let by_unit = |k: usize| matches!(self.quantity(k), Quantity::Length | Quantity::Angle);
        let places: Vec<usize> = rest.iter().copied().filter(|&k| by_unit(k) && !order(k)).collect();
        if !places.is_empty() {
            return (places, None);
        }
        // Names that are good for an output come before others: `u` is an input when there is a `y`.
        let free = |k: usize| !order(k) && !matches!(self.quantity(k), Quantity::Force | Quantity::Torque);
        let candidates: Vec<usize> = rest.iter().copied().filter(|&k| free(k)).collect();
        let best = candidates
            .iter()
            .find(|&&k| self.named(k, OUTPUTS) || self.named(k, PLACES))
            .or_else(|| candidates.iter().find(|&&k| !self.named(k, FORCES)))
            .or_else(|| (!any_speed).then(|| candidates.first()).flatten())
            .copied();
        let Some(best) = best else { return (vec![], None) };
        // A second one without a unit may be the base.
        let twins = candidates.iter().copied().filter(|&k| {
            k != best
                && self.unsaid(k)
                && self.unsaid(best)
                && (self.named(k, BASES) || self.named(k, PLACES))
                && !self.named(k, &["in", "input", "u"])
        });
        let doubt = Doubt::NoUnit(self.evidence.name(best).to_owned());
        ([best].into_iter().chain(twins).collect(), Some(doubt))
    }

    fn is_angle(&self, k: usize) -> bool {
        let names = ["theta", "phi", "angle", "alpha", "winkel", "thetadot", "omega"];
        matches!(self.quantity(k), Quantity::Angle | Quantity::AngularSpeed)
            || (self.unsaid(k) && self.named(k, &names))
    }

    /// The column that knows most of the force.
    fn force(
        &self,
        place: Option<usize>,
        base: Option<usize>,
        speeds: &[usize],
        accelerations: &[usize],
    ) -> Option<usize> {
        let mut forces = self.signals(|k| {
            let by_unit = matches!(self.quantity(k), Quantity::Force | Quantity::Torque | Quantity::Electric);
            let by_name =
                self.unsaid(k) && self.named(k, FORCES) && !self.named(k, ORDERS) && Some(k) != base;
            let other = Some(k) == place || accelerations.contains(&k) || speeds.contains(&k);
            (by_unit || by_name) && !other
        });
        // A force in newtons knows most, then what drives a motor; a supply hardly varies.
        let rank = |k: usize| match self.quantity(k) {
            Quantity::Force | Quantity::Torque => 0,
            _ if self.named(k, &["supply", "battery", "temperature"]) => 3,
            Quantity::Electric => 1,
            _ => 2,
        };
        forces.sort_by_key(|&k| rank(k));
        forces.into_iter().find(|&k| rank(k) < 3)
    }

    /// Which of several displacements is the body's, and which one that of what it hangs on.
    fn place_and_base(&self, places: &[usize]) -> (Option<usize>, Option<usize>, Option<Doubt>) {
        let named = |k: usize| self.named(k, BASES);
        // Twice the same signal is one sensor in two forms, or a command that is followed well.
        let same = |p: usize, k: usize| self.evidence.correlation(p, k).abs() > 0.9999;
        let distinct: Vec<usize> = places
            .iter()
            .enumerate()
            .filter(|(i, k)| !places[..*i].iter().any(|p| same(*p, **k)))
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
        // What shakes is nearer to a sine than what rubs.
        let share = |k: usize| self.evidence.statistics[k].line.map_or(0.0, |l| l.share);
        let (body, other) = if share(body) > share(other) + 0.01 { (other, body) } else { (body, other) };
        (Some(body), Some(other), Some(Doubt::Base(self.evidence.name(other).to_owned())))
    }

    /// A column that says when a drive is off: which rows to take.
    fn flag(&self) -> Option<Selector> {
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
