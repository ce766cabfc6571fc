//! The motion of a rig by a solver that is not ours: DOP853 of `ode_solvers`, led in short spans, with stops and departures
//! located by halving.
//!
//! ```text
//! rates with sgn(w) --a variable s for each w--> rates(x, s): s = +1 or -1 slides, s within them holds w at rest
//! state --span--> a speed of the wrong sign, or a holding force beyond what can be held? --halved--> its time --decided--> s
//! ```

use super::effect::Effect;
use super::force::Force;
use super::motion::{Equations, Experiment, Motion, equations, read};
use super::place::{Place, places};
use super::rig::{Line, Rig};
use ode_solvers::{DVector, Dop853, OutputType, System};
use std::cell::RefCell;

/// Relative local error.
const TOLERANCE: f64 = 1e-10;
/// Spans between two samples: a speed that is reversed twice within one is not seen.
const SPANS: usize = 4;
/// A wrong sign is seen from this part of the largest speed on.
const WRONG: f64 = 1e-11;
/// Halvings of a span in which something happens.
const HALVINGS: usize = 44;
/// A motion with more events is no realistic case.
const EVENTS: usize = 20_000;
/// The same of one span.
const STEPS: u32 = 200_000;

/// A speed with a sign in the rates.
struct Contact {
    /// Velocities by their index among the states, with factors.
    parts: Vec<(usize, f64)>,
    /// The factor of the wall's speed.
    wall: f64,
}

/// The rates, with signs as variables.
struct Rates {
    of: RefCell<Force>,
    states: usize,
    constants: Vec<f64>,
    contacts: Vec<Contact>,
    lines: Vec<Line>,
}

/// Value, slope and curvature of the drive.
fn drive(lines: &[Line], t: f64) -> (f64, f64, f64) {
    let (value, slope) = Rig::drive_at(lines, t);
    let bend = |l: &Line| -l.amplitude * l.frequency * l.frequency * (l.frequency * t + l.phase).cos();
    (value, slope, lines.iter().map(bend).sum())
}

impl Rates {
    fn new(rig: &Rig, of: &Equations) -> Option<Rates> {
        let all = places(rig);
        let mut found: Vec<&Place> = Vec::new();
        let texts: Vec<String> = of.rates.iter().map(|text| signs(text, &all, &mut found)).collect();
        let texts: Vec<&str> = texts.iter().map(String::as_str).collect();
        let signs: Vec<String> = (0..found.len()).map(|k| format!("SIGN{k}")).collect();
        let constants = rig.constants.iter().map(|c| c.name.as_str());
        let names = of.names.iter().chain(&signs).map(String::as_str);
        let names: Vec<&str> = names.chain(["t", "DRIVE", "u", "du"]).chain(constants).collect();
        let force = Force::several(&texts, &names)?;
        let masses = rig.count();
        let contact = |place: &&Place| Contact {
            parts: place.parts.iter().map(|&(mass, sign)| (masses + mass, sign)).collect(),
            wall: place.wall,
        };
        Some(Rates {
            of: RefCell::new(force),
            states: of.names.len(),
            constants: of.constants.clone(),
            contacts: found.iter().map(contact).collect(),
            lines: of.lines.clone(),
        })
    }

    /// The rates of the states with these signs.
    fn at(&self, t: f64, x: &[f64], signs: &[f64]) -> Vec<f64> {
        let (value, slope) = Rig::drive_at(&self.lines, t);
        let mut of = self.of.borrow_mut();
        let values = x[..self.states].iter().chain(signs).copied().chain([t, value, value, slope]);
        of.at(values.chain(self.constants.iter().copied()));
        (0..self.states).map(|k| of.output(k)).collect()
    }

    /// The speed of a contact.
    fn speed(&self, k: usize, t: f64, x: &[f64]) -> f64 {
        let own: f64 = self.contacts[k].parts.iter().map(|&(v, sign)| sign * x[v]).sum();
        own + self.contacts[k].wall * drive(&self.lines, t).1
    }

