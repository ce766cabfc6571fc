//! The force that a step adds, beside the force that the measured motion asks for: inertia times measured
//! acceleration less the forces that the model knows.

use crate::measured_force::{Acceleration, Body, Parts, SAMPLES};
use crate::table::REACH;
use phisindy_expr::{Id, Scratch, Tape};
use phisindy_gap::{ForceHistory, Gap, Site, Step, force_history};
use phisindy_learn::{FoundParameter, parameter_values};
use phisindy_phys::unit::Unit;
use phisindy_phys::{Record, System};

/// The force of a step in one record.
pub(crate) struct RecordForce {
    /// Name of the record.
    pub(crate) name: String,
    /// The law: abscissa, force, and the 95 % band of its numbers, each moved by itself and added in squares.
    /// Sorted by the abscissa where the force is a function of it, else by time.
    pub(crate) law: Vec<(f64, f64, (f64, f64))>,
    /// The force balance of the measured motion; empty where the motion of its body is not measured.
    pub(crate) measured: Vec<(f64, f64)>,
}

/// The force of a step in all records.
pub(crate) struct Balance {
    /// What the abscissa and the force are, and their units.
    pub(crate) axes: ForceHistory,
    /// One for each record with a run.
    pub(crate) records: Vec<RecordForce>,
    /// What the measured points are made of.
    pub(crate) parts: Parts,
    /// The longest time (s) over which displacements were smoothed for the acceleration; 0 where it is
    /// measured.
    pub(crate) smoothed: f64,
}

/// The force of a step; `None` for an effect on sensors or inputs, or where no record has a run.
pub(crate) fn balance(found: &Gap, step: &Step, records: &[Record]) -> Option<Balance> {
    let axes = force_history(found, step, records)?;
    let acting = Acting::of(found, step, &axes)?;
    let mut out = Balance { axes, records: vec![], parts: acting.body.parts(), smoothed: 0.0 };
    for (r, record) in records.iter().enumerate() {
        let Some((force, smoothed)) = acting.in_record(found, step, record, r, out.axes.function) else {
            continue;
        };
        out.smoothed = out.smoothed.max(smoothed);
        out.records.push(force);
    }
    (!out.records.is_empty()).then_some(out)
}

/// The force of an effect on a body.
struct Acting<'a> {
    system: &'a System,
    tape: Tape,
    body: Body<'a>,
    /// From SI to the units of the axes.
    units: (f64, f64),
    sticks: bool,
}

impl<'a> Acting<'a> {
    fn of(found: &'a Gap, step: &Step, axes: &ForceHistory) -> Option<Acting<'a>> {
        let Site::Force { displacement, velocity, acts, shows, .. } = &step.effect.place.site else {
            return None;
        };
        let system = &found.simulated.system;
        let law = &step.effect.entry.law;
        let place = match displacement {
            Some(x) if x.bare() == axes.over => x.node,
            _ if velocity.bare() == axes.over => velocity.node,
            _ => system.time,
        };
        let force = step.force?;
        let first = acts.first();
        let one = system.time;
        let rate = first.map_or(one, |(s, _)| system.known[*s]);
        let inertia = first.and_then(|(s, _)| system.inertia[*s]);
        let nodes: [Id; 5] = [place, force, velocity.node, rate, inertia.unwrap_or(one)];
        let tape = Tape::compile(&system.graph, &system.arguments(), &nodes).ok()?;
        let factor = |unit: &str| Unit::parse(unit).map_or(1.0, |u| u.factor);
        let size = if axes.push { -1.0 } else { 1.0 } / factor(&axes.unit);
        let acceleration = match (first, shows.first()) {
            (Some((s, _)), _) => Acceleration::of(system, *s),
            (None, Some((output, _))) => Acceleration::Read(system.states.len() + output),
            (None, None) => Acceleration::Unknown,
        };
        let sign = first.map_or_else(|| shows.first().map_or(1.0, |s| s.1), |f| f.1);
        Some(Acting {
            system,
            tape,
            body: Body { system, state: first.map(|f| f.0), acceleration, sign },
            units: (1.0 / factor(&axes.over_unit), size),
            sticks: law.sticks(),
        })
    }

    /// The force in a record, and over which time the acceleration was smoothed.
    fn in_record(
        &self,
        found: &Gap,
        step: &Step,
        record: &Record,
        r: usize,
        function: bool,
    ) -> Option<(RecordForce, f64)> {
        let fit = found.simulated.records.get(r)?;
        let run = fit.run.as_ref()?;
        let owner = record.continues.unwrap_or(r);
        let numbers = parameter_values(&found.parameters, self.system, owner);
        let every = record.len().div_ceil(SAMPLES).max(1);
        let mut scratch = Scratch::<1>::new(&self.tape);
        let mut evaluated = |i: usize, states: &[f64], numbers: &[f64]| -> [f64; 5] {
            crate::measured_force::outputs_at(&mut scratch, record, i, states, numbers)
        };
        let moved = self.moved(found, step, owner, &numbers);
        let (across, size) = self.units;
        let mut law = Vec::new();
        for i in (0..record.len()).step_by(every) {
            let states = run.state_at(i);
            let [place, force, speed, ..] = evaluated(i, states, &numbers);
            if (self.sticks && speed == 0.0) || !(place.is_finite() && force.is_finite()) {
                continue;
            }
            let reach: f64 = moved
                .iter()
                .map(|(low, high)| 0.5 * (evaluated(i, states, high)[1] - evaluated(i, states, low)[1]))
                .filter(|d| d.is_finite())
                .map(|d| d * d)
                .sum();
            let (y, reach) = (size * force, (size * reach.sqrt()).abs());
            law.push((across * place, y, (y - reach, y + reach)));
        }
        if function {
            law.sort_by(|a, b| a.0.total_cmp(&b.0));
        }
        let typical = law.iter().map(|p| (p.1 / size).abs()).fold(0.0, f64::max);
        let (measured, smoothed) =
            self.body.measured(record, fit, &found.noise, typical, &numbers, &mut evaluated);
        let measured = measured.into_iter().map(|(place, force)| (across * place, size * force)).collect();
        (law.len() > 1).then(|| (RecordForce { name: record.name.clone(), law, measured }, smoothed))
    }

    /// The numbers of the model with each of the step's own at the ends of its interval.
    fn moved(&self, found: &Gap, step: &Step, owner: usize, numbers: &[f64]) -> Vec<(Vec<f64>, Vec<f64>)> {
        let own = |p: &&FoundParameter| {
            let name = p.id.constant().map(|k| self.system.parameters[k].name.as_str());
            p.id.holds_in(owner) && step.parameters.iter().any(|s| Some(s.constant.as_str()) == name)
        };
        let ends = |p: &FoundParameter| {
            let with = |sign: f64| {
                let mut all = numbers.to_vec();
                let value = p.estimate.value + sign * REACH * p.estimate.std_error;
                if let Some(k) = p.id.constant() {
                    all[k] = value.clamp(p.bounds.0, p.bounds.1);
                }
                all
            };
            (with(-1.0), with(1.0))
        };
        let known = found.parameters.iter().filter(own).filter(|p| p.estimate.std_error.is_finite());
        known.map(ends).collect()
    }
}
