//! Doubts about a model that leaves only noise: an effect that evidence rules out, an effect whose numbers
//! the records do not determine, two effects whose forces cancel.

use crate::decisions::{CANCELS, CHANCE};
use crate::evaluate::evaluated;
use crate::evidence::{against, parameter_at_end};
use crate::model::{Applied, Fitted};
use crate::motion::Motion;
use crate::place::Site;
use crate::result::{Cancelling, PlacedLaw, Veto, Vetoed};
use phisindy_expr::Tape;
use phisindy_learn::{Effort, FoundParameter};
use phisindy_phys::spec::Role;

/// The effects of a fitted model that evidence rules out, or whose numbers the records do not determine, by
/// index. The intervals of the parameters must be known.
pub(crate) fn vetoed(last: &Fitted) -> Vec<(usize, Vetoed)> {
    let of = |(k, applied): (usize, &Applied)| {
        let why = against(last, &applied.effect).or_else(|| undetermined(last, applied))?;
        Some((k, Vetoed { law: PlacedLaw::of(&applied.effect), why, score: last.score.clone() }))
    };
    last.model.effects.iter().enumerate().filter_map(of).collect()
}

/// Whether an effect has numbers that its records may not determine: several of them.
pub(crate) fn may_be_undetermined(applied: &Applied) -> bool {
    applied.effect.entry.law.parameters.len() > 1
}

/// A law is determined if none of its parameters ends at a bound, where the data want to go beyond it, or has
/// an interval from bound to bound, and the interval of one of its coefficients excludes zero. A law that
/// contains a simpler one has the level of that one as its first coefficient; of the others at least one must
/// exclude zero.
fn undetermined(last: &Fitted, applied: &Applied) -> Option<Veto> {
    let law = &applied.effect.entry.law;
    let found = |k: usize| -> Option<&FoundParameter> {
        last.cal.parameters.iter().find(|p| p.id.constant() == Some(applied.parameters[k]))
    };
    if let Some(at_end) = parameter_at_end(last, applied, |found| found.at_bound) {
        return Some(at_end);
    }
    // An interval from one bound to the other is what was known before, and of an inner number with a standard error
    // above its value not even the order is known. A coefficient for which a free constant of the model can stand, as
    // the viscous part of a friction law beside a free damper, is theirs together: both are open. With memory no number
    // is such a coefficient, for the states of the law move by it.
    let own = |p: &FoundParameter| {
        let all = last.model.effects.iter().flat_map(|a| &a.parameters);
        p.id.constant().is_some_and(|c| all.into_iter().any(|own| *own == c))
    };
    let constants = last.cal.parameters.iter().filter(|p| p.id.constant().is_some() && !own(p));
    let shared = constants.into_iter().any(FoundParameter::reaches_both_bounds);
    let coefficients = if law.has_memory() { vec![] } else { law.linear_parameters() };
    let open = |&k: &usize| {
        let (p, is_inner) = (&law.parameters[k].1, !coefficients.contains(&k));
        let no_order = |f: &FoundParameter| {
            f.estimate.ci95.0 <= f.bounds.0 && f.estimate.std_error > f.estimate.value.abs()
        };
        let unseen = |f: &FoundParameter| f.reaches_both_bounds() || (is_inner && no_order(f));
        let excused = p.each || p.whole || (shared && !is_inner);
        !excused && found(k).is_some_and(unseen)
    };
    if let Some(k) = (0..law.parameters.len()).find(open) {
        return Some(Veto::NotSeen(law.parameters[k].0.clone()));
    }
    let estimate = |k: usize| found(k).map(|p| &p.estimate);
    let linear: Vec<usize> =
        law.linear_parameters().into_iter().filter(|&k| !law.parameters[k].1.each).collect();
    let (_, rest) = linear.split_first()?;
    let zero = |k: usize| estimate(k).is_some_and(|e| e.ci95.0 <= 0.0 && e.ci95.1 >= 0.0);
    let named =
        |all: &[usize]| Veto::Undetermined(all.iter().map(|&k| law.parameters[k].0.clone()).collect());
    if linear.iter().all(|&k| zero(k)) {
        return Some(named(&linear));
    }
    // A coefficient of either sign is a correction of the level, others are levels of their own.
    let rest: Vec<usize> = rest.iter().copied().filter(|&k| law.parameters[k].1.within.0 < 0.0).collect();
    (!law.simpler.is_empty() && !rest.is_empty() && rest.iter().all(|&k| zero(k))).then(|| named(&rest))
}