    /// Its rate.
    fn acceleration(&self, k: usize, t: f64, rates: &[f64]) -> f64 {
        let own: f64 = self.contacts[k].parts.iter().map(|&(v, sign)| sign * rates[v]).sum();
        own + self.contacts[k].wall * drive(&self.lines, t).2
    }

    /// The signs in these modes: where a contact holds (mode 0), the part of its friction that keeps it at rest.
    fn signs(&self, t: f64, x: &[f64], modes: &[i8]) -> Vec<f64> {
        let mut signs: Vec<f64> = modes.iter().map(|m| f64::from(*m)).collect();
        let held: Vec<usize> = (0..modes.len()).filter(|&k| modes[k] == 0).collect();
        if held.is_empty() {
            return signs;
        }
        // Friction is in proportion to its sign.
        let base = self.at(t, x, &signs);
        let mut system: Vec<Vec<f64>> = held.iter().map(|&k| vec![-self.acceleration(k, t, &base)]).collect();
        for &by in held.iter().rev() {
            let mut one = signs.clone();
            one[by] = 1.0;
            let with = self.at(t, x, &one);
            for (row, &k) in system.iter_mut().zip(&held) {
                row.insert(0, self.acceleration(k, t, &with) - self.acceleration(k, t, &base));
            }
        }
        for (&k, s) in held.iter().zip(solved(system)) {
            signs[k] = s;
        }
        signs
    }

    /// The mode of a contact at rest, the others as they are.
    fn decided(&self, k: usize, t: f64, x: &[f64], modes: &[i8]) -> i8 {
        let with = |mode: i8| {
            let mut modes = modes.to_vec();
            modes[k] = mode;
            self.acceleration(k, t, &self.at(t, x, &self.signs(t, x, &modes)))
        };
        match (with(1), with(-1)) {
            (up, down) if up <= 0.0 && down >= 0.0 => 0,
            (up, _) if up > 0.0 => 1,
            _ => -1,
        }
    }

    /// Sets the speed of a contact to zero, by that of its first mass.
    fn stop(&self, k: usize, t: f64, x: &mut [f64]) {
        let (v, sign) = self.contacts[k].parts[0];
        x[v] -= sign * self.speed(k, t, x);
    }
}

/// The text with a variable in the place of the sign of a place's speed. `found` are these places, in the order of the variables.
fn signs<'p>(text: &str, all: &'p [Place], found: &mut Vec<&'p Place>) -> String {
    let bare = |text: &str| text.trim_matches(['(', ')']).replace(' ', "");
    let Some(at) = text.find("sgn(") else { return text.to_owned() };
    let inside = &text[at + 4..];
    let mut depth = 1;
    let closes = |c: char| {
        depth += i32::from(c == '(') - i32::from(c == ')');
        depth == 0
    };
    let Some(end) = inside.find(closes) else { return text.to_owned() };
    let rest = signs(&inside[end + 1..], all, found);
    let Some(place) = all.iter().find(|p| bare(&p.v) == bare(&inside[..end])) else {
        return format!("{}sgn({}){rest}", &text[..at], &inside[..end]);
    };
    let known = found.iter().position(|p| p.at == place.at);
    let k = known.unwrap_or_else(|| {
        found.push(place);
        found.len() - 1
    });
    format!("{}SIGN{k}{rest}", &text[..at])
}

/// The solution of a few linear equations, each a row with its right side at the end.
fn solved(mut rows: Vec<Vec<f64>>) -> Vec<f64> {
    let n = rows.len();
    for k in 0..n {
        let pivot = (k..n).max_by(|&a, &b| rows[a][k].abs().total_cmp(&rows[b][k].abs())).unwrap_or(k);
        rows.swap(k, pivot);
        for i in (0..n).filter(|&i| i != k) {
            let factor = rows[i][k] / rows[k][k];
            let pivot = rows[k].clone();
            rows[i].iter_mut().zip(&pivot).for_each(|(a, b)| *a -= factor * b);
        }
    }
    (0..n).map(|k| rows[k][n] / rows[k][k]).collect()
}

struct Phase<'a> {
    rates: &'a Rates,
    modes: &'a [i8],
}

