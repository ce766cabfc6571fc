//! Evidence outside the fit that rules out laws which fit well: energy balance, bounds, conditions of the
//! law's file, the drive, compliance during stops.

use crate::constraint::fulfilled;
use crate::decisions::{EXPLAINED, FAR_ABOVE, GIVES_BACK, GIVES_WAY, SAME_FORCE, SHORT_STOP, SLIPS};
use crate::drive::{Drive, multiple_of_oscillation};
use crate::evaluate::evaluated;
use crate::formula::DISCOVERED;
use crate::model::{Applied, Fitted, values};
use crate::motion::{Motion, rest_threshold, resting};
use crate::place::{Effect, Site};
use crate::result::Veto;
use phisindy_expr::{Id, Tape};
use phisindy_learn::FoundParameter;
use phisindy_phys::spec::Role;
use phisindy_phys::{LawRole, Record};
use std::collections::HashMap;
use std::f64::consts::TAU;

/// The reason why an effect is ruled out although it fits; `None` if there is none.
pub(crate) fn against(fitted: &Fitted, effect: &Effect) -> Option<Veto> {
    [
        feeds_motion,
        violates_requirement,
        parameter_at_bound,
        never_slips,
        is_dry_friction,
        returns_energy,
        unidentifiable_tone,
        contact_is_rigid,
    ]
    .into_iter()
    .find_map(|check| check(fitted, effect))
}

/// Whether no evidence rules out any effect of a fitted model.
pub(crate) fn stands(fitted: &Fitted) -> bool {
    fitted.model.effects.iter().all(|a| against(fitted, &a.effect).is_none())
}

/// The elastic deflection of a contact during stops must be in proportion to the force on it.
fn contact_is_rigid(fitted: &Fitted, effect: &Effect) -> Option<Veto> {
    // Where the residual is white, the simulated stops agree with the data already.
    if fitted.score.is_white() && fitted.score.fit < EXPLAINED {
        return None;
    }
    if !effect.entry.law.is_hysteretic() {
        return None;
    }
    let Site::Force { acts, .. } = &effect.place.site else { return None };
    let &[(v, _)] = acts.as_slice() else { return None };
    let (model, system) = (&fitted.model, &fitted.model.system);
    let x = (0..system.states.len()).find(|&x| system.states[x].velocity == Some(v))?;
    let n = system.states.len();
    let (mut sxx, mut sxy, mut stops) = (0.0, 0.0, 0);
    let mut variation = 0.0;
    for (r, record) in model.records.iter().enumerate().filter(|(_, d)| d.role == Role::Fit) {
        let run = fitted.cal.records[r].run.as_ref()?;
        record.columns[x].as_ref()?;
        let motion = Motion::new(system, record, &model.smooth[r], r, &fitted.cal);
        let speed: Vec<f64> = (0..motion.samples()).map(|i| motion.states[i * n + v]).collect();
        let step = (motion.time[motion.samples() - 1] - motion.time[0]) / motion.samples() as f64;
        let least = ((SHORT_STOP * motion.period / step) as usize).clamp(8, motion.samples());
        let rests = resting(&speed, rest_threshold(&speed), least);
        let mut i = 0;
        while i < rests.len() {
            let end = (i..rests.len()).find(|&j| !rests[j]).unwrap_or(rests.len());
            if rests[i] && end - i >= least {
                // Regresses the measured displacement within a stop on the simulated one, both about their
                // means.
                let (a, b) = (i + (end - i) / 8, end - (end - i) / 8);
                let mean = |f: &dyn Fn(usize) -> f64| (a..b).map(f).sum::<f64>() / (b - a) as f64;
                let (law, real) = (|j: usize| run.states[j * run.n + x], |j: usize| motion.states[j * n + x]);
                let (ml, mr) = (mean(&law), mean(&real));
                for j in a..b {
                    sxx += (law(j) - ml).powi(2);
                    sxy += (law(j) - ml) * (real(j) - mr);
                }
                variation += (a..b).map(|j| (law(j) - ml).powi(2)).sum::<f64>();
                stops += 1;
            }
            i = end.max(i + 1);
        }
    }
    if stops < 4 || variation <= 0.0 {
        return None;
    }
    let slope = sxy / sxx;
    (slope < GIVES_WAY).then_some(Veto::DoesNotGiveWay { stops, slope })
}

