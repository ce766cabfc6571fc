//! What each column is for: a guess from its name, its unit and its numbers.

use crate::csv::Survey;
use crate::headings::{Heading, Kind, SPEEDS, factor};
use crate::statistics::Look;
use crate::time_column::{Clock, is_counter};
use phisindy_signal::{automatic, standard_deviation};
use std::ops::Range;

const PLACES: &[&str] = &[
    "x",
    "y",
    "z",
    "q",
    "s",
    "pos",
    "position",
    "disp",
    "displacement",
    "weg",
    "laser",
    "lvdt",
    "encoder",
    "theta",
    "phi",
    "angle",
    "alpha",
    "winkel",
    "mass",
    "deflection",
    "stroke",
    "out",
    "output",
    "response",
    "travel",
    "auslenkung",
];
const OUTPUTS: &[&str] = &["y", "out", "output", "response", "sensor", "measured"];
const BASES: &[&str] = &[
    "u",
    "xb",
    "xg",
    "ub",
    "ug",
    "base",
    "ground",
    "table",
    "shaker",
    "floor",
    "support",
    "foundation",
    "exc",
    "excitation",
    "input",
    "boden",
    "fuss",
    "wall",
    "sockel",
];
/// Words for what is no measurement: another form of a column that is there too.
const COPIES: &[&str] = &[
    "true",
    "truth",
    "exact",
    "ideal",
    "model",
    "sim",
    "simulated",
    "pred",
    "predicted",
    "prediction",
    "fit",
    "fitted",
    "est",
    "estimate",
    "estimated",
    "filt",
    "filtered",
    "smooth",
    "smoothed",
];
const ORDERS: &[&str] =
    &["ref", "reference", "goal", "target", "set", "setpoint", "desired", "cmd", "command", "soll", "demand"];
const ACCELERATIONS: &[&str] = &["a", "acc", "accel", "acceleration", "ddx", "xddot", "beschleunigung"];
const FORCES: &[&str] = &[
    "f",
    "force",
    "kraft",
    "torque",
    "moment",
    "tau",
    "thrust",
    "u",
    "in",
    "input",
    "drive",
    "exc",
    "excitation",
    "motor",
    "voltage",
    "current",
    "load",
    "vir",
];

/// What acts on the body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Input {
    /// Nothing that is measured.
    None,
    /// The motion of what it hangs on.
    Base(usize),
    /// A force or torque in its own unit.
    Force(usize),
    /// Something proportional to a force: a voltage, a number without unit.
    Drive(usize),
}

/// A column that selects rows.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Selector {
    /// Which column.
    pub(crate) column: usize,
    /// The value to take.
    pub(crate) value: f64,
}

/// The parts that the columns play.
#[derive(Clone, Debug)]
pub(crate) struct Roles {
    /// The displacement; none if only a velocity is measured.
    pub(crate) place: Option<usize>,
    /// The velocity, if it has a column that is good for something.
    pub(crate) speed: Option<usize>,
    /// What acts.
    pub(crate) input: Input,
    /// Whether it is an angle.
    pub(crate) angle: bool,
    /// Rows that the guess for a drive that can be switched off takes.
    pub(crate) flag: Option<Selector>,
    /// For each column what was made of it, in words.
    pub(crate) words: Vec<String>,
    /// Why the place may be another column.
    pub(crate) doubt: Option<String>,
    /// Why the input may be another column, or none.
    pub(crate) input_doubt: Option<String>,
}

impl Roles {
    /// The columns that the model reads.
    pub(crate) fn used(&self) -> impl Iterator<Item = usize> {
        let input = match self.input {
            Input::None => None,
            Input::Base(k) | Input::Force(k) | Input::Drive(k) => Some(k),
        };
        self.place.into_iter().chain(self.speed).chain(input)
    }

    /// Guesses from everything that is known; why there is no motion.
    pub(crate) fn guess(
        survey: &Survey,
        clock: &Clock,
        looks: &[Look],
        run: &Range<usize>,
    ) -> Result<Roles, String> {
        let guess = Guess { survey, clock, looks, run };
        guess.roles()
    }
}

struct Guess<'a> {
    survey: &'a Survey,
    clock: &'a Clock,
    looks: &'a [Look],
    run: &'a Range<usize>,
}

