//! Whether a hidden effect can be distinguished from others at all, without a run of the workflow.
//!
//! The known part is linear, so its response to the missing force over the true motion is what it leaves
//! unexplained. A rival that fits this response with no more free parameters than the truth is the same
//! effect in this record, or the set is too hard to be fair.

use super::effect::{Action, Effect, Property};
use super::force::missing;
use super::linear::Linear;
use super::motion::{ACCELERATION, Experiment, Motion, follow};
use super::place::{Place, places};
use super::rig::Rig;
use std::collections::BTreeSet;

/// Rows of the comparison for each column; each row represents the samples up to the next.
const ROWS: usize = 500;
/// No record shows a smaller chi square.
const SAME: f64 = 1.0;
/// A simpler description is one too, where it leaves a chi square below this for each number that it saves.
const PRICE: f64 = 9.0;

/// Laws and places of a description.
pub(super) type Named = Vec<(String, String)>;

/// The data of a true motion.
pub(super) struct Seen<'a> {
    pub(super) rig: &'a Rig,
    pub(super) effects: &'a [Effect],
    pub(super) experiment: &'a Experiment,
    pub(super) motion: &'a Motion,
    /// The motion of the known part alone.
    pub(super) base: &'a Motion,
    /// Indices of the measured states, their names and noise.
    pub(super) columns: &'a [(usize, String, f64)],
}

/// The result of the comparison.
#[derive(Clone, Debug, Default)]
pub(super) struct Judgement {
    /// The chi square, less the gain by free parameters, between the truth and the nearest rival with no
    /// more of them.
    pub(super) margin: f64,
    /// The chi square of the effect that start states and movable constants cannot absorb.
    pub(super) visible: f64,
    /// That rival.
    pub(super) nearest: String,
    /// Rivals that are the same in this record.
    pub(super) same: Vec<Named>,
    /// The residual of the best rival, rms in units of the noise.
    pub(super) remainder: f64,
    /// The chi square that the best single law leaves.
    pub(super) shown: f64,
    /// The part of the force itself that the best law leaves, if that was asked.
    pub(super) apart: Option<f64>,
}

/// A rival law at a place with fixed inner parameters.
struct Rival {
    law: &'static str,
    at: String,
    friction: bool,
    freedom: usize,
    columns: Vec<usize>,
}

struct Comparison<'a> {
    seen: &'a Seen<'a>,
    linear: Linear,
    /// For each mass, the samples at which its force is the reaction of a sticking contact.
    stuck_masses: Vec<Vec<bool>>,
    every: usize,
    columns: Vec<Vec<f64>>,
    rivals: Vec<Rival>,
    /// Forces themselves are compared, not what they do to the columns.
    bare: bool,
}

/// A description that leaves no more of a force than this part, rms over rms, is that force.
pub(super) const NEAR: f64 = 0.05;

/// The part of the force that the best law leaves of it, rms over rms, where the numbers of each are on the grids of the
/// rivals and its coefficients fitted by least squares; and the laws and pairs that leave less than [`NEAR`]. While a
/// contact holds, its friction is no force of a law.
pub(super) fn near(seen: &Seen<'_>) -> (f64, Vec<Named>) {
    let mut c = Comparison::new(seen, true);
    let (columns, target) = c.columns();
    let (products, loads) = products(&columns, &target);
    let total = dot(&target, &target);
    let left = |of: &[&Rival]| {
        let chosen: Vec<usize> = of.iter().flat_map(|r| r.columns.iter().copied()).collect();
        (1.0 - explained(&products, &loads, &chosen) / total).max(0.0).sqrt()
    };
    let (mut apart, mut all) = (1.0_f64, Vec::<Named>::new());
    let mut add = |of: &[&Rival]| {
        let mut named: Named = of.iter().map(|r| (r.law.to_owned(), r.at.clone())).collect();
        named.sort();
        if !all.contains(&named) {
            all.push(named);
        }
    };
    for (i, a) in c.rivals.iter().enumerate() {
        let one = left(&[a]);
        apart = apart.min(one);
        if one < NEAR {
            add(&[a]);
        }
        c.rivals[..i].iter().filter(|b| left(&[a, b]) < NEAR).for_each(|b| add(&[a, b]));
    }
    (apart, all)
}