impl System<f64, DVector<f64>> for Phase<'_> {
    /// The last state is time.
    fn system(&self, _: f64, z: &DVector<f64>, dz: &mut DVector<f64>) {
        let n = self.rates.states;
        let (t, x) = (z[n], z.as_slice());
        let rates = self.rates.at(t, x, &self.rates.signs(t, x, self.modes));
        dz.as_mut_slice()[..n].copy_from_slice(&rates);
        dz[n] = 1.0;
    }
}

/// A run: time and state, with the modes of its contacts.
struct Run<'a> {
    rates: &'a Rates,
    t: f64,
    x: Vec<f64>,
    modes: Vec<i8>,
    /// Local error that counts as none.
    small: f64,
    /// Largest speed of each contact so far.
    largest: Vec<f64>,
    events: usize,
}

impl Run<'_> {
    /// The state after a span in the present modes.
    fn after(&self, span: f64) -> Result<Vec<f64>, String> {
        let phase = Phase { rates: self.rates, modes: &self.modes };
        let z = DVector::from_iterator(self.x.len() + 1, self.x.iter().copied().chain([self.t]));
        // Defaults but for tolerances and steps. Version 0.6.2 has wrong dense output and wrong times of its stages, as y' = cos t
        // shows: so it makes steps only, and time is a state. Its test of stiffness sees some where there is none.
        let mut solver = Dop853::from_param(
            phase,
            0.0,
            span,
            span,
            z,
            TOLERANCE,
            self.small,
            0.9,
            0.0,
            0.333,
            6.0,
            span,
            0.0,
            STEPS,
            u32::MAX,
            OutputType::Sparse,
        );
        solver.integrate().map_err(|why| format!("DOP853: {why}"))?;
        let mut x: Vec<f64> = solver.y_out().last().map(|z| z.as_slice().to_vec()).unwrap_or_default();
        x.truncate(self.x.len());
        if x.len() < self.x.len() || x.iter().any(|x| !x.is_finite() || x.abs() > 1e12) {
            return Err("it grows without bound".to_owned());
        }
        Ok(x)
    }

    /// The contact that cannot go on as it is, if there is one.
    fn event(&self, t: f64, x: &[f64]) -> Option<usize> {
        let signs = self.rates.signs(t, x, &self.modes);
        (0..self.modes.len()).find(|&k| match self.modes[k] {
            0 => signs[k].abs() > 1.0 + 1e-9,
            mode => f64::from(mode) * self.rates.speed(k, t, x) < -WRONG * self.largest[k],
        })
    }

    /// Goes on to a time.
    fn to(&mut self, end: f64) -> Result<(), String> {
        while self.t < end {
            let (mut span, mut next) = (end - self.t, self.after(end - self.t)?);
            let mut event = self.event(end, &next);
            let mut before = 0.0;
            for _ in 0..HALVINGS {
                if event.is_none() {
                    break;
                }
                let middle = before + 0.5 * (span - before);
                let there = self.after(middle)?;
                match self.event(self.t + middle, &there) {
                    Some(k) => (event, span, next) = (Some(k), middle, there),
                    None => before = middle,
                }
            }
            self.t = if event.is_none() { end } else { self.t + span };
            self.x = next;
            for k in 0..self.modes.len() {
                self.largest[k] = self.largest[k].max(self.rates.speed(k, self.t, &self.x).abs());
            }
            if let Some(k) = event {
                self.pass(k)?;
            }
        }
        Ok(())
    }

    /// A contact stops, reverses or lets go.
    fn pass(&mut self, k: usize) -> Result<(), String> {
        self.events += 1;
        if self.events > EVENTS {
            return Err("it rattles".to_owned());
        }
        self.modes[k] = match self.modes[k] {
            0 => self.rates.signs(self.t, &self.x, &self.modes)[k].signum() as i8,
            _ => {
                self.rates.stop(k, self.t, &mut self.x);
                self.rates.decided(k, self.t, &self.x, &self.modes)
            }
        };
        Ok(())
    }
}