/// The parameters of an effect of a fitted model.
fn numbers(fitted: &Fitted, effect: &Effect) -> Option<Vec<f64>> {
    let own = fitted.model.effects.iter().find(|a| a.effect.same(effect))?;
    Some(values(fitted, &own.names, &effect.start))
}

/// Rules out parameters that violate the condition of the law's file.
fn violates_requirement(fitted: &Fitted, effect: &Effect) -> Option<Veto> {
    let law = &effect.entry.law;
    let need = law.needs.as_ref()?;
    (fulfilled(law, &numbers(fitted, effect)?)? < 0.0).then(|| Veto::Requirement(need.because.clone()))
}

/// A parameter that ends at the upper bound of its law, where the data want to go beyond it, stands for a simpler law.
fn parameter_at_bound(fitted: &Fitted, effect: &Effect) -> Option<Veto> {
    let applied = fitted.model.effects.iter().find(|a| a.effect.same(effect))?;
    parameter_at_end(fitted, applied, |found| found.estimate.value >= found.bounds.1)
}

/// The first parameter of an effect that ended where `at_end` says, with the bound that is nearer.
pub(crate) fn parameter_at_end(
    fitted: &Fitted,
    applied: &Applied,
    at_end: impl Fn(&FoundParameter) -> bool,
) -> Option<Veto> {
    let mut law = applied.effect.entry.law.parameters.iter().zip(&applied.parameters);
    law.find_map(|((name, p), &k)| {
        // What each record has of its own, a phase, may take any value; so may a number over its whole range.
        let of = |f: &&FoundParameter| !p.each && !p.whole && f.id.constant() == Some(k);
        let found = fitted.cal.parameters.iter().find(of).filter(|f| at_end(f))?;
        let (low, high) = found.bounds;
        let bound = if found.estimate.value - low < high - found.estimate.value { low } else { high };
        // The law's file speaks of forces and lengths, the model perhaps of accelerations and angles.
        Some(Veto::ParameterAtEnd {
            name: name.clone(),
            bound: bound / found.factor,
            unit: found.unit.clone(),
        })
    })
}

/// An elastic contact that never slips acts as a spring: each of its internal states follows the motion, or goes back the
/// way that it came.
fn never_slips(fitted: &Fitted, effect: &Effect) -> Option<Veto> {
    if !effect.entry.law.is_hysteretic() {
        return None;
    }
    // The deflection is an internal state, which only a successful run provides.
    fitted.cal.records.iter().map(|r| r.run.as_ref()).collect::<Option<Vec<_>>>()?;
    (most_slip(fitted, effect)? < SLIPS).then_some(Veto::NeverSlips)
}

/// The largest part of the motion that an internal state of an effect does not follow, along all Fit records: its rate
/// against the rate of the undeflected contact. What it gives back on the way back, at the same deflection, is no slip.
fn most_slip(fitted: &Fitted, effect: &Effect) -> Option<f64> {
    let Site::Force { velocity, .. } = &effect.place.site else { return None };
    let (model, system) = (&fitted.model, &fitted.model.system);
    let own = model.effects.iter().find(|a| a.effect.same(effect))?;
    let mut graph = system.graph.clone();
    let zero = graph.constant(0.0);
    let back = HashMap::from([(velocity.node, graph.neg(velocity.node))]);
    let mut outputs = Vec::new();
    for name in &own.internal {
        let z = system.state(name)?;
        let rate = system.known[z];
        let undeflected = HashMap::from([(system.states[z].node, zero)]);
        outputs.push(rate);
        outputs.push(graph.replace(&[rate], &back)[0]);
        outputs.push(graph.replace(&[rate], &undeflected)[0]);
    }
    let tape = Tape::compile(&graph, &system.arguments(), &outputs).ok()?;
    let mut most = 0.0_f64;
    for (r, record) in model.records.iter().enumerate().filter(|(_, d)| d.role == Role::Fit) {
        let motion = Motion::new(system, record, &model.smooth[r], r, &fitted.cal);
        let values = evaluated(&tape, &motion, &[], &[]);
        for rates in values.chunks_exact(3) {
            let slip = |k: usize| {
                let (now, back, free) = (rates[0][k], rates[1][k], rates[2][k]);
                (1.0 - now / free).abs().min(((now + back) / free).abs())
            };
            most = (0..rates[0].len()).map(slip).filter(|s| s.is_finite()).fold(most, f64::max);
        }
    }
    Some(most)
}

