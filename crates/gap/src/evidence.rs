//! Evidence that a fit alone does not use: an elastic contact must give way, in the stops, in proportion to the force on it.

use crate::constraint::fulfilled;
use crate::decisions::{EXPLAINED, GIVES_BACK, GIVES_WAY, NO_END, SHORT_STOP, SLIPS};
use crate::drive::Drive;
use crate::evaluate::{evaluated, mean_along};
use crate::model::{Fitted, values};
use crate::motion::{Motion, rest_threshold, resting};
use crate::place::{Effect, Site};
use crate::result::Veto;
use phisindy_expr::Tape;
use phisindy_phys::spec::Role;
use phisindy_phys::{LawParameter, Record};
use std::f64::consts::TAU;

/// Why an effect cannot be, although it fits; `None` if nothing speaks against it.
pub(crate) fn against(fitted: &Fitted, effect: &Effect) -> Option<Veto> {
    [feeds, lacks, endless, clings, pushes, echoes, stands_firm]
        .into_iter()
        .find_map(|speaks| speaks(fitted, effect))
}

/// An elastic contact must give way, in the stops, in proportion to the force on it.
fn stands_firm(fitted: &Fitted, effect: &Effect) -> Option<Veto> {
    // Of a model that leaves nothing but noise the stops, too, are as measured.
    if fitted.score.is_white() && fitted.score.fit < EXPLAINED {
        return None;
    }
    if !effect.entry.law.has_memory() || effect.entry.law.family != "friction" {
        return None;
    }
    let Site::Force { acts, .. } = &effect.place.site else { return None };
    let &[(v, _)] = acts.as_slice() else { return None };
    let (model, system) = (&fitted.model, &fitted.model.system);
    let x = (0..system.states.len()).find(|&x| system.states[x].velocity == Some(v))?;
    let n = system.states.len();
    let (mut sxx, mut sxy, mut stops) = (0.0, 0.0, 0);
    let mut asked = 0.0;
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
                // Within a stop: the way measured against the way that the law makes, both about their means.
                let (a, b) = (i + (end - i) / 8, end - (end - i) / 8);
                let mean = |f: &dyn Fn(usize) -> f64| (a..b).map(f).sum::<f64>() / (b - a) as f64;
                let (law, real) = (|j: usize| run.states[j * n + x], |j: usize| motion.states[j * n + x]);
                let (ml, mr) = (mean(&law), mean(&real));
                for j in a..b {
                    sxx += (law(j) - ml).powi(2);
                    sxy += (law(j) - ml) * (real(j) - mr);
                }
                asked += (a..b).map(|j| (law(j) - ml).powi(2)).sum::<f64>();
                stops += 1;
            }
            i = end.max(i + 1);
        }
    }
    if stops < 4 || asked <= 0.0 {
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

/// The condition of the law's file that its parameters do not fulfil.
fn lacks(fitted: &Fitted, effect: &Effect) -> Option<Veto> {
    let law = &effect.entry.law;
    let need = law.needs.as_ref()?;
    (fulfilled(law, &numbers(fitted, effect)?)? < 0.0).then(|| Veto::Requirement(need.because.clone()))
}

/// A parameter that runs to the end of what its law allows stands for a simpler law.
fn endless(fitted: &Fitted, effect: &Effect) -> Option<Veto> {
    let law = &effect.entry.law;
    // A phase may be any.
    let ends = |((_, p), v): &(&(String, LawParameter), f64)| !p.each && *v > NO_END * p.within.1;
    let found = law.parameters.iter().zip(numbers(fitted, effect)?).find(ends)?;
    let ((name, p), _) = found;
    Some(Veto::ParameterAtEnd { name: name.clone(), bound: p.within.1, unit: p.unit.clone() })
}

/// A contact that gives way and never slips is a spring from where the record begins.
fn clings(fitted: &Fitted, effect: &Effect) -> Option<Veto> {
    let law = &effect.entry.law;
    if law.family != "friction" || !law.has_memory() {
        return None;
    }
    let level = *numbers(fitted, effect)?.first()?;
    // How far it gave way only its own run knows.
    fitted.cal.records.iter().map(|r| r.run.as_ref()).collect::<Option<Vec<_>>>()?;
    let most = force_and_speed(fitted, effect)?.into_iter().fold(0.0_f64, |m, (force, _)| m.max(force.abs()));
    (most < SLIPS * level).then_some(Veto::NeverSlips)
}

/// Force that an effect subtracts from its body, and the velocity of its place, along the motion of all Fit records, where they are finite.
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

/// Friction takes energy. One that gives back part of it along the measured motion is a curve through something else.
fn pushes(fitted: &Fitted, effect: &Effect) -> Option<Veto> {
    // A contact that gives way stores energy, and may give it back.
    if effect.entry.law.family != "friction" || effect.entry.law.has_memory() {
        return None;
    }
    let (mut taken, mut given) = (0.0, 0.0);
    for (force, speed) in force_and_speed(fitted, effect)? {
        let power = force * speed;
        if power > 0.0 { taken += power } else { given -= power }
    }
    (given > GIVES_BACK * taken).then_some(Veto::Pushes)
}

/// A force at a frequency of the drive makes good, there, whatever else the model lacks.
fn echoes(fitted: &Fitted, effect: &Effect) -> Option<Veto> {
    let law = &effect.entry.law;
    let screen = law.screen.as_ref()?;
    let oscillates = |name: &String| screen.grid.iter().any(|(grid, unit)| grid == name && unit == "rad/s");
    let at = law.parameters.iter().position(|(name, _)| oscillates(name))?;
    let frequency = *numbers(fitted, effect)?.get(at)?;
    // The drive of the model as it was: in this one the force is part of it.
    let base = fitted.model.without_effects();
    let span = |r: &Record| r.time[r.len() - 1] - r.time[0];
    let fits = || base.records.iter().filter(|r| r.role == Role::Fit);
    let longest = fits().map(span).fold(0.0, f64::max);
    if frequency * longest < std::f64::consts::PI {
        return Some(Veto::SlowTone(TAU / frequency));
    }
    let line = fits().find_map(|r| Drive::new(&base.system, r)?.line_at(frequency))?;
    Some(Veto::DriveFrequency(line))
}

/// A dashpot may be weaker than the model thought, but what is left of it may not feed the motion.
fn feeds(fitted: &Fitted, effect: &Effect) -> Option<Veto> {
    if !effect.entry.law.is_dashpot() {
        return None;
    }
    let Site::Force { acts, .. } = &effect.place.site else { return None };
    let system = &fitted.model.system;
    let &(v, _) = acts.first()?;
    let mut graph = system.graph.clone();
    let slope = graph.gradient(system.known[v], &[system.states[v].node])[0];
    let record = fitted.model.records.first()?;
    let motion = Motion::new(system, record, fitted.model.smooth.first()?, 0, &fitted.cal);
    let mean = mean_along(system, &graph, slope, &motion)?;
    (mean > 0.0).then_some(Veto::FeedsMotion)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{TrialModel, noise_of};
    use phisindy_learn::Effort;
    use phisindy_phys::{LawEntry, Origin, SourceId, check, spec};
    use phisindy_sim::synthesize;

    /// A law at the velocity of an oscillator that lacks `truth`, fitted to its motion from these numbers (SI) on.
    fn fitted(truth: &str, id: &str, law: &str, start: &[f64]) -> (Fitted, Effect) {
        let text = format!(
            r#"(states: {{ "x": "m", "v": "m/s" }}, constants: {{ "k": (1.0, "N/m"), "m": (1.0, "kg"), "c": (0.1, "N*s/m"), "F0": (1.0, "N"), "W": (0.7, "rad/s") }},
            known: {{ "x": "v", "v": "(-k*x - c*v + F0*cos(W*t))/m" }},
            inertia: {{ "v": "m" }}, unknown: {{}}, data: [ Synthetic(truth: {{ "v": "{truth}" }}, start: {{ "x": 1.0, "v": 0.0 }}, duration: 40.0, step: 0.05, noise: Additive(0.02), seed: 1) ])"#
        );
        let (spec, _) = spec::read(&text, SourceId(0)).expect("a spec");
        let (case, _) = check(&spec, SourceId(0)).expect("a case");
        let Origin::Synthetic(plan) = &case.records[0].origin else { panic!("a measured record") };
        let (record, _) =
            synthesize(&case.records[0], plan, &case.system, None, &|_| Err("no files here".into()))
                .expect("a record");
        let records = vec![record];
        let noise = noise_of(&records);
        let base = TrialModel::base(spec, case, records);
        let entry = LawEntry::read(id, law).expect("a law");
        let place = base.places().iter().find(|p| p.at == "v").expect("a place").clone();
        let effect =
            Effect { entry, place, mirror: false, load: None, start: start.to_vec(), beside: vec![] };
        let model = base.with(&effect).expect("a model");
        (Fitted::new(model, &noise, Effort::Plain).expect("a fit"), effect)
    }

    fn said(truth: &str, id: &str, law: &str, start: &[f64]) -> Option<Veto> {
        let (fitted, effect) = fitted(truth, id, law, start);
        against(&fitted, &effect)
    }

    const PRESLIDING: &str = include_str!("../../../specs/laws/presliding.ron");
    const DEAD_ZONE: &str = include_str!("../../../specs/laws/dead-zone.ron");
    const TONE: &str = include_str!("../../../specs/laws/harmonic-force.ron");

    /// A contact that holds whatever comes is a spring; one that slips is none.
    #[test]
    fn an_elastic_contact_that_never_slips_is_a_spring() {
        let (spring, contact) = fitted("-0.5*x", "presliding", PRESLIDING, &[100.0, 0.5]);
        assert_eq!(clings(&spring, &contact), Some(Veto::NeverSlips));
        assert_eq!(said("-0.3*sgn(v)", "presliding", PRESLIDING, &[0.3, 5.0]), None);
    }

    /// A gap beyond all that the body does is none: what is left is a constant force, or a spring that is gone.
    #[test]
    fn a_parameter_without_an_end_is_none() {
        let law = DEAD_ZONE.replace("within: (0.0, 10.0)", "within: (0.0, 0.5)");
        assert_ne!(law, DEAD_ZONE);
        let truth = "-0.8*(max(x-0.3, 0) + min(x+0.3, 0) - x)";
        let why = said(truth, "dead-zone", &law, &[0.8, 0.3]);
        assert!(matches!(why, Some(Veto::ParameterAtEnd { .. })), "{why:?}");
        assert_eq!(said(truth, "dead-zone", DEAD_ZONE, &[0.8, 0.3]), None);
    }

    /// Half a period in a record is a slope; one and a half are a tone.
    #[test]
    fn a_tone_slower_than_the_record_is_none() {
        let why = said("0.2*cos(0.05*t+1)", "harmonic-force", TONE, &[0.2, 0.05, 1.0]);
        assert!(matches!(why, Some(Veto::SlowTone(_))), "{why:?}");
        assert_eq!(said("0.2*cos(0.25*t+1)", "harmonic-force", TONE, &[0.2, 0.25, 1.0]), None);
    }
}