/// Compares the truth with all singles and pairs of the catalogue.
pub(super) fn judge(seen: &Seen<'_>) -> Judgement {
    let mut c = Comparison::new(seen, false);
    let (columns, target) = c.columns();
    c.verdict(&columns, &target)
}

/// Samples at which a friction of the truth holds a mass at rest.
fn stuck_masses(seen: &Seen<'_>) -> Vec<Vec<bool>> {
    let samples = seen.experiment.times.len();
    let mut stuck_masses = vec![vec![false; samples]; seen.rig.count()];
    for effect in seen.effects.iter().filter(|e| e.is_friction()) {
        let Action::Force { place, .. } = &effect.action else { continue };
        let (_, v) = place_motion(seen, place);
        let top = largest(&v);
        for i in (0..samples).filter(|&i| seen.motion.stuck[i] && v[i].abs() <= 1e-6 * top) {
            place.parts.iter().for_each(|&(mass, _)| stuck_masses[mass][i] = true);
        }
    }
    stuck_masses
}

/// Displacement and velocity of a place over the true motion.
pub(super) fn place_motion(seen: &Seen<'_>, place: &Place) -> (Vec<f64>, Vec<f64>) {
    let (masses, states) = (seen.rig.count(), &seen.motion.states);
    let sum = |shift: usize, wall: &dyn Fn(f64) -> f64| -> Vec<f64> {
        let one = |(i, &t): (usize, &f64)| {
            place.parts.iter().map(|&(mass, f)| f * states[shift + mass][i]).sum::<f64>()
                + place.wall * wall(t)
        };
        seen.experiment.times.iter().enumerate().map(one).collect()
    };
    let lines = &seen.experiment.lines;
    (sum(0, &|t| Rig::drive_at(lines, t).0), sum(masses, &|t| Rig::drive_at(lines, t).1))
}

pub(super) fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |m, x| m.max(x.abs()))
}

impl<'a> Comparison<'a> {
    fn new(seen: &'a Seen<'a>, bare: bool) -> Self {
        let step = seen.experiment.times[1] - seen.experiment.times[0];
        Comparison {
            seen,
            linear: Linear::new(seen.rig, step),
            stuck_masses: stuck_masses(seen),
            every: if bare { 1 } else { (seen.experiment.times.len() / ROWS).max(1) },
            columns: vec![],
            rivals: vec![],
            bare,
        }
    }

    /// The columns of all rivals, normalised, and what is to be explained, both without what start states and movable
    /// constants absorb.
    fn columns(&mut self) -> (Vec<Vec<f64>>, Vec<f64>) {
        let mut nuisance = self.nuisance();
        let mut target = self.target();
        for place in places(self.seen.rig) {
            self.at(&place);
        }
        if !self.bare {
            self.sensors();
        }
        orthonormal(&mut nuisance);
        nuisance.iter().for_each(|z| remove(&mut target, z));
        let mut columns = std::mem::take(&mut self.columns);
        for column in &mut columns {
            let before = dot(column, column);
            nuisance.iter().for_each(|z| remove(column, z));
            let after = dot(column, column);
            let scale = if after > 1e-12 * before && after > 0.0 { 1.0 / after.sqrt() } else { 0.0 };
            column.iter_mut().for_each(|x| *x *= scale);
        }
        (columns, target)
    }

    /// Samples of the columns as one vector in units of the noise.
    fn rows(&self, states: &dyn Fn(usize) -> Option<Vec<f64>>) -> Vec<f64> {
        let weight = (self.every as f64).sqrt();
        let samples = self.seen.experiment.times.len();
        let mut rows = Vec::new();
        for (state, _, noise) in self.seen.columns {
            match states(*state) {
                Some(values) => rows.extend(values.iter().step_by(self.every).map(|y| y * weight / noise)),
                None => rows.extend(std::iter::repeat_n(0.0, samples.div_ceil(self.every))),
            }
        }
        rows
    }

    fn states(&self, states: &[Vec<f64>]) -> Vec<f64> {
        let n = 2 * self.seen.rig.count();
        self.rows(&|k| Some(states[k.checked_sub(ACCELERATION).map_or(k, |mass| n + mass)].clone()))
    }