/// The force that an effect subtracts and the velocity of its place, along the motion of all Fit records, at
/// samples where both are finite.
fn force_and_speed(fitted: &Fitted, effect: &Effect) -> Option<Vec<(f64, f64)>> {
    let Site::Force { velocity, .. } = &effect.place.site else { return None };
    let (model, system) = (&fitted.model, &fitted.model.system);
    let force = model.effects.iter().find(|a| a.effect.same(effect))?.force?;
    let tape = Tape::compile(&system.graph, &system.arguments(), &[force, velocity.node]).ok()?;
    let mut all = Vec::new();
    for (r, record) in model.records.iter().enumerate().filter(|(_, d)| d.role == Role::Fit) {
        let motion = Motion::new(system, record, &model.smooth[r], r, &fitted.cal);
        let values = evaluated(&tape, &motion, &[], &[]);
        let pairs = values[0].iter().copied().zip(values[1].iter().copied());
        all.extend(pairs.filter(|(force, speed)| (force * speed).is_finite()));
    }
    Some(all)
}

/// A damper whose force is the same in slow and in quick motion, in the first and the last quarter of the speeds, stands
/// for dry friction, which also holds the body. A formula says itself where it is level.
fn is_dry_friction(fitted: &Fitted, effect: &Effect) -> Option<Veto> {
    if !effect.entry.law.is_resistance() || effect.entry.id == DISCOVERED {
        return None;
    }
    let mut all = force_and_speed(fitted, effect)?;
    all.sort_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
    let (slow, quick) = (all.get(all.len() / 4)?.0.abs(), all.get(3 * all.len() / 4)?.0.abs());
    (slow > (1.0 - SAME_FORCE) * quick && quick > 0.0).then_some(Veto::IsDryFriction)
}

/// Friction dissipates. A friction law that returns energy along the measured motion imitates something else.
fn returns_energy(fitted: &Fitted, effect: &Effect) -> Option<Veto> {
    let law = &effect.entry.law;
    // A law with memory stores energy and may return it; one that takes it whatever its numbers cannot.
    let takes = law.dissipates() == Some(true) && effect.load.is_none();
    if law.family != "friction" || law.has_memory() || takes {
        return None;
    }
    let (mut taken, mut given) = (0.0, 0.0);
    for (force, speed) in force_and_speed(fitted, effect)? {
        let power = force * speed;
        if power > 0.0 { taken += power } else { given -= power }
    }
    (given > GIVES_BACK * taken).then_some(Veto::Pushes)
}

/// The frequency of an effect that oscillates by itself (rad/s).
pub(crate) fn frequency(fitted: &Fitted, effect: &Effect) -> Option<f64> {
    let law = &effect.entry.law;
    let screen = law.screen.as_ref()?;
    let oscillates = |name: &String| screen.grid.iter().any(|(grid, unit)| grid == name && unit == "rad/s");
    let at = law.parameters.iter().position(|(name, _)| oscillates(name))?;
    numbers(fitted, effect)?.get(at).copied()
}

