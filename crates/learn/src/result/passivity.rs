//! Whether passive laws feed the motion. Dry friction and dashpots take energy out; one that was fitted so
//! that it puts energy in stands for something else, however well the model follows the data.
//!
//! The rates are linear in the sign `s` of each sliding velocity `w`: `r = a + s b`. The power of the dry
//! friction at `w` is `s b w = b |w|` with `b = dw/dx . b`, per unit of inertia: negative where it
//! dissipates. Its level is asked for in the mean along the motion and near rest: `b` of `s (1 - |w|)` is
//! both dry friction and, written with a sign, a damper, and near rest, where `w = 0`, only the friction is
//! left of it. With the rates of both directions averaged, `da/dv` is the linear damping of the velocity `v`
//! wherever it depends on no motion; then nothing bounds a motion that it feeds. (Damping that depends on the
//! motion, as that of van der Pol's oscillator, may feed it: that is what the model says.)

use super::contribution::is_velocity;
use super::identified::Identified;
use super::passivity_violation::PassivityViolation;
use super::verdict::{Rejection, Verdict};
use super::warning::Warning;
use crate::decisions::HALF_WIDTH_95;
use crate::trajectory::jacobian::arguments_at;
use phisindy_expr::{Graph, Id, Node, Scratch, Tape, Unary};
use phisindy_phys::spec::Role;
use phisindy_phys::unit::{Dimension, Unit};
use phisindy_phys::{Model, Record, System};
use std::collections::HashMap;

/// Adds a warning for each passive law that feeds the motion, and rejects a model in which one was fitted so.
pub(crate) fn passivity(system: &System, records: &[Record], found: &mut Identified) {
    let Some(all) = Forces::new(system, records, found).map(|forces| forces.feeding()) else { return };
    if found.verdict.holds()
        && let Some(first) = all.iter().find(|f| f.is_fitted())
    {
        found.verdict = Verdict::Rejected(Rejection::Feeds(first.clone()));
    }
    found.warnings.extend(all.into_iter().map(Warning::Feeds));
}

/// A number with its derivatives by what was estimated, in the order of the covariance.
struct Derived {
    value: f64,
    slopes: Vec<f64>,
}

/// The rates of an identified model, split into what depends on the sign of a sliding velocity and what does
/// not.
struct Forces<'a> {
    system: &'a System,
    found: &'a Identified,
    /// The Fit records and their indices.
    fitted: Vec<(usize, &'a Record)>,
    model: Model,
    /// The rates with every sign of a velocity replaced by its mean.
    smooth: Vec<Id>,
    /// Each sliding velocity, and the rate of its speed by its dry friction: `dw/dx . b`.
    dry: Vec<(Id, Id)>,
}