    /// The response to a force at a place. A mass that sticks does not respond.
    fn force(&self, parts: &[(usize, f64)], values: &[f64]) -> Vec<f64> {
        let mut sum: Option<Vec<f64>> = None;
        let mut forces = vec![vec![0.0; values.len()]; if self.bare { self.seen.rig.count() } else { 0 }];
        for &(mass, sign) in parts {
            let free: Vec<f64> =
                values.iter().zip(&self.stuck_masses[mass]).map(|(f, h)| if *h { 0.0 } else { *f }).collect();
            if self.bare {
                forces[mass] = free.iter().map(|f| sign * f).collect();
                continue;
            }
            let rows = self.states(&self.linear.response(&[(mass, sign)], &free));
            sum = Some(match sum {
                Some(sum) => sum.iter().zip(&rows).map(|(a, b)| a + b).collect(),
                None => rows,
            });
        }
        sum.unwrap_or_else(|| forces.concat())
    }

    fn nuisance(&self) -> Vec<Vec<f64>> {
        let (seen, rig) = (self.seen, self.seen.rig);
        let samples = seen.experiment.times.len();
        let starts = if self.bare { 0 } else { 2 * rig.count() };
        let mut all: Vec<Vec<f64>> =
            (0..starts).map(|k| self.states(&self.linear.start(k, samples))).collect();
        for place in places(rig) {
            let (x, v) = place_motion(seen, &place);
            for (letter, values) in [("k", &x), ("c", &v)] {
                // A spring and its damper stand at the same place.
                let number = match (place.at.contains(&rig.v[0]), place.parts.len()) {
                    (_, 2) => 1,
                    (true, _) => 0,
                    (false, _) => 2,
                };
                let name = rig.named(letter, number);
                if place.spring.is_some()
                    && rig.constants.iter().any(|c| c.name == name && c.movable.is_some())
                {
                    all.push(self.force(&place.parts, values));
                }
            }
        }
        all
    }

    /// The residual of the known part.
    fn target(&self) -> Vec<f64> {
        let (seen, rig) = (self.seen, self.seen.rig);
        let masses = rig.count();
        let motion = seen.motion;
        let missing = missing(rig, motion, seen.experiment);
        let mut target = if self.bare {
            vec![0.0; masses * seen.experiment.times.len()]
        } else {
            self.rows(&|k| {
                let (read, exact) = (motion.reading(k, masses), motion.quantity(k, masses));
                Some(read.iter().zip(exact).map(|(y, x)| y - x).collect())
            })
        };
        for (mass, values) in missing.iter().enumerate() {
            let rows = self.force(&[(mass, -1.0)], values);
            target.iter_mut().zip(&rows).for_each(|(t, r)| *t += r);
        }
        target
    }

    fn push(
        &mut self,
        law: &'static str,
        place: &Place,
        freedom: usize,
        friction: bool,
        values: Vec<Vec<f64>>,
    ) {
        let first = self.columns.len();
        for values in &values {
            let column = self.force(&place.parts, values);
            self.columns.push(column);
        }
        let columns = (first..self.columns.len()).collect();
        self.rivals.push(Rival { law, at: place.at.clone(), friction, freedom, columns });
    }

