//! The part of a model that is known: one mass, or two in a chain, on springs and dampers, and what drives
//! it.

use crate::dice::{Dice, rounded};
use std::f64::consts::TAU;

/// A cosine `amplitude * cos(frequency * t + phase)`.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Line {
    pub(super) amplitude: f64,
    /// rad/s.
    pub(super) frequency: f64,
    pub(super) phase: f64,
}

/// What drives a rig.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Drive {
    /// A force on a mass, by explicit time in `known`.
    Explicit(usize),
    /// A force on a mass that was measured: the input F.
    Force(usize),
    /// The wall moves: the input u, and its rate du from a column of its own or derived.
    Base { derived: bool },
    /// Released from its start.
    Free,
}

/// A constant of the spec.
#[derive(Clone, Debug)]
pub(super) struct Constant {
    pub(super) name: String,
    /// What it is in truth.
    pub(super) value: f64,
    pub(super) unit: &'static str,
    /// What the spec says if it is only known within bounds: nominal value and bounds.
    pub(super) movable: Option<(f64, f64, f64)>,
}

/// Something known that is not linear: only where nothing is hidden.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Extra {
    /// `Fk*sgn(v)` on the last mass.
    Coulomb,
    /// `kn*x^3` on the first mass.
    Cubic,
}

/// A rig.
#[derive(Clone, Debug)]
pub(super) struct Rig {
    /// Names of displacements and velocities.
    pub(super) x: Vec<String>,
    pub(super) v: Vec<String>,
    pub(super) mass: Vec<f64>,
    /// Wall to first mass, first to second mass, and (perhaps) second mass to the wall.
    pub(super) spring: Vec<f64>,
    pub(super) damper: Vec<f64>,
    /// Whether the spec has masses and `inertia`; without, the mass is 1 and so are units.
    pub(super) inertia: bool,
    pub(super) drive: Drive,
    pub(super) extra: Option<Extra>,
    /// Constants beside those of the drive.
    pub(super) constants: Vec<Constant>,
    /// Amplitude that the drive aims at, metres.
    pub(super) size: f64,
    /// Lowest natural frequency, rad/s.
    pub(super) natural: f64,
    /// Lines of the first record.
    pub(super) lines: Vec<Line>,
    /// How it is called.
    pub(super) scale: &'static str,
}

impl Rig {
    /// A rig at random. `slow` asks for a drive at which friction can hold a mass.
    pub(super) fn draw(dice: &mut Dice, two: bool, slow: bool) -> Rig {
        let (scale, mass, natural, size) = match dice.whole(0, 9) {
            0..=3 => ("unit", *dice.pick(&[1.0, 1.0, 1.3, 2.0]), dice.log(0.7, 3.0), dice.log(0.3, 2.0)),
            4..=8 => ("laboratory", dice.log(0.5, 8.0), TAU * dice.log(1.5, 15.0), dice.log(3e-4, 5e-3)),
            _ => ("heavy", dice.log(200.0, 3000.0), TAU * dice.log(0.4, 2.0), dice.log(5e-3, 5e-2)),
        };
        let count = if two { 2 } else { 1 };
        let inertia = two || mass != 1.0 || dice.chance(0.5);
        let masses: Vec<f64> =
            (0..count).map(|k| if k == 0 { mass } else { rounded(mass * dice.between(0.5, 1.6)) }).collect();
        let walls = if two && dice.chance(0.3) { 3 } else { count };
        let stiff = rounded(mass * natural * natural);
        let spring: Vec<f64> = (0..walls)
            .map(|k| if k == 0 { stiff } else { rounded(stiff * dice.between(0.5, 1.5)) })
            .collect();
        let damping = dice.log(0.008, 0.07);
        let damper = spring.iter().map(|&k| rounded(2.0 * damping * (k * mass).sqrt())).collect();
        let names = dice.pick(if two { &TWO } else { &ONE });
        let split = |text: &str| text.split(' ').map(str::to_owned).collect::<Vec<String>>();
        let mut rig = Rig {
            x: split(names.0),
            v: split(names.1),
            mass: masses,
            spring,
            damper,
            inertia,
            drive: Drive::Free,
            extra: None,
            constants: vec![],
            size,
            natural,
            lines: vec![],
            scale,
        };
        rig.natural = rig.lowest();
        rig.drive = rig.drawn_drive(dice);
        rig.lines = rig.drawn_lines(dice, slow);
        rig.constants = rig.drawn_constants();
        rig
    }