impl<'a> Forces<'a> {
    fn new(system: &'a System, records: &'a [Record], found: &'a Identified) -> Option<Forces<'a>> {
        let terms: Vec<usize> = found.terms.iter().map(|t| t.term).collect();
        let mut model = system.model(&terms);
        let velocities: Vec<usize> = (0..system.states.len()).filter(|&k| is_velocity(system, k)).collect();
        let groups = sliding(&mut model, &velocities);
        let means: HashMap<Id, Id> = groups
            .iter()
            .flat_map(|(_, signs)| signs.clone())
            .map(|sign| (sign, mean_sign(&mut model.graph, sign)))
            .collect();
        let smooth = model.graph.replace(&model.rates.clone(), &means);
        let dry = groups.iter().map(|(w, signs)| (*w, slowing(&mut model, *w, signs))).collect();
        let fitted: Vec<(usize, &Record)> =
            records.iter().enumerate().filter(|(_, r)| r.role == Role::Fit).collect();
        (!fitted.is_empty()).then_some(Forces { system, found, fitted, model, smooth, dry })
    }

    fn feeding(mut self) -> Vec<PassivityViolation> {
        let mut all: Vec<PassivityViolation> = Vec::new();
        for (w, rate) in self.dry.clone() {
            let mut pushes = |near_rest| self.dry_friction(w, rate, near_rest);
            all.extend(pushes(false).or_else(|| pushes(true)));
        }
        let velocities = (0..self.system.states.len()).filter(|&k| is_velocity(self.system, k));
        for v in velocities.collect::<Vec<_>>() {
            all.extend(self.damping(v));
        }
        all
    }

    /// Dry friction whose fitted part makes it push: in the mean along the motion, or in the same mean with
    /// every sample brought to rest, each velocity by as much as it has of `w`.
    fn dry_friction(&mut self, w: Id, rate: Id, near_rest: bool) -> Option<PassivityViolation> {
        let parameters = self.estimated();
        let gradient = self.model.graph.gradient(rate, &parameters);
        let outputs: Vec<Id> = [w, rate].into_iter().chain(gradient).collect();
        let slopes = self.model.graph.gradient(w, &self.model.states.clone());
        let slopes: Vec<f64> = slopes.iter().map(|s| self.model.graph.value(*s).unwrap_or(0.0)).collect();
        let steep: f64 = slopes.iter().map(|s| s * s).sum();
        if near_rest && steep == 0.0 {
            return None;
        }
        let tape = Tape::compile(&self.model.graph, &self.model.arguments(), &outputs).ok()?;
        let mut scratch = Scratch::<1>::new(&tape);
        let (mut speed, mut level) = (0.0, Derived { value: 0.0, slopes: vec![0.0; self.numbers()] });
        for &(r, record) in &self.fitted {
            let run = self.found.records[r].run.as_ref()?;
            let parameters = self.parameters(r, record);
            for i in 0..record.len() {
                let states = run.state_at(i);
                scratch.at(arguments_at(record, i, states, &parameters));
                let speed_of_sample = scratch.output(0)[0];
                let size = speed_of_sample.abs();
                if near_rest {
                    let rest = states.iter().zip(&slopes).map(|(v, s)| v - speed_of_sample * s / steep);
                    scratch.at(arguments_at(record, i, &rest.collect::<Vec<_>>(), &parameters));
                }
                let push = |k: usize| -size * scratch.output(1 + k)[0];
                if !push(0).is_finite() {
                    continue;
                }
                speed += size;
                level.value += push(0);
                self.each_slope(r, |to, from| level.slopes[to] += push(1 + from));
            }
        }
        level.value /= speed;
        level.slopes.iter_mut().for_each(|s| *s /= speed);
        let error = self.found.standard_error(&level.slopes)?;
        let ci95 = (level.value - HALF_WIDTH_95 * error, level.value + HALF_WIDTH_95 * error);
        let unit = self.system.states.iter().position(|s| self.model.graph.uses(&[w], &[s.node]));
        let unit = unit.map_or(String::new(), |k| per_second(&self.system.states[k].unit));
        (error > 0.0 && ci95.1 < 0.0).then(|| PassivityViolation::DryFriction {
            velocity: self.model.text(w),
            level: level.value,
            ci95,
            near_rest,
            unit,
        })
    }

    /// Linear damping of a velocity that feeds it, or that only a turned sign keeps from feeding it.
    fn damping(&mut self, v: usize) -> Option<PassivityViolation> {
        let (state, node) = (self.system.states[v].name.clone(), self.model.states[v]);
        let slope = self.model.graph.gradient(self.smooth[v], &[node])[0];
        let moving: Vec<Id> =
            self.model.states.iter().chain(&self.model.inputs).copied().chain([self.model.time]).collect();
        if self.model.graph.uses(&[slope], &moving) {
            return None;
        }
        let parameters = self.estimated();
        let gradient = self.model.graph.gradient(slope, &parameters);
        let outputs: Vec<Id> = [slope].into_iter().chain(gradient.iter().copied()).collect();
        let tape = Tape::compile(&self.model.graph, &self.model.arguments(), &outputs).ok()?;
        let mut scratch = Scratch::<1>::new(&tape);
        for &(r, record) in &self.fitted {
            let still = vec![0.0; self.system.states.len()];
            let parameters = self.parameters(r, record);
            scratch.at(arguments_at(record, 0, &still, &parameters));
            let mut damping = Derived { value: scratch.output(0)[0], slopes: vec![0.0; self.numbers()] };
            self.each_slope(r, |to, from| damping.slopes[to] += scratch.output(1 + from)[0]);
            let error = self.found.standard_error(&damping.slopes)?;
            let reach = HALF_WIDTH_95 * error;
            let ci95 = (damping.value - reach, damping.value + reach);
            if ci95.0 > 0.0 {
                return Some(PassivityViolation::Damping { state, slope: damping.value, ci95 });
            }
            // The share of each constant in which the damping is linear.
            for (k, p) in self.found.parameters.iter().enumerate().filter(|(_, p)| p.id.holds_in(r)) {
                let Some(index) = p.id.constant() else { continue };
                let slope = gradient[self.found.terms.len() + index];
                let linear = !self.model.graph.uses(&[slope], &[self.system.parameters[index].node]);
                let share = damping.slopes[self.found.terms.len() + k] * p.estimate.value;
                let start = self.system.parameters[index].start;
                let turned = p.estimate.ci95.1 < 0.0 && start >= 0.0 && share < 0.0;
                if linear && turned && damping.value >= share * (1.0 + f64::EPSILON.sqrt()) {
                    return Some(PassivityViolation::TurnedSign {
                        state,
                        constant: p.id.of.to_string(),
                        value: p.estimate.value,
                        ci95: p.estimate.ci95,
                        unit: Unit::parse(&p.unit).map_or(String::new(), |u| u.dimension.to_string()),
                    });
                }
            }
        }
        None
    }

    /// Nodes of everything that may have been estimated: the coefficients, then the constants that move.
    fn estimated(&self) -> Vec<Id> {
        let count = self.found.terms.len() + self.system.parameters.len();
        self.model.parameters[..count].to_vec()
    }

    /// How many numbers were estimated.
    fn numbers(&self) -> usize {
        self.found.terms.len() + self.found.parameters.len()
    }

    /// Calls with each estimated number that a record depends on: its place among those, and that of its
    /// node.
    fn each_slope(&self, r: usize, mut add: impl FnMut(usize, usize)) {
        let t = self.found.terms.len();
        (0..t).for_each(|k| add(k, k));
        for (k, p) in self.found.parameters.iter().enumerate().filter(|(_, p)| p.id.holds_in(r)) {
            if let Some(index) = p.id.constant() {
                add(t + k, t + index);
            }
        }
    }

    /// The parameters of the model in a record: the coefficients, the constants that move, those of the
    /// record.
    fn parameters(&self, r: usize, record: &Record) -> Vec<f64> {
        let coefficients = self.found.terms.iter().map(|t| t.coefficient.value);
        let numbers = coefficients.chain(self.found.parameters_of(self.system, r));
        numbers.chain(record.constants.iter().copied()).collect()
    }
}

/// The sliding velocities of a model: what signs of its rates depend on, if it moves with velocities and no
/// other state; with all signs of it and of its negative.
fn sliding(model: &mut Model, velocities: &[usize]) -> Vec<(Id, Vec<Id>)> {
    let of_sign = |graph: &Graph, id: Id| match graph.node(id) {
        Node::Unary(Unary::Sgn | Unary::Step, w) => Some(w),
        _ => None,
    };
    let signs: Vec<Id> = model.graph.reachable(&model.rates);
    let mut groups: Vec<(Id, Vec<Id>)> = Vec::new();
    for id in signs {
        let Some(w) = of_sign(&model.graph, id) else { continue };
        let opposite = model.graph.neg(w);
        if let Some((_, signs)) = groups.iter_mut().find(|(other, _)| *other == w || *other == opposite) {
            signs.push(id);
            continue;
        }
        let slopes = model.graph.gradient(w, &model.states.clone());
        let moves = |k: &usize| model.graph.value(slopes[*k]) != Some(0.0);
        let with: Vec<usize> = (0..slopes.len()).filter(moves).collect();
        if !with.is_empty() && with.iter().all(|k| velocities.contains(k)) {
            groups.push((w, vec![id]));
        }
    }
    groups
}

/// The mean of a sign over both directions.
fn mean_sign(graph: &mut Graph, sign: Id) -> Id {
    let step = matches!(graph.node(sign), Node::Unary(Unary::Step, _));
    graph.constant(if step { 0.5 } else { 0.0 })
}

/// The rate of a sliding velocity by its dry friction while it is positive: half of what its rate changes by
/// with its signs.
fn slowing(model: &mut Model, w: Id, signs: &[Id]) -> Id {
    let (mut up, mut down) = (HashMap::new(), HashMap::new());
    for &id in signs {
        let Node::Unary(op, of) = model.graph.node(id) else { continue };
        let low = if op == Unary::Sgn { -1.0 } else { 0.0 };
        let (above, below) = if of == w { (1.0, low) } else { (low, 1.0) };
        up.insert(id, model.graph.constant(above));
        down.insert(id, model.graph.constant(below));
    }
    let rates = model.rates.clone();
    let (above, below) = (model.graph.replace(&rates, &up), model.graph.replace(&rates, &down));
    let slopes = model.graph.gradient(w, &model.states.clone());
    let graph = &mut model.graph;
    let (mut rate, half) = (graph.constant(0.0), graph.constant(0.5));
    for (slope, (a, b)) in slopes.into_iter().zip(above.into_iter().zip(below)) {
        let difference = graph.sub(a, b);
        let friction = graph.mul(half, difference);
        let share = graph.mul(slope, friction);
        rate = graph.add(rate, share);
    }
    rate
}

/// The unit of the rate of a state.
fn per_second(unit: &str) -> String {
    Unit::parse(unit).map_or(String::new(), |u| u.dimension.div(Dimension::SECOND).to_string())
}