    /// All forces of the catalogue at a place.
    fn at(&mut self, place: &Place) {
        let (x, v) = place_motion(self.seen, place);
        let (top, speed) = (largest(&x), largest(&v));
        let of =
            |f: &dyn Fn(f64, f64) -> f64| -> Vec<f64> { x.iter().zip(&v).map(|(&x, &v)| f(x, v)).collect() };
        let sign = |v: f64| {
            if v > 0.0 {
                1.0
            } else if v < 0.0 {
                -1.0
            } else {
                0.0
            }
        };
        type Shape<'s> = (&'static str, &'s dyn Fn(f64, f64) -> f64);
        let simple: [Shape<'_>; 9] = [
            ("cubic-damping", &|_, v| v * v * v),
            ("quintic-stiffness", &|x, _| x.powi(5)),
            ("bilinear-stiffness", &|x, _| x.max(0.0)),
            ("bilinear-stiffness", &|x, _| x.min(0.0)),
            ("viscous", &|_, v| v),
            ("stiffness", &|x, _| x),
            ("quadratic-drag", &|_, v| v * v.abs()),
            ("cubic-stiffness", &|x, _| x * x * x),
            ("quadratic-stiffness", &|x, _| x * x),
        ];
        for (law, f) in simple {
            self.push(law, place, 1, false, vec![of(f)]);
        }
        self.push("van-der-pol", place, 2, false, vec![of(&|_, v| v), of(&|x, v| x * x * v)]);
        self.push("coulomb", place, 1, true, vec![of(&|_, v| sign(v))]);
        self.push("asymmetric-coulomb", place, 2, true, vec![of(&|_, v| sign(v)), of(&|_, _| 1.0)]);
        let varies = vec![of(&|_, v| sign(v)), of(&|x, v| x * sign(v)), of(&|x, v| x * x * sign(v))];
        self.push("position-dependent-friction", place, 3, true, varies);
        let ruina = vec![
            of(&|_, v| sign(v)),
            of(&|_, v| ((v.abs() + 1e-6) / 0.003).ln() * sign(v)),
            of(&|_, v| (0.022 + 0.003 / (v.abs() + 1e-6)).ln() * sign(v)),
        ];
        self.push("dieterich-ruina", place, 3, true, ruina);
        for share in [0.03, 0.06, 0.1, 0.15, 0.25, 0.4, 0.6, 0.9] {
            let vs = share * speed;
            let falls = of(&|_, v| (-(v / vs).powi(2)).exp() * sign(v));
            self.push("stribeck", place, 3, true, vec![of(&|_, v| sign(v)), falls]);
        }
        for share in [0.03, 0.1, 0.2, 0.3, 0.5, 0.8, 1.5] {
            let falls = of(&|_, v| v / (1.0 + v.abs() / (share * speed)));
            self.push("digressive-damping", place, 2, false, vec![falls]);
        }
        self.push("bilinear-damping", place, 2, false, vec![of(&|_, v| v.max(0.0)), of(&|_, v| v.min(0.0))]);
        for p in [0.3, 0.5, 0.7, 1.4, 1.7, 2.4, 2.8, 3.5] {
            self.push("power-law-damping", place, 2, false, vec![of(&|_, v| v.abs().powf(p) * sign(v))]);
        }
        let times = &self.seen.experiment.times;
        let drifts = v.iter().zip(times).map(|(&v, t)| t * sign(v)).collect();
        self.push("drifting-friction", place, 2, true, vec![of(&|_, v| sign(v)), drifts]);
        // The load may be any displacement; that of the place is the nearest.
        let pressed = of(&|x, v| x.abs() * sign(v));
        self.push("load-dependent-friction", place, 2, true, vec![of(&|_, v| sign(v)), pressed]);
        for quarter in 4..40 {
            let n = f64::from(quarter) * 0.25 * std::f64::consts::PI / top;
            self.push("cogging", place, 3, false, vec![of(&|x, _| (n * x).sin()), of(&|x, _| (n * x).cos())]);
        }
        self.with_memory(place, &x, top);
        self.with_clearance(place, &x, top);
        self.of_time(place, &x);
    }

    /// Laws that act from a displacement on: grid of shares of the largest one.
    fn with_clearance(&mut self, place: &Place, x: &[f64], top: f64) {
        let of = |f: &dyn Fn(f64) -> f64| -> Vec<f64> { x.iter().map(|&x| f(x)).collect() };
        for share in [0.01, 0.03, 0.08, 0.2, 0.4] {
            self.push("presliding", place, 2, true, vec![play(x, share * top)]);
        }
        for share in [0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.7] {
            let gap = share * top;
            let inside = of(&|x| -x.clamp(-gap, gap));
            self.push("dead-zone", place, 2, false, vec![inside]);
        }
        for share in [0.2, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95] {
            let gap = share * top;
            self.push("one-sided-stop", place, 2, false, vec![of(&|x| (x - gap).max(0.0))]);
            self.push("one-sided-stop", place, 2, false, vec![of(&|x| (-x - gap).max(0.0))]);
        }
    }