impl Guess<'_> {
    fn heading(&self, k: usize) -> &Heading {
        &self.survey.columns[k].heading
    }

    fn name(&self, k: usize) -> &str {
        &self.heading(k).raw
    }

    /// Whether a column without a unit holds nothing but noise.
    fn is_noise(&self, k: usize) -> bool {
        let look = &self.looks[k];
        self.heading(k).kind == Kind::Unsaid && look.noise > 0.8 * look.std
    }

    /// Whether a column before this one has its heading: no spec can tell the two apart.
    fn is_namesake(&self, k: usize) -> bool {
        (0..k).any(|j| self.name(j) == self.name(k))
    }

    /// The column of which this one is another form, `x` of `x_true`.
    fn original(&self, k: usize) -> Option<usize> {
        let own = self.heading(k);
        let plain = |h: &Heading| -> Vec<String> {
            h.words().filter(|w| !COPIES.contains(w)).map(str::to_owned).collect()
        };
        let same = |&j: &usize| {
            let other = self.heading(j);
            j != k && !other.says(COPIES) && other.kind == own.kind && plain(other) == plain(own)
        };
        (0..self.survey.columns.len()).find(same).filter(|_| own.says(COPIES))
    }

    /// Columns with a signal in them.
    fn signals(&self) -> Vec<usize> {
        let usable = |&k: &usize| {
            let (column, look) = (&self.survey.columns[k], &self.looks[k]);
            let selector = look.values.is_some() && matches!(column.heading.kind, Kind::Unsaid | Kind::Other);
            k != self.clock.column
                && !is_counter(column)
                && !self.is_noise(k)
                && self.original(k).is_none()
                && !self.is_namesake(k)
                && column.words == 0
                && !look.is_dead()
                && !selector
                && look.missing * 2 < self.survey.rows()
        };
        (0..self.survey.columns.len()).filter(usable).collect()
    }

    fn roles(&self) -> Result<Roles, String> {
        let signals = self.signals();
        let kind = |k: usize| self.heading(k).kind;
        let order = |k: usize| self.heading(k).says(ORDERS);
        let named = |k: usize, words: &[&str]| self.heading(k).says(words);
        let unsaid = |k: usize| matches!(kind(k), Kind::Unsaid | Kind::Other);
        // Velocities: by unit, by name, or because the numbers say so.
        let mut speeds: Vec<usize> = signals
            .iter()
            .copied()
            .filter(|&k| matches!(kind(k), Kind::Speed | Kind::AngularSpeed))
            .collect();
        speeds.extend(signals.iter().copied().filter(|&k| unsaid(k) && named(k, SPEEDS)));
        let accelerations: Vec<usize> = signals
            .iter()
            .copied()
            .filter(|&k| kind(k) == Kind::Acceleration || (unsaid(k) && named(k, ACCELERATIONS)))
            .collect();
        let rest = |k: &usize| !speeds.contains(k) && !accelerations.contains(k);
        let by_unit = |k: &usize| matches!(kind(*k), Kind::Length | Kind::Angle);
        let mut places: Vec<usize> =
            signals.iter().copied().filter(|k| rest(k) && by_unit(k) && !order(*k)).collect();
        let mut doubt = None;
        if places.is_empty() {
            // Names that are good for an output come before others: `u` is an input when there is a `y`.
            let free = |k: &usize| rest(k) && !order(*k) && !matches!(kind(*k), Kind::Force | Kind::Torque);
            let candidates: Vec<usize> = signals.iter().copied().filter(free).collect();
            let best = candidates
                .iter()
                .find(|&&k| named(k, OUTPUTS) || named(k, PLACES))
                .or_else(|| candidates.iter().find(|&&k| !named(k, FORCES)))
                .or_else(|| (speeds.is_empty()).then(|| candidates.first()).flatten())
                .copied();
            places.extend(best);
            doubt = best.map(|k| {
                format!(
                    "taken for the displacement: the heading `{}` has no unit of length or angle",
                    self.name(k)
                )
            });
            // A second one without a unit may be the base.
            if let Some(best) = best {
                let twins = candidates.iter().copied().filter(|&k| {
                    k != best
                        && unsaid(k)
                        && unsaid(best)
                        && (named(k, BASES) || named(k, PLACES))
                        && !named(k, &["in", "input", "u"])
                });
                places.extend(twins);
            }
        }
        // The numbers know a velocity, whatever it is called.
        let found: Vec<usize> = signals
            .iter()
            .copied()
            .filter(|&k| rest(&k) && unsaid(k) && places.iter().any(|&p| p != k && self.is_derivative(p, k)))
            .collect();
        speeds.extend(found);
        places.retain(|p| !speeds.contains(p));
        let (place, base, mut input_doubt) = self.place_and_base(&places);
        let angle = place.or(speeds.first().copied()).is_some_and(|k| {
            matches!(kind(k), Kind::Angle | Kind::AngularSpeed)
                || (unsaid(k) && named(k, &["theta", "phi", "angle", "alpha", "winkel", "thetadot", "omega"]))
        });
        // A velocity helps only where there is no displacement: programs compute it from that, late and smoothed.
        let measured = place.is_none().then(|| speeds.first().copied()).flatten();
        if place.is_none() && measured.is_none() {
            return Err(if accelerations.is_empty() {
                "no column of motion is left: none varies and holds numbers only".to_owned()
            } else {
                format!(
                    "`{}` is an acceleration, and no displacement or velocity is measured",
                    self.name(accelerations[0])
                )
            });
        }
        let mut forces: Vec<usize> =
            signals.iter().copied().filter(|&k| Some(k) != place && !accelerations.contains(&k)).collect();
        forces.retain(|&k| {
            matches!(kind(k), Kind::Force | Kind::Torque | Kind::Electric)
                || (unsaid(k) && named(k, FORCES) && !order(k) && Some(k) != base)
        });
        forces.retain(|k| !speeds.contains(k));
        // A force in newtons knows most, then what drives a motor; a supply hardly varies.
        let rank = |k: usize| match kind(k) {
            Kind::Force | Kind::Torque => 0,
            _ if named(k, &["supply", "battery", "temperature"]) => 3,
            Kind::Electric => 1,
            _ => 2,
        };
        forces.sort_by_key(|&k| rank(k));
        forces.retain(|&k| rank(k) < 3);
        let input = match (base, forces.first()) {
            (Some(base), _) => Input::Base(base),
            (None, Some(&k)) if kind(k) == if angle { Kind::Torque } else { Kind::Force } => Input::Force(k),
            (None, Some(&k)) => Input::Drive(k),
            (None, None) => Input::None,
        };
        if let (Input::Drive(k), None) = (input, &input_doubt) {
            input_doubt = Some(format!(
                "`{}` is taken for what drives the motion, in proportion to a force",
                self.name(k)
            ));
        }
        let mut roles = Roles {
            place,
            speed: measured,
            input,
            angle,
            flag: self.flag(),
            words: vec![],
            doubt,
            input_doubt,
        };
        // With the motor off its input says nothing.
        if roles.flag.is_some() && !matches!(input, Input::Base(_)) {
            (roles.input, roles.input_doubt) = (Input::None, None);
        }
        roles.words =
            (0..self.survey.columns.len()).map(|k| self.words(k, &roles, &speeds, &accelerations)).collect();
        Ok(roles)
    }

    /// Which of several displacements is the body's, and which one that of what it hangs on.
    fn place_and_base(&self, places: &[usize]) -> (Option<usize>, Option<usize>, Option<String>) {
        let named = |k: usize| self.heading(k).says(BASES);
        // Twice the same signal is one sensor in two forms, or a command that is followed well.
        let distinct: Vec<usize> = places
            .iter()
            .enumerate()
            .filter(|(i, k)| !places[..*i].iter().any(|p| self.correlation(*p, **k).abs() > 0.9999))
            .map(|(_, k)| *k)
            .collect();
        let body = distinct.iter().copied().find(|k| !named(*k)).or(distinct.first().copied());
        let others = || distinct.iter().copied().filter(|k| Some(*k) != body);
        let Some(body) = body else { return (None, None, None) };
        if let Some(base) = others().find(|k| named(*k)) {
            return (Some(body), Some(base), None);
        }
        let same = |k: &usize| self.heading(*k).kind == self.heading(body).kind;
        let Some(other) = others().find(same) else { return (Some(body), None, None) };
        // What shakes is nearer to a sine than what rubs.
        let share = |k: usize| self.looks[k].line.map_or(0.0, |l| l.share);
        let (body, other) = if share(body) > share(other) + 0.01 { (other, body) } else { (body, other) };
        let why = format!(
            "two displacements and no word which one moves the other: `{}` is taken for the base (exchange the two headings if it is not)",
            self.name(other)
        );
        (Some(body), Some(other), Some(why))
    }

    /// A column that says when a drive is off: which rows to take.
    fn flag(&self) -> Option<Selector> {
        let on: &[&str] = &["enabled", "enable", "on", "active", "power", "engaged"];
        let good: &[&str] = &["valid", "ok", "good"];
        let mut found = (0..self.survey.columns.len()).filter_map(|column| {
            let both = self.looks[column].values.as_deref() == Some(&[0.0, 1.0]);
            let heading = self.heading(column);
            let value = if heading.says(on) {
                0.0
            } else if heading.says(good) {
                1.0
            } else {
                return None;
            };
            let rows = self.survey.columns[column].values.iter().filter(|x| **x == value).count();
            (both && rows * 20 > self.survey.rows()).then_some(Selector { column, value })
        });
        found.next()
    }

    /// At most twenty thousand rows of the run, for comparisons.
    fn piece(&self, k: usize) -> Vec<f64> {
        let run = self.run.start..self.run.end.min(self.run.start + 20_000);
        self.survey.columns[k].values[run].to_vec()
    }

    fn correlation(&self, a: usize, b: usize) -> f64 {
        correlation(&self.piece(a), &self.piece(b))
    }

    /// Whether `b` is the derivative of `a`: alike, and of the right size.
    fn is_derivative(&self, a: usize, b: usize) -> bool {
        let (time, x) = (self.piece(self.clock.column), self.piece(a));
        let Ok(slope) = automatic(&time, &x) else { return false };
        let y = self.piece(b);
        let ratio = standard_deviation(&y)
            / (standard_deviation(&slope.derivative)
                / factor(self.heading(self.clock.column).unit.as_deref()));
        correlation(&slope.derivative, &y) > 0.9
            && [1e-3, 1.0, 1e3, std::f64::consts::PI / 180.0, 180.0 / std::f64::consts::PI]
                .iter()
                .any(|f| (ratio / f - 1.0).abs() < 0.25)
    }

    /// A few words on a column for the head of the spec.
    fn words(&self, k: usize, roles: &Roles, speeds: &[usize], accelerations: &[usize]) -> String {
        let (column, look) = (&self.survey.columns[k], &self.looks[k]);
        let twin = || {
            let same = |&p: &usize| {
                p != k
                    && self.looks[p].values.is_none()
                    && !look.is_dead()
                    && self.correlation(p, k).abs() > 0.9999
            };
            roles.used().find(same).map(|p| format!(", which is proportional to `{}`", self.name(p)))
        };
        if k == self.clock.column {
            return "time".to_owned();
        }
        if column.words * 2 > self.survey.rows() {
            return "words, not used".to_owned();
        }
        if column.words > 0 {
            return "not used: words stand among the numbers".to_owned();
        }
        if Some(k) == roles.place {
            return if roles.angle { "the angle, state theta" } else { "the displacement, state x" }
                .to_owned();
        }
        if Some(k) == roles.speed {
            return "the velocity".to_owned();
        }
        match roles.input {
            Input::Base(b) if b == k => return "the motion of the base, input u".to_owned(),
            Input::Force(b) if b == k => return "the force, input F".to_owned(),
            Input::Drive(b) if b == k => return "the drive, input F".to_owned(),
            _ => {}
        }
        if look.missing == self.survey.rows() {
            return "empty".to_owned();
        }
        if look.missing * 2 >= self.survey.rows() {
            return "not used: more than half of it is missing".to_owned();
        }
        if look.is_dead() {
            return "constant, not used".to_owned();
        }
        if is_counter(column) {
            return "counts rows or tells the time, not used".to_owned();
        }
        if self.is_namesake(k) {
            return "not used: another column has its heading".to_owned();
        }
        if let Some(original) = self.original(k) {
            return format!("not used: another form of `{}`", self.name(original));
        }
        if self.is_noise(k) {
            return "nothing but noise, not used".to_owned();
        }
        if roles.flag.as_ref().is_some_and(|f| f.column == k) {
            return "selects rows".to_owned();
        }
        if speeds.contains(&k) {
            return "a velocity, not used: it follows from the displacement".to_owned();
        }
        if accelerations.contains(&k) {
            return "an acceleration, not used".to_owned();
        }
        if look.values.is_some() {
            return "a few whole numbers: can select rows".to_owned();
        }
        let what = if self.heading(k).says(ORDERS) { "a command, not used" } else { "not used" };
        what.to_owned() + &twin().unwrap_or_default()
    }
}

/// Of Pearson, over the rows where both have numbers.
fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let pairs: Vec<(f64, f64)> =
        a.iter().copied().zip(b.iter().copied()).filter(|(a, b)| a.is_finite() && b.is_finite()).collect();
    let n = pairs.len().max(1) as f64;
    let (ma, mb) = pairs.iter().fold((0.0, 0.0), |(s, t), (a, b)| (s + a / n, t + b / n));
    let (aa, bb, ab) = pairs.iter().fold((0.0, 0.0, 0.0), |(aa, bb, ab), (a, b)| {
        (aa + (a - ma).powi(2), bb + (b - mb).powi(2), ab + (a - ma) * (b - mb))
    });
    if aa > 0.0 && bb > 0.0 { ab / (aa * bb).sqrt() } else { 0.0 }
}