/// Whether the data press a constant of the model against its bound: beyond it the same laws leave less by
/// more than chance. Then these laws are not what is there, or the bound is wrong. Where the truth lies at the
/// bound half of all fits end there, and nothing presses.
pub(crate) fn pressed(last: &Fitted, noise: &[Vec<f64>]) -> bool {
    let mut model = last.settled();
    let own = |k: usize| last.model.effects.iter().any(|a| a.parameters.contains(&k));
    let at_bound = last.cal.parameters.iter().filter(|p| p.at_bound).filter_map(|p| p.id.constant());
    let held: Vec<usize> = at_bound.filter(|&k| !own(k)).collect();
    for &k in &held {
        let p = &mut model.system.parameters[k];
        let width = p.within.1 - p.within.0;
        let low = p.start - p.within.0 < p.within.1 - p.start;
        p.within = if low { (p.within.0 - width, p.within.1) } else { (p.within.0, p.within.1 + width) };
    }
    let fall = |free: &Fitted| last.cal.samples as f64 * (last.score.fit.powi(2) - free.score.fit.powi(2));
    let freed = if held.is_empty() { None } else { Fitted::new(model, noise, Effort::Plain).ok() };
    freed.is_some_and(|free| fall(&free) > held.len() as f64 * CHANCE.powi(2))
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
        _ => vec![],
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_models::{effect, model, with_effects};

    const RUINA: &str = include_str!("../../phys/laws/dieterich-ruina.ron");
    const STOP: &str = include_str!("../../phys/laws/one-sided-stop.ron");
    const CUBIC: &str = include_str!("../../phys/laws/cubic-stiffness.ron");
    const SPRING: &str = include_str!("../../phys/laws/stiffness.ron");

    /// An oscillator that lacks `truth`, with these laws at its velocity (start values in SI).
    fn with(truth: &str, laws: &[(&str, &str, &[f64])]) -> Fitted {
        let (base, noise) = model(&format!(
            r#"(states: {{ "x": "m", "v": "m/s" }}, constants: {{ "k": (1.0, "N/m"), "m": (1.0, "kg"), "c": (0.1, "N*s/m"), "F0": (1.0, "N"), "W": (0.7, "rad/s") }},
            known: {{ "x": "v", "v": "(-k*x - c*v + F0*cos(W*t))/m" }},
            inertia: {{ "v": "m" }}, unknown: {{}}, data: [ Synthetic(truth: {{ "v": "{truth}" }}, start: {{ "x": 1.0, "v": 0.0 }}, duration: 40.0, step: 0.05, noise: Additive(0.05), seed: 1) ])"#
        ));
        let effects: Vec<_> =
            laws.iter().map(|(id, law, start)| effect(&base, id, law, "v", start)).collect();
        with_effects(&base, &effects, &noise)
    }

    /// Plain friction does not determine what a richer law adds to it; a stop that is hardly touched has no
    /// stiffness.
    #[test]
    fn numbers_that_a_record_does_not_determine_are_told() {
        let names = |fitted: &Fitted| match vetoed(fitted).pop() {
            Some((0, Vetoed { why: Veto::Undetermined(names), .. })) => names,
            other => panic!("{other:?}"),
        };
        let friction = with("-0.3*sgn(v)", &[("dieterich-ruina", RUINA, &[0.3, 0.05, 0.05])]);
        assert_eq!(names(&friction), ["a", "b"]);
        let falling = with(
            "-(0.3 + 0.07*ln((|v|+1e-6)/0.003) + 0.09*ln(0.022+0.003/(|v|+1e-6)))*sgn(v)",
            &[("dieterich-ruina", RUINA, &[0.3, 0.07, 0.09])],
        );
        assert_eq!(vetoed(&falling), []);
        let stop = with("0*x", &[("one-sided-stop", STOP, &[0.5, 1.0])]);
        assert_eq!(vetoed(&stop).len(), 1, "{:?}", vetoed(&stop));
    }

    /// A spring less and a cubic spring more is the expansion of another spring.
    #[test]
    fn laws_that_cancel_are_told() {
        let laws: &[(&str, &str, &[f64])] =
            &[("stiffness", SPRING, &[-0.1]), ("cubic-stiffness", CUBIC, &[0.1])];
        assert!(cancelling(&with("-0.4*x^3 + 0.1*x", laws)).is_none());
        let told = cancelling(&with("0.3*x - 0.08*x^3", laws));
        assert!(told.is_some_and(|c| c.left < CANCELS));
    }
}