    /// Forces that depend on the time, and a constant one.
    fn of_time(&mut self, place: &Place, x: &[f64]) {
        let times = &self.seen.experiment.times;
        for w in self.frequencies() {
            let (c, s): (Vec<f64>, Vec<f64>) = times.iter().map(|t| ((w * t).cos(), (w * t).sin())).unzip();
            let swings = [&c, &s].map(|g| g.iter().zip(x).map(|(g, x)| g * x).collect::<Vec<f64>>());
            if place.wall == 0.0 {
                self.push("harmonic-force", place, 3, false, vec![c, s]);
            }
            self.push("parametric-stiffness", place, 3, false, swings.into());
        }
        if place.wall == 0.0 {
            self.push("offset", place, 1, false, vec![vec![1.0; x.len()]]);
        }
    }

    /// The laws with memory at a place, along its displacement `x` of size `top`. Their own numbers are on
    /// grids.
    fn with_memory(&mut self, place: &Place, x: &[f64], top: f64) {
        let times = &self.seen.experiment.times;
        for period in [0.1, 0.3, 1.0, 3.0, 10.0] {
            let memory = period / self.seen.rig.natural;
            self.push("maxwell", place, 2, false, vec![relaxed(x, times, memory)]);
        }
        for share in [0.05, 0.1, 0.15, 0.2, 0.3, 0.4] {
            let within = stopped(x, share * top);
            let behind = x.iter().zip(&within).map(|(x, z)| x - z).collect();
            self.push("backlash", place, 2, false, vec![behind]);
        }
        for share in [0.1, 0.15, 0.2, 0.3, 0.4] {
            for spread in [0.4, 0.6, 0.8] {
                let ends = [-1.0, -1.0 / 3.0, 1.0 / 3.0, 1.0].map(|u| share * top * (1.0 + spread * u));
                let all: Vec<Vec<f64>> = ends.iter().map(|end| stopped(x, *end)).collect();
                let sum = (0..x.len()).map(|i| all.iter().map(|z| z[i]).sum()).collect();
                self.push("maxwell-slip", place, 3, true, vec![sum]);
            }
        }
        for share in [0.08, 0.15, 0.25, 0.4] {
            for part in [-0.6, -0.4, 0.4, 0.6] {
                self.push("bouc-wen", place, 3, true, vec![yielding(x, share * top, part)]);
            }
        }
    }

    /// Frequencies of the drive, their multiples, and those of the truth.
    fn frequencies(&self) -> Vec<f64> {
        let lines = &self.seen.experiment.lines;
        let mut all: Vec<f64> = lines.iter().take(2).map(|l| l.frequency).collect();
        if let Some(first) = lines.first() {
            all.extend([2.0 * first.frequency, 3.0 * first.frequency]);
        }
        if lines.is_empty() {
            all.push(self.seen.rig.natural);
        }
        all.extend(self.seen.effects.iter().filter_map(|e| e.parameter("w")));
        all
    }