/// A periodic force is not identifiable at a frequency of the drive or, without a drive, of the oscillation,
/// nor at a multiple of it: there it stands for anything nonlinear that is missing. Nor is it where its
/// period exceeds twice the record.
fn unidentifiable_tone(fitted: &Fitted, effect: &Effect) -> Option<Veto> {
    let law = &effect.entry.law;
    let frequency = frequency(fitted, effect)?;
    // The drive of the base model: in the fitted one this force is part of the drive.
    let base = fitted.model.without_effects();
    let span = |r: &Record| r.time[r.len() - 1] - r.time[0];
    let fits = || base.records.iter().filter(|r| r.role == Role::Fit);
    let longest = fits().map(span).fold(0.0, f64::max);
    if frequency * longest < std::f64::consts::PI {
        return Some(Veto::SlowTone(TAU / frequency));
    }
    // A drive has all its multiples in the motion, friction sees to that. In a free oscillation they fade: a
    // cubic law makes three times its frequency; times a displacement of that frequency, twice the frequency
    // does it.
    let most = if law.role(LawRole::Displacement).is_some() { 2 } else { 3 };
    fits().find_map(|record| {
        let mut drive = Drive::new(&base.system, record)?;
        if !drive.is_still() {
            let (line, times) = drive.multiple_at(frequency)?;
            return Some(Veto::OwnFrequency { line, times, free: false });
        }
        let found = multiple_of_oscillation(record, frequency, most)?;
        // Where nothing else is left, a frequency beside the multiple is one of its own.
        let own = !found.exactly && fitted.score.is_white();
        (!own).then_some(Veto::OwnFrequency { line: found.line, times: found.times, free: true })
    })
}

/// A resistance, a force of the velocity alone, may correct the damping of the known part, but together with
/// it must not feed the motion at any speed, whatever the other effects take out. The velocity-dependent part
/// of the rate of the body, from the place at rest to its speed, must take energy in each quarter of the
/// speeds, and still does so far above them. A known part that feeds the motion is active by itself.
fn feeds_motion(fitted: &Fitted, effect: &Effect) -> Option<Veto> {
    if !effect.entry.law.is_resistance() {
        return None;
    }
    let effects = &fitted.model.effects;
    let others: Vec<Id> = effects.iter().filter(|a| !a.effect.same(effect)).filter_map(|a| a.force).collect();
    let all: Vec<Id> = effects.iter().filter_map(|a| a.force).collect();
    let feeds = |without: &[Id]| Some(powers(fitted, effect, without)?.iter().any(|power| *power > 0.0));
    (feeds(&others)? && !feeds(&all)?).then_some(Veto::FeedsMotion)
}