    /// Number of masses.
    pub(super) fn count(&self) -> usize {
        self.mass.len()
    }

    /// Whether the third spring is there.
    pub(super) fn both_walls(&self) -> bool {
        self.spring.len() > self.count()
    }

    /// The name of the constant of a spring (or damper, or mass) of a chain.
    pub(super) fn named(&self, letter: &str, k: usize) -> String {
        if self.count() == 1 { letter.to_owned() } else { format!("{letter}{}", k + 1) }
    }

    fn lowest(&self) -> f64 {
        let k = &self.spring;
        if self.count() == 1 {
            return (k[0] / self.mass[0]).sqrt();
        }
        let third = k.get(2).copied().unwrap_or(0.0);
        let (a, b) = ((k[0] + k[1]) / self.mass[0], (k[1] + third) / self.mass[1]);
        let coupling = k[1] * k[1] / (self.mass[0] * self.mass[1]);
        (0.5 * (a + b) - (0.25 * (a - b) * (a - b) + coupling).sqrt()).sqrt()
    }

    fn drawn_drive(&self, dice: &mut Dice) -> Drive {
        let on = dice.whole(0, self.count() - 1);
        match dice.whole(0, 19) {
            0..=8 => Drive::Explicit(on),
            9..=12 => Drive::Force(on),
            13..=16 => Drive::Base { derived: dice.chance(0.6) },
            _ => Drive::Free,
        }
    }

    /// One line half of the time, several else. A measured force has many.
    fn drawn_lines(&self, dice: &mut Dice, slow: bool) -> Vec<Line> {
        let several = match self.drive {
            Drive::Free => return vec![],
            Drive::Force(_) => dice.whole(4, 12),
            _ if dice.chance(0.55) => 1,
            _ => dice.whole(2, 5),
        };
        let reach = if slow {
            0.75
        } else if several > 1 {
            1.8
        } else {
            1.5
        };
        let mut lines: Vec<Line> = Vec::new();
        for _ in 0..several {
            let ratio = dice.between(0.3, reach);
            lines.push(Line {
                amplitude: 1.0,
                frequency: rounded(self.natural * ratio),
                phase: rounded(dice.between(0.0, TAU)),
            });
        }
        let share = (several as f64).sqrt();
        for line in &mut lines {
            let ratio = line.frequency / self.natural;
            // Away from the resonance a larger force makes the same motion; at it, the damping would take too
            // long to matter.
            let wanted = self.size * dice.between(0.5, 1.5) / share;
            let force = wanted * self.spring[0] * (1.0 - ratio * ratio).abs().max(0.1);
            line.amplitude = rounded(if matches!(self.drive, Drive::Base { .. }) {
                force / self.spring[0]
            } else {
                force
            });
        }
        if lines.len() == 1 {
            lines[0].phase = 0.0;
        }
        lines
    }

