//! Doubts about a model that leaves only noise: an effect that evidence rules out, an effect whose numbers the
//! records do not determine, two effects whose forces cancel.

use crate::decisions::CANCELS;
use crate::evaluate::evaluated;
use crate::evidence::against;
use crate::model::{Applied, Fitted};
use crate::motion::Motion;
use crate::place::Site;
use crate::result::{Cancelling, PlacedLaw, Veto, Vetoed};
use phisindy_expr::Tape;
use phisindy_learn::FoundParameter;
use phisindy_phys::spec::Role;

/// The effects of a fitted model that evidence rules out, or whose numbers the records do not determine, by
/// index. The intervals of the parameters must be known.
pub(crate) fn vetoed(last: &Fitted) -> Vec<(usize, Vetoed)> {
    let of = |(k, applied): (usize, &Applied)| {
        let why = against(last, &applied.effect).or_else(|| undetermined(last, applied))?;
        Some((k, Vetoed { law: PlacedLaw::of(&applied.effect), why }))
    };
    last.model.effects.iter().enumerate().filter_map(of).collect()
}

/// Whether an effect has numbers that its records may not determine: several of them.
pub(crate) fn may_be_undetermined(applied: &Applied) -> bool {
    applied.effect.entry.law.parameters.len() > 1
}

/// A law is determined if none of its parameters ends at a bound, where the data want to go beyond it, and the
/// interval of one of its coefficients excludes zero. A law that contains a simpler one has the level of that one as its first coefficient; of the others at least one must exclude zero, or be
/// known to a small part of the level.
fn undetermined(last: &Fitted, applied: &Applied) -> Option<Veto> {
    let law = &applied.effect.entry.law;
    let found = |k: usize| -> Option<&FoundParameter> {
        last.cal.parameters.iter().find(|p| p.id.constant() == Some(applied.parameters[k]))
    };
    let at_end = (0..law.parameters.len()).find_map(|k| {
        let found = found(k).filter(|p| p.at_bound && !law.parameters[k].1.each)?;
        let (low, high) = found.bounds;
        let bound = if found.estimate.value - low < high - found.estimate.value { low } else { high };
        Some(Veto::ParameterAtEnd {
            name: law.parameters[k].0.clone(),
            bound: bound / found.factor,
            unit: found.unit.clone(),
        })
    });
    if at_end.is_some() {
        return at_end;
    }
    let estimate = |k: usize| found(k).map(|p| &p.estimate);
    let linear: Vec<usize> =
        law.linear_parameters().into_iter().filter(|&k| !law.parameters[k].1.each).collect();
    let (&first, rest) = linear.split_first()?;
    let zero = |k: usize| estimate(k).is_some_and(|e| e.ci95.0 <= 0.0 && e.ci95.1 >= 0.0);
    let named =
        |all: &[usize]| Veto::Undetermined(all.iter().map(|&k| law.parameters[k].0.clone()).collect());
    if linear.iter().all(|&k| zero(k)) {
        return Some(named(&linear));
    }
    let level = estimate(first)?.value.abs();
    let same_unit = |k: usize| law.parameters[k].1.unit == law.parameters[first].1.unit;
    let wide = |k: usize| !same_unit(k) || estimate(k).is_some_and(|e| e.ci95.1 - e.ci95.0 > level);
    (!law.simpler.is_empty() && !rest.is_empty() && rest.iter().all(|&k| zero(k) && wide(k)))
        .then(|| named(rest))
}

/// Two effects on one body whose forces cancel each other over most of the motion: together they are the
/// expansion of another law.
pub(crate) fn cancelling(last: &Fitted) -> Option<Cancelling> {
    let (model, system) = (&last.model, &last.model.system);
    let forces: Vec<(usize, phisindy_expr::Id)> =
        model.effects.iter().enumerate().filter_map(|(k, a)| Some((k, a.force?))).collect();
    if forces.len() < 2 {
        return None;
    }
    let nodes: Vec<_> = forces.iter().map(|(_, force)| *force).collect();
    let tape = Tape::compile(&system.graph, &system.arguments(), &nodes).ok()?;
    // Products of the forces, each with each, over the Fit records.
    let mut products = vec![vec![0.0; forces.len()]; forces.len()];
    for (r, record) in model.records.iter().enumerate().filter(|(_, d)| d.role == Role::Fit) {
        let motion = Motion::new(system, record, &model.smooth[r], r, &last.cal);
        let values = evaluated(&tape, &motion, &[], &[]);
        for i in (0..motion.samples()).filter(|&i| values.iter().all(|v| v[i].is_finite())) {
            for (a, row) in products.iter_mut().enumerate() {
                row.iter_mut().enumerate().for_each(|(b, sum)| *sum += values[a][i] * values[b][i]);
            }
        }
    }
    let acts = |k: usize| match &model.effects[k].effect.place.site {
        Site::Force { acts, .. } => acts.clone(),
        Site::Sensor(_) => vec![],
    };
    for (a, &(i, _)) in forces.iter().enumerate() {
        for (b, &(j, _)) in forces.iter().enumerate().skip(a + 1) {
            // The forces act on one body with these signs.
            let sign = acts(i).iter().find_map(|(body, own)| {
                acts(j).iter().find(|(other, _)| other == body).map(|(_, other)| (own * other).signum())
            });
            let Some(sign) = sign else { continue };
            let least = products[a][a].min(products[b][b]);
            let sum = products[a][a] + products[b][b] + 2.0 * sign * products[a][b];
            if sum < CANCELS * CANCELS * least {
                let law = |k: usize| PlacedLaw::of(&model.effects[k].effect);
                return Some(Cancelling { laws: (law(i), law(j)), left: (sum.max(0.0) / least).sqrt() });
            }
        }
    }
    None
}
