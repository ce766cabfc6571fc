//! What a spec may have mixed up: the values of two constants, such as two masses, a column that is
//! measured against another body and not against the ground (or the other way round), the sign of a column or an input.

use crate::decisions::EXCHANGED;
use crate::model::{Fitted, TrialModel, current};
use crate::result::{Named, SpecMistake};
use phisindy_learn::Effort;
use phisindy_phys::Record;
use phisindy_phys::spec::{ConstantSpec, Number, Spec};
use rayon::prelude::*;
use std::sync::Arc;

/// The exchange that explains the data, or leaves a small part of the gap, without effects or with those of
/// `last`; the best one, `None` if there is none.
pub(crate) fn spec_mistake(base: &Fitted, last: &Fitted, noise: &[Vec<f64>]) -> Option<SpecMistake> {
    let effects = current(last);
    let plain = base.model.without_effects();
    let changed: Vec<(SpecMistake, TrialModel)> =
        exchanged(&plain).into_iter().chain(shifted(&plain)).chain(turned(&plain)).collect();
    let lists = if effects.is_empty() { vec![vec![]] } else { vec![vec![], effects] };
    let trials: Vec<(&SpecMistake, TrialModel)> = changed
        .iter()
        .flat_map(|(what, model)| {
            lists.iter().filter_map(move |list| Some((what, model.with_all(list).ok()?)))
        })
        .collect();
    let limit = EXCHANGED * last.score.gap();
    let cost = last.settled().segment_cost(noise, 1)?;
    let fitted = trials.into_par_iter().filter_map(|(what, model)| {
        let promising = model.segment_cost(noise, 1)? < cost;
        let fitted = if promising { Fitted::new(model, noise, Effort::Plain).ok()? } else { return None };
        let gap = fitted.score.gap();
        let much_better = fitted.score.explains() && !last.score.explains() || gap < limit;
        (much_better && fitted.follows()).then_some((gap, what))
    });
    let all: Vec<(f64, &SpecMistake)> = fitted.collect();
    all.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).map(|(gap, what)| what.clone().with_gap(gap))
}

/// The model with the values of each two fixed constants of one unit exchanged.
fn exchanged(base: &TrialModel) -> Vec<(SpecMistake, TrialModel)> {
    let spec = &base.given.spec;
    let fixed: Vec<(usize, &Number, Option<&str>)> = spec
        .constants
        .iter()
        .enumerate()
        .filter_map(|(k, (_, constant))| match constant {
            ConstantSpec::Number { value, unit } => Some((k, value, unit.as_ref().map(|u| u.value.as_str()))),
            _ => None,
        })
        .collect();
    let mut all = Vec::new();
    for (i, (a, one, unit)) in fixed.iter().enumerate() {
        for (b, other, _) in
            fixed[i + 1..].iter().filter(|(_, other, own)| own == unit && other.value != one.value)
        {
            let mut swapped: Spec = spec.clone();
            for (at, value) in [(*a, *other), (*b, *one)] {
                if let ConstantSpec::Number { value: own, .. } = &mut swapped.constants[at].1 {
                    own.value = value.value;
                }
            }
            let names = (spec.constants[*a].0.value.clone(), spec.constants[*b].0.value.clone());
            all.extend(
                base.variant(swapped).map(|model| (SpecMistake::Constants { names, gap: 0.0 }, model)),
            );
        }
    }
    all
}

/// The model with each column plus or minus each other one of its unit: as if the column were measured
/// against that body, or against the ground where the state is relative.
fn shifted(base: &TrialModel) -> Vec<(SpecMistake, TrialModel)> {
    let states = &base.system.states;
    let mut all = Vec::new();
    for k in 0..states.len() {
        for j in (0..states.len()).filter(|&j| j != k && states[j].unit == states[k].unit) {
            for (sign, relative) in [(1.0, true), (-1.0, false)] {
                let mut model = base.clone();
                let shift = |record: &mut Record| -> Option<()> {
                    let other = record.columns[j].clone()?;
                    let own = record.columns[k].as_mut()?;
                    own.iter_mut().zip(other).for_each(|(x, other)| *x += sign * other);
                    Some(())
                };
                let records = Arc::make_mut(&mut model.records).iter_mut().try_for_each(shift);
                let smooth = Arc::make_mut(&mut model.smooth).iter_mut().try_for_each(shift);
                // A state that is the rate of a shifted one is started anew from its own column only.
                if records.is_none() || smooth.is_none() {
                    continue;
                }
                let of = Named { record: base.records[0].name.clone(), column: states[k].name.clone() };
                all.push((
                    SpecMistake::Column { of, other: states[j].name.clone(), relative, gap: 0.0 },
                    model,
                ));
            }
        }
    }
    all
}