    fn drawn_constants(&self) -> Vec<Constant> {
        let constant = |letter: &str, k: usize, value: f64, unit: &'static str| Constant {
            name: self.named(letter, k),
            value,
            unit: if self.inertia { unit } else { "" },
            movable: None,
        };
        let mut all = Vec::new();
        if self.inertia {
            all.extend(self.mass.iter().enumerate().map(|(k, &m)| constant("m", k, m, "kg")));
        }
        all.extend(self.damper.iter().enumerate().map(|(k, &c)| constant("c", k, c, "N*s/m")));
        all.extend(self.spring.iter().enumerate().map(|(k, &s)| constant("k", k, s, "N/m")));
        all
    }

    /// The rates of the velocities as text, the drive given as text.
    pub(super) fn rates(&self, force: &str, u: &str, du: &str) -> Vec<String> {
        let (x, v) = (&self.x, &self.v);
        let (c, k) = (|i: usize| self.named("c", i), |i: usize| self.named("k", i));
        let base = matches!(self.drive, Drive::Base { .. });
        let minus = |name: &str, wall: &str| if base { format!("({name}-{wall})") } else { name.to_owned() };
        let wall =
            |i: usize, m: usize| format!("-{}*{} - {}*{}", c(i), minus(&v[m], du), k(i), minus(&x[m], u));
        let mut sums = vec![wall(0, 0)];
        if self.count() == 2 {
            let (c, k) = (c(1), k(1));
            sums[0] += &format!(" - {c}*({0}-{1}) - {k}*({2}-{3})", v[0], v[1], x[0], x[1]);
            sums.push(format!("{c}*({0}-{1}) + {k}*({2}-{3})", v[0], v[1], x[0], x[1]));
            if self.both_walls() {
                let more = wall(2, 1);
                sums[1] += &format!(" - {}", &more[1..]);
            }
        }
        if let Drive::Explicit(on) | Drive::Force(on) = self.drive {
            sums[on] += &format!(" + {force}");
        }
        match self.extra {
            Some(Extra::Coulomb) => {
                let last = self.count() - 1;
                sums[last] += &format!(" - Fk*sgn({})", v[last]);
            }
            Some(Extra::Cubic) => sums[0] += &format!(" - kn*{}^3", x[0]),
            None => {}
        }
        let over = |(i, sum): (usize, String)| {
            if self.inertia { format!("({sum})/{}", self.named("m", i)) } else { sum }
        };
        sums.into_iter().enumerate().map(over).collect()
    }

    /// The accelerations of the known part, from displacements and velocities by index and from value and
    /// slope of the drive.
    pub(super) fn acceleration(&self, state: &dyn Fn(usize) -> f64, drive: (f64, f64)) -> Vec<f64> {
        let count = self.count();
        let (x, v) = (|i: usize| state(i), |i: usize| state(count + i));
        let wall = if matches!(self.drive, Drive::Base { .. }) { drive } else { (0.0, 0.0) };
        let pull = |i: usize, stretch: f64, rate: f64| self.spring[i] * stretch + self.damper[i] * rate;
        let mut sums = vec![-pull(0, x(0) - wall.0, v(0) - wall.1)];
        if count == 2 {
            let between = pull(1, x(0) - x(1), v(0) - v(1));
            sums[0] -= between;
            sums.push(between);
            if self.both_walls() {
                sums[1] -= pull(2, x(1) - wall.0, v(1) - wall.1);
            }
        }
        if let Drive::Explicit(on) | Drive::Force(on) = self.drive {
            sums[on] += drive.0;
        }
        sums.iter().zip(&self.mass).map(|(f, m)| f / m).collect()
    }

    /// The drive of a record as numbers in text: force, wall, rate of the wall.
    pub(super) fn driven(lines: &[Line]) -> (String, String) {
        if lines.is_empty() {
            return ("0".to_owned(), "0".to_owned());
        }
        let value = |l: &Line| format!("({:e})*cos(({:e})*t+({:e}))", l.amplitude, l.frequency, l.phase);
        let slope = |l: &Line| {
            format!("({:e})*sin(({:e})*t+({:e}))", -l.amplitude * l.frequency, l.frequency, l.phase)
        };
        let sum = |of: &dyn Fn(&Line) -> String| {
            format!("({})", lines.iter().map(of).collect::<Vec<_>>().join(" + "))
        };
        (sum(&value), sum(&slope))
    }

    /// Value and slope of the drive.
    pub(super) fn drive_at(lines: &[Line], t: f64) -> (f64, f64) {
        lines.iter().fold((0.0, 0.0), |(value, slope), l| {
            let angle = l.frequency * t + l.phase;
            (value + l.amplitude * angle.cos(), slope - l.amplitude * l.frequency * angle.sin())
        })
    }
}

/// Names of states that people use.
const ONE: [(&str, &str); 4] = [("x", "v"), ("x", "v"), ("x", "y"), ("q", "w")];
const TWO: [(&str, &str); 4] =
    [("x1 x2", "v1 v2"), ("x1 x2", "v1 v2"), ("x1 x2", "y1 y2"), ("q1 q2", "w1 w2")];