    fn sensors(&mut self) {
        // A gain multiplies the motion of the model, including the effect of the hidden force. The true
        // motion would explain itself by an unbounded gain, so the motion of the known part takes its
        // place.
        let (motion, base) = (self.seen.motion, self.seen.base);
        let names: Vec<(usize, String)> = self.seen.columns.iter().map(|(k, n, _)| (*k, n.clone())).collect();
        let mut all: Vec<(&'static str, String, Vec<f64>)> = Vec::new();
        let (masses, times) = (self.seen.rig.count(), &self.seen.experiment.times);
        let slope = |k: usize| -> Vec<f64> {
            if k < ACCELERATION {
                return motion.rates[k].iter().map(|r| -r).collect();
            }
            let a = motion.quantity(k, masses);
            let last = a.len() - 1;
            let ends = |i: usize| (i.saturating_sub(1), (i + 1).min(last));
            (0..=last).map(ends).map(|(i, j)| -(a[j] - a[i]) / (times[j] - times[i])).collect()
        };
        for (own, name) in &names {
            let one = |f: &dyn Fn(usize) -> Vec<f64>| self.rows(&|k| (k == *own).then(|| f(k)));
            all.push(("sensor-delay", name.clone(), one(&slope)));
            all.push(("sensor-gain", name.clone(), one(&|k| base.quantity(k, masses).clone())));
            all.push(("sensor-offset", name.clone(), one(&|k| vec![1.0; motion.quantity(k, masses).len()])));
        }
        all.push(("sensor-delay", "motion".to_owned(), self.rows(&|k| Some(slope(k)))));
        // What is late by a delay may be late by a lag.
        let late = self.seen.effects.iter().filter_map(|e| match e.action {
            Action::Sensor { property: Property::Delay | Property::Lag, value, .. } => Some(value),
            Action::Input { delay, .. } => Some(delay).filter(|delay| *delay > 0.0),
            _ => None,
        });
        for lag in late {
            let behind = |k: usize| -> Vec<f64> {
                let now = motion.quantity(k, masses);
                let mut shown = now.clone();
                follow(&mut shown, times, lag);
                shown.iter().zip(now).map(|(shown, now)| shown - now).collect()
            };
            for (own, name) in &names {
                all.push(("sensor-lag", name.clone(), self.rows(&|k| (k == *own).then(|| behind(k)))));
            }
            all.push(("sensor-lag", "motion".to_owned(), self.rows(&|k| Some(behind(k)))));
        }
        all.push((
            "sensor-gain",
            "motion".to_owned(),
            self.rows(&|k| Some(base.quantity(k, masses).clone())),
        ));
        for (law, at, column) in all {
            self.rivals.push(Rival {
                law,
                at,
                friction: false,
                freedom: 1,
                columns: vec![self.columns.len()],
            });
            self.columns.push(column);
        }
    }

    fn verdict(&self, columns: &[Vec<f64>], target: &[f64]) -> Judgement {
        let (products, loads) = products(columns, target);
        let total = dot(target, target);
        let truth: BTreeSet<(String, String)> =
            self.seen.effects.iter().map(|e| (e.law.clone(), e.at.clone())).collect();
        let effects = self.seen.effects;
        let freedom = effects.iter().map(Effect::freedom).sum::<usize>() + effects.len() - 1;
        let asymmetric = effects.iter().any(|e| e.law == "asymmetric-coulomb");
        let sticking: BTreeSet<String> = if self.stuck_masses.iter().flatten().any(|h| *h) {
            effects.iter().filter(|e| e.is_friction()).map(|e| e.at.clone()).collect()
        } else {
            BTreeSet::new()
        };
        let mut judgement = Judgement {
            margin: f64::INFINITY,
            remainder: f64::INFINITY,
            shown: total,
            visible: total,
            ..Judgement::default()
        };
        let mut try_one = |members: &[&Rival]| {
            let holds = |at: &String| members.iter().any(|r| r.friction && r.at == *at);
            if !sticking.iter().all(holds) {
                return;
            }
            let named: BTreeSet<(String, String)> =
                members.iter().map(|r| (r.law.to_owned(), r.at.clone())).collect();
            if named == truth {
                return;
            }
            let chosen: Vec<usize> = members.iter().flat_map(|r| r.columns.iter().copied()).collect();
            let left = (total - explained(&products, &loads, &chosen)).max(0.0);
            if members.len() == 1 {
                judgement.shown = judgement.shown.min(left);
            }
            let own = members.iter().map(|r| r.freedom).sum::<usize>() + members.len() - 1;
            judgement.remainder = judgement
                .remainder
                .min((left / (columns.first().map_or(1, Vec::len) * self.every) as f64).sqrt());
            let list: Named = named.into_iter().collect();
            // Coulomb friction and offset are one law or two: neither description is simpler.
            let as_simple = own == freedom
                || (asymmetric && own == freedom + 1)
                || (own < freedom && list.iter().any(|(law, _)| law == "asymmetric-coulomb"));
            let margin = left - PRICE * freedom.saturating_sub(own) as f64;
            let same = left < SAME && as_simple;
            if (same || (own < freedom && margin < 0.0)) && !judgement.same.contains(&list) {
                judgement.same.push(list.clone());
            }
            if !same && own <= freedom && margin < judgement.margin {
                judgement.margin = margin;
                let words: Vec<String> = list.iter().map(|(law, at)| format!("{law} at {at}")).collect();
                judgement.nearest = words.join(" + ");
            }
        };
        for (i, a) in self.rivals.iter().enumerate() {
            try_one(&[a]);
            for b in &self.rivals[..i] {
                // Two frictions at one place are one friction.
                if a.at != b.at || (a.law != b.law && !(a.friction && b.friction)) {
                    try_one(&[a, b]);
                }
            }
        }
        judgement
    }
}

/// The deflection of an elastic contact that yields over the distance `d`, for a displacement.
fn play(x: &[f64], d: f64) -> Vec<f64> {
    let mut z = 0.0;
    let mut out = vec![0.0];
    for pair in x.windows(2) {
        let step = pair[1] - pair[0];
        let end = d * step.signum();
        z = end + (z - end) * (-step.abs() / d).exp();
        out.push(z);
    }
    out
}

/// The deflection of an ideal element that slides beyond the deflection `end`.
fn stopped(x: &[f64], end: f64) -> Vec<f64> {
    let mut out = vec![0.0];
    for pair in x.windows(2) {
        out.push((out[out.len() - 1] + pair[1] - pair[0]).clamp(-end, end));
    }
    out
}

/// The deflection of a spring behind which a dashpot gives way within a time.
fn relaxed(x: &[f64], times: &[f64], memory: f64) -> Vec<f64> {
    let mut out = vec![0.0];
    for (pair, t) in x.windows(2).zip(times.windows(2)) {
        let stay = (-(t[1] - t[0]) / memory).exp();
        out.push(stay * (out[out.len() - 1] + pair[1] - pair[0]));
    }
    out
}

/// The force of Bouc and Wen over its stiffness, that yields over `d`, with gamma this part of beta.
fn yielding(x: &[f64], d: f64, part: f64) -> Vec<f64> {
    let mut z = 0.0;
    let mut out = vec![0.0];
    for pair in x.windows(2) {
        let step = pair[1] - pair[0];
        let rises = if step * z > 0.0 { 1.0 + part } else { 1.0 - part };
        z += step - step.abs() * z * rises / (d * (1.0 + part));
        out.push(z);
    }
    out
}

/// The products of columns with each other, below the diagonal, and with a target.
fn products(columns: &[Vec<f64>], target: &[f64]) -> (Vec<Vec<f64>>, Vec<f64>) {
    let row = |(i, a): (usize, &Vec<f64>)| columns[..=i].iter().map(|b| dot(a, b)).collect();
    (columns.iter().enumerate().map(row).collect(), columns.iter().map(|a| dot(a, target)).collect())
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn remove(from: &mut [f64], direction: &[f64]) {
    let share = dot(from, direction);
    from.iter_mut().zip(direction).for_each(|(x, d)| *x -= share * d);
}

/// Gram-Schmidt orthonormalisation; a dependent column becomes zero.
fn orthonormal(columns: &mut [Vec<f64>]) {
    for k in 0..columns.len() {
        let (done, rest) = columns.split_at_mut(k);
        let before = dot(&rest[0], &rest[0]);
        // Twice is enough.
        for _ in 0..2 {
            done.iter().for_each(|d| remove(&mut rest[0], d));
        }
        let after = dot(&rest[0], &rest[0]);
        let scale = if after > 1e-14 * before && after > 0.0 { 1.0 / after.sqrt() } else { 0.0 };
        rest[0].iter_mut().for_each(|x| *x *= scale);
    }
}

/// The part of the target's square that some columns explain, from products of normalised columns.
/// Dependent columns are left out.
fn explained(products: &[Vec<f64>], loads: &[f64], chosen: &[usize]) -> f64 {
    let n = chosen.len();
    let mut factor = vec![0.0; n * n];
    let mut sum = 0.0;
    let mut solved = vec![0.0; n];
    for i in 0..n {
        let mut load = loads[chosen[i]];
        for j in 0..=i {
            let (high, low) = (chosen[i].max(chosen[j]), chosen[i].min(chosen[j]));
            let mut entry = products[high][low];
            entry -= (0..j).map(|k| factor[i * n + k] * factor[j * n + k]).sum::<f64>();
            if j < i {
                factor[i * n + j] = if factor[j * n + j] > 0.0 { entry / factor[j * n + j] } else { 0.0 };
                load -= factor[i * n + j] * solved[j];
            } else if entry > 1e-9 {
                factor[i * n + i] = entry.sqrt();
                solved[i] = load / factor[i * n + i];
                sum += solved[i] * solved[i];
            }
        }
    }
    sum
}

/// Whether a property of one column is one of all columns.
pub(super) fn only_column(effect: &Effect, columns: usize) -> bool {
    matches!(effect.action, Action::Sensor { property, .. } if property != Property::Offset) && columns == 1
}