/// The model with each input, and each column beside others, of the other sign.
fn turned(base: &TrialModel) -> Vec<(SpecMistake, TrialModel)> {
    let system = &base.system;
    let of = |name: &str, turn: &dyn Fn(&mut Record)| {
        let mut model = base.clone();
        Arc::make_mut(&mut model.records).iter_mut().for_each(turn);
        Arc::make_mut(&mut model.smooth).iter_mut().for_each(turn);
        (SpecMistake::Sign { of: name.to_owned(), gap: 0.0 }, model)
    };
    let input = |i: usize| of(&system.inputs[i].name, &|r| r.inputs[i] = r.inputs[i].rescaled(0.0, -1.0));
    let measured = |k: &usize| base.records.iter().any(|r| r.columns[*k].is_some());
    let columns: Vec<usize> = (0..system.columns()).filter(measured).collect();
    let negative = |column: &mut Vec<f64>| column.iter_mut().for_each(|x| *x = -*x);
    let column = |&k: &usize| {
        // What is known of its rate is known from this column, unless that one is measured too.
        let rate = system.states.get(k).and_then(|s| s.velocity).filter(|v| !measured(v));
        let both = [Some(k), rate];
        let turn = |r: &mut Record| {
            let own = both.into_iter().flatten();
            own.for_each(|k| r.columns[k].as_mut().into_iter().for_each(negative));
        };
        of(system.measured(k).0, &turn)
    };
    // The only column of a driven rig is the other side of its input.
    let apart = columns.len() > 1 || system.inputs.is_empty();
    (0..system.inputs.len()).map(input).chain(columns.iter().filter(|_| apart).map(column)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_models::{fitted, model};

    /// Two masses between springs; the spec has `m1` and `m2`, the rig one force more.
    fn chain(m1: f64, m2: f64, truth: &str) -> (TrialModel, Vec<Vec<f64>>) {
        model(&format!(
            r#"(states: {{ "x1": "m", "v1": "m/s", "x2": "m", "v2": "m/s" }},
            constants: {{ "m1": ({m1:?}, "kg"), "m2": ({m2:?}, "kg"), "k": (30.0, "N/m"), "F": (1.0, "N") }},
            known: {{ "x1": "v1", "v1": "(-k*x1 + k*(x2-x1) + F*cos(3*t))/m1", "x2": "v2", "v2": "-k*(x2-x1)/m2" }}, unknown: {{}},
            data: [ Synthetic(truth: {{ {truth} }}, start: {{ "x1": 0.3, "v1": 0.0, "x2": -0.2, "v2": 0.0 }}, duration: 12.0, step: 0.02,
                noise: Additive(0.01), seed: 1, measure: ["x1", "x2"]) ])"#
        ))
    }

    #[test]
    fn two_masses_that_are_exchanged_are_told() {
        let (right, noise) = chain(1.0, 2.5, "");
        let right = fitted(right, &noise);
        assert_eq!(spec_mistake(&right, &right, &noise), None);
        // The rig has the masses 1 and 2.5, the spec 2.5 and 1.
        let (wrong, noise) = chain(
            2.5,
            1.0,
            r#""v1": "(-k*x1 + k*(x2-x1) + F*cos(3*t))*(1/1.0-1/2.5)", "v2": "-k*(x2-x1)*(1/2.5-1/1.0)""#,
        );
        let wrong = fitted(wrong, &noise);
        let found = spec_mistake(&wrong, &wrong, &noise);
        let Some(SpecMistake::Constants { names, gap }) = found else { panic!("{found:?}") };
        assert_eq!((names.0.as_str(), names.1.as_str()), ("m1", "m2"));
        assert!(gap < 1.2, "{gap}");
    }

    #[test]
    fn a_relative_column_is_told() {
        let (mut model, noise) = chain(1.0, 2.5, "");
        for records in [&mut model.records, &mut model.smooth] {
            let record = &mut Arc::make_mut(records)[0];
            let ground = record.columns[0].clone().expect("a column");
            let column = record.columns[2].as_mut().expect("a column");
            column.iter_mut().zip(ground).for_each(|(x2, x1)| *x2 -= x1);
        }
        let wrong = fitted(model, &noise);
        let found = spec_mistake(&wrong, &wrong, &noise);
        let Some(SpecMistake::Column { of, other, relative: true, .. }) = found else { panic!("{found:?}") };
        assert_eq!((of.column.as_str(), other.as_str()), ("x2", "x1"));
    }

    #[test]
    fn a_sign_is_told() {
        let driven = |sign: &str| {
            model(&format!(
                r#"(states: {{ "x": "m", "v": "m/s" }}, inputs: {{ "F": "N" }}, constants: {{ "m": (1.0, "kg"), "k": (30.0, "N/m"), "c": (0.5, "N*s/m") }},
                known: {{ "x": "v", "v": "(F - c*v - k*x)/m" }}, unknown: {{}},
                data: [ Synthetic(truth: {{ "v": "{sign}" }}, start: {{ "x": 0.0, "v": 0.0 }}, duration: 12.0, step: 0.02,
                    inputs: {{ "F": Multisine(amplitude: 5.0, band: (0.2, 2.0), count: 9) }}, noise: Additive(0.01), seed: 1, measure: ["x"]) ])"#
            ))
        };
        let (right, noise) = driven("0");
        let right = fitted(right, &noise);
        assert_eq!(spec_mistake(&right, &right, &noise), None);
        let (wrong, noise) = driven("-2*F");
        let wrong = fitted(wrong, &noise);
        let found = spec_mistake(&wrong, &wrong, &noise);
        assert!(matches!(&found, Some(SpecMistake::Sign { of, .. }) if of == "F"), "{found:?}");
    }
}