/// The energy that the velocity-dependent part of a body's rate feeds into the motion, by quarters of the
/// speed of an effect's place and at `FAR_ABOVE` times all speeds, along the measured motion of the first
/// record, without these forces.
fn powers(fitted: &Fitted, effect: &Effect, without: &[Id]) -> Option<[f64; 5]> {
    let Site::Force { acts, velocity, .. } = &effect.place.site else { return None };
    let &(v, sign) = acts.first()?;
    let mut system = fitted.model.system.clone();
    let state = system.states[v].node;
    let signed = system.graph.constant(sign.signum());
    let step = system.graph.mul(signed, velocity.node);
    let nothing = system.graph.constant(0.0);
    let gone: HashMap<Id, Id> = without.iter().map(|&force| (force, nothing)).collect();
    let rate = system.graph.replace(&[system.known[v]], &gone)[0];
    // The power at `times` the speed of the place.
    let mut power_at = |times: f64| {
        let factor = system.graph.constant(times);
        let speed = system.graph.mul(factor, step);
        let at_rest = system.graph.sub(state, step);
        let there = system.graph.add(at_rest, speed);
        let moving = system.graph.replace(&[rate], &HashMap::from([(state, there)]))[0];
        let still = system.graph.replace(&[rate], &HashMap::from([(state, at_rest)]))[0];
        let part = system.graph.sub(moving, still);
        system.graph.mul(part, speed)
    };
    let outputs = [power_at(1.0), power_at(FAR_ABOVE), velocity.node];
    let tape = Tape::compile(&system.graph, &system.arguments(), &outputs).ok()?;
    let record = fitted.model.records.first()?;
    let motion = Motion::new(&system, record, fitted.model.smooth.first()?, 0, &fitted.cal);
    let values = evaluated(&tape, &motion, &[], &[]);
    let of = |i: usize| (values[2][i].abs(), values[0][i], values[1][i]);
    let mut samples: Vec<(f64, f64, f64)> = (0..motion.samples()).map(of).collect();
    samples.retain(|(speed, here, far)| speed.is_finite() && here.is_finite() && far.is_finite());
    samples.sort_by(|a, b| a.0.total_cmp(&b.0));
    let quarter = (samples.len() / 4).max(1);
    let mut sums = [0.0; 5];
    for (i, (_, here, far)) in samples.iter().enumerate() {
        sums[(i / quarter).min(3)] += here;
        sums[4] += far;
    }
    Some(sums)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_models::{effect, fitted as fitted_model, model};

    /// A law at the velocity of an oscillator whose model lacks `truth`, fitted from these start values (SI).
    fn fitted(truth: &str, id: &str, law: &str, start: &[f64]) -> (Fitted, Effect) {
        let (base, noise) = model(&format!(
            r#"(states: {{ "x": "m", "v": "m/s" }}, constants: {{ "k": (1.0, "N/m"), "m": (1.0, "kg"), "c": (0.1, "N*s/m"), "F0": (1.0, "N"), "W": (0.7, "rad/s") }},
            known: {{ "x": "v", "v": "(-k*x - c*v + F0*cos(W*t))/m" }},
            inertia: {{ "v": "m" }}, unknown: {{}}, data: [ Synthetic(truth: {{ "v": "{truth}" }}, start: {{ "x": 1.0, "v": 0.0 }}, duration: 40.0, step: 0.05, noise: Additive(0.02), seed: 1) ])"#
        ));
        let effect = effect(&base, id, law, "v", start);
        (fitted_model(base.with(&effect).expect("a model"), &noise), effect)
    }

    fn said(truth: &str, id: &str, law: &str, start: &[f64]) -> Option<Veto> {
        let (fitted, effect) = fitted(truth, id, law, start);
        against(&fitted, &effect)
    }

    const PRESLIDING: &str = include_str!("../../phys/laws/presliding.ron");
    const TONE: &str = include_str!("../../phys/laws/harmonic-force.ron");

    /// An elastic contact that never slips is ruled out; one that slips is not.
    #[test]
    fn an_elastic_contact_that_never_slips_is_a_spring() {
        let (spring, contact) = fitted("-0.5*x", "presliding", PRESLIDING, &[100.0, 0.5]);
        assert_eq!(never_slips(&spring, &contact), Some(Veto::NeverSlips));
        assert_eq!(said("-0.3*sgn(v)", "presliding", PRESLIDING, &[0.3, 5.0]), None);
        // A curve of the displacement saturates as an element with memory does, and goes the same way back.
        let bouc_wen = include_str!("../../phys/laws/bouc-wen.ron");
        let why = said("-0.6*atan(x/0.7)", "bouc-wen", bouc_wen, &[0.9, 0.1, 1.2]);
        assert_eq!(why, Some(Veto::NeverSlips));
    }

    /// A damper of 0.7 is beyond a bound of 0.5; near a bound of 0.75 the records tell it as well as far from one.
    #[test]
    fn a_parameter_at_its_bound_is_ruled_out() {
        let within = |bound: &str| said("-0.7*v", "viscous", &VISCOUS.replace("1e12", bound), &[0.4]);
        let why = within("0.5");
        assert!(matches!(why, Some(Veto::ParameterAtEnd { .. })), "{why:?}");
        assert_eq!((within("0.75"), within("1e12")), (None, None));
    }

    /// The bound is told in the unit of the model, not in that of the law's file: here a clearance is an
    /// angle.
    #[test]
    fn the_bound_of_a_law_is_told_in_the_unit_of_the_model() {
        let (base, noise) = model(
            r#"(states: { "x": "rad", "v": "rad/s" }, constants: { "k": (1.0, "1/s^2"), "c": (0.1, "1/s"), "F0": (1.0, "1/s^2"), "W": (0.7, "rad/s") },
            known: { "x": "v", "v": "-k*x - c*v + F0*cos(W*t)" }, unknown: {},
            data: [ Synthetic(truth: { "v": "-0.8*(max(x-0.3, 0) + min(x+0.3, 0) - x)" }, start: { "x": 1.0, "v": 0.0 }, duration: 40.0, step: 0.05, noise: Additive(0.02), seed: 1) ])"#,
        );
        let law = r#"(name: "Play", roles: { "x": "m", "v": "m/s" }, parameters: { "gap": (unit: "m", within: (0.0, 0.2)) },
            given: { "ks": (0.8, "N/m") }, force: "ks*(dead(x,gap) - x)")"#;
        let contact = effect(&base, "play", law, "v", &[0.15]);
        let last = fitted_model(base.with(&contact).expect("a model"), &noise);
        let why = parameter_at_bound(&last, &contact);
        assert!(matches!(&why, Some(Veto::ParameterAtEnd { unit, .. }) if unit == "rad"), "{why:?}");
    }

    /// Less than half a period in a record is a trend; one and a half periods are a tone.
    #[test]
    fn a_tone_slower_than_the_record_is_ruled_out() {
        let why = said("0.2*cos(0.05*t+1)", "harmonic-force", TONE, &[0.2, 0.05, 1.0]);
        assert!(matches!(why, Some(Veto::SlowTone(_))), "{why:?}");
        assert_eq!(said("0.2*cos(0.25*t+1)", "harmonic-force", TONE, &[0.2, 0.25, 1.0]), None);
    }

    const VISCOUS: &str = include_str!("../../phys/laws/viscous.ron");
    const DRAG: &str = include_str!("../../phys/laws/quadratic-drag.ron");
    const PARAMETRIC: &str = include_str!("../../phys/laws/parametric-stiffness.ron");

    /// A correction of the known damper is a finding; more than the damper, or a drag that pushes at high
    /// speeds, is not.
    #[test]
    fn a_resistance_that_feeds_the_motion_is_ruled_out() {
        assert_eq!(said("0.06*v", "viscous", VISCOUS, &[-0.05]), None);
        assert_eq!(said("0.13*v", "viscous", VISCOUS, &[-0.05]), Some(Veto::FeedsMotion));
        assert_eq!(said("0.02*v*|v|", "quadratic-drag", DRAG, &[-0.02]), Some(Veto::FeedsMotion));
        assert_eq!(said("-0.1*v*|v|", "quadratic-drag", DRAG, &[0.1]), None);
    }

    /// A damper that is level from the slowest motion on is friction; one that levels out within the speeds is not.
    #[test]
    fn a_damper_whose_force_is_level_is_ruled_out() {
        let law = include_str!("../../phys/laws/digressive-damping.ron");
        let at = |knee: f64| {
            let truth = format!("-{:?}*v/(1 + |v|/{knee:?})", 0.3 / knee);
            said(&truth, "digressive-damping", law, &[0.3 / knee, knee])
        };
        assert_eq!(at(0.002), Some(Veto::IsDryFriction));
        assert_eq!(at(0.5), None);
    }

    /// Twice the frequency of the drive stands for anything cubic.
    #[test]
    fn a_tone_at_a_multiple_of_the_drive_is_ruled_out() {
        let why = said("-0.2*x^3", "parametric-stiffness", PARAMETRIC, &[0.1, 1.4, 0.0]);
        assert!(matches!(why, Some(Veto::OwnFrequency { times: 2, free: false, .. })), "{why:?}");
        assert_eq!(said("-0.2*cos(1.72*t)*x", "parametric-stiffness", PARAMETRIC, &[0.2, 1.72, 0.0]), None);
    }
}