/// Simulates an experiment, as [`super::motion::motion`] does.
///
/// # Errors
/// As text: the motion diverges, or an expression is invalid.
pub(super) fn motion(
    rig: &Rig,
    effects: &[Effect],
    experiment: &Experiment,
    before: f64,
) -> Result<Motion, String> {
    let of = equations(rig, effects, experiment);
    let rates = Rates::new(rig, &of).ok_or("an expression is invalid")?;
    let n = of.names.len();
    let sampled = |times: &[f64]| -> Result<Motion, String> {
        let (t, x) = (-before, of.start.clone());
        let speeds: Vec<f64> = (0..rates.contacts.len()).map(|k| rates.speed(k, t, &x)).collect();
        let mut modes: Vec<i8> =
            speeds.iter().map(|w| if *w == 0.0 { 0 } else { w.signum() as i8 }).collect();
        for k in (0..modes.len()).filter(|&k| speeds[k] == 0.0) {
            modes[k] = rates.decided(k, t, &x, &modes);
        }
        let largest = speeds.iter().map(|w| w.abs().max(1e-3 * rig.size * rig.natural)).collect();
        let mut run = Run { rates: &rates, t, x, modes, small: 1e-12 * rig.size, largest, events: 0 };
        let mut out =
            Motion { n, states: vec![vec![]; n], rates: vec![vec![]; n], stuck: vec![], readings: vec![] };
        for &time in times {
            let from = run.t;
            for k in 1..=SPANS {
                run.to(if k == SPANS { time } else { from + (time - from) * k as f64 / SPANS as f64 })?;
            }
            let at = rates.at(run.t, &run.x, &rates.signs(run.t, &run.x, &run.modes));
            (0..n).for_each(|k| {
                out.states[k].push(run.x[k]);
                out.rates[k].push(at[k]);
            });
            out.stuck.push(run.modes.contains(&0));
        }
        Ok(out)
    };
    let times = &experiment.times;
    let mut out = sampled(times)?;
    let past = |late: f64| Ok(sampled(&times.iter().map(|t| t - late).collect::<Vec<_>>())?.states);
    out.readings = read(out.states[..2 * rig.count()].to_vec(), effects, times, past)?;
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::super::effect::{Scales, draw};
    use super::super::motion;
    use super::*;
    use crate::dice::Dice;

    /// Both solvers, over laws of every kind and rigs of one and two masses. A motion that multiplies errors is left out.
    #[test]
    fn both_solvers_agree_on_stops() {
        let mut stuck = 0;
        for (k, law) in [
            "coulomb",
            "stribeck",
            "asymmetric-coulomb",
            "presliding",
            "lugre",
            "one-sided-stop",
            "power-law-damping",
        ]
        .into_iter()
        .cycle()
        .take(14)
        .enumerate()
        {
            let mut dice = Dice::new(k as u64, law);
            let rig = Rig::draw(&mut dice, k % 2 == 1, true);
            let scales = Scales {
                x: rig.size,
                v: rig.size * rig.natural,
                force: rig.size * rig.spring[0],
                time: 10.0 / rig.natural,
            };
            let all = places(&rig);
            let Some(effect) = draw(law, dice.pick(&all), scales, &rig, &mut dice, true) else { continue };
            let times: Vec<f64> = (0..150).map(|i| 0.1 * f64::from(i) / rig.natural).collect();
            let mut start = vec![0.0; 2 * rig.count()];
            start[0] = rig.size;
            let experiment = Experiment { start, lines: rig.lines.clone(), times, second: false };
            let effects = [effect];
            let ours = motion::motion(&rig, &effects, &experiment, 0.0).expect("ours");
            let other = motion(&rig, &effects, &experiment, 0.0).expect("the other");
            stuck += other.stuck.iter().filter(|s| **s).count();
            for k in 0..rig.count() {
                let off = ours.states[k].iter().zip(&other.states[k]);
                let off = off.fold(0.0_f64, |m, (a, b)| m.max((a - b).abs())) / rig.size;
                assert!(off < 1e-5, "{law}, mass {k}: {off:e}");
            }
        }
        assert!(stuck > 100, "{stuck}");
    }
}
