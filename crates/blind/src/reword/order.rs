//! The same in another order.

use super::question::{Question, records as read};
use super::rewording::Reworded;
use crate::dice::Dice;
use phisindy_phys::spec::{ConstantSpec, Spec, Text};
use phisindy_phys::splice::quoted;

/// A map of texts, its last entry first.
fn backwards(pairs: &[(Text, Text)]) -> String {
    let entry = |(name, text): &(Text, Text)| format!("{}: {}", quoted(&name.value), quoted(&text.value));
    format!("{{ {} }}", pairs.iter().rev().map(entry).collect::<Vec<_>>().join(", "))
}

/// States, their rates, and inputs.
pub(super) fn states(question: Question, spec: &Spec, _: &mut Dice) -> Option<Reworded> {
    if spec.energy.is_some() {
        return None;
    }
    let mut question = question.set(&["states"], &backwards(&spec.states))?;
    question = question.set(&["known"], &backwards(&spec.known))?;
    if spec.inputs.len() > 1 {
        question = question.set(&["inputs"], &backwards(&spec.inputs))?;
    }
    Some(question.into())
}

/// Constants that are numbers.
pub(super) fn constants(question: Question, spec: &Spec, _: &mut Dice) -> Option<Reworded> {
    let entry = |(name, constant): &(Text, ConstantSpec)| match constant {
        ConstantSpec::Number { value, unit } => {
            let unit = quoted(unit.as_ref().map_or("", |unit| &unit.value));
            Some(format!("{}: ({:?}, {unit})", quoted(&name.value), value.value))
        }
        _ => None,
    };
    // A number without a unit takes any that fits; so it stays as it is.
    let united = |(_, constant): &(Text, ConstantSpec)| constant.unit().is_some();
    if spec.constants.len() < 2 || !spec.constants.iter().all(united) {
        return None;
    }
    let entries: Option<Vec<String>> = spec.constants.iter().rev().map(entry).collect();
    question.set(&["constants"], &format!("{{ {} }}", entries?.join(", "))).map(Reworded::from)
}

/// Candidates of each unknown part.
pub(super) fn candidates(question: Question, spec: &Spec, _: &mut Dice) -> Option<Reworded> {
    let each = spec.unknown.iter().map(|(_, unknown)| &unknown.candidates);
    let places: Vec<_> = each
        .flat_map(|all| all.iter().zip(all.iter().rev()).map(|(to, from)| (to.span, from.value.clone())))
        .collect();
    let moved = spec.unknown.iter().any(|(_, unknown)| unknown.candidates.len() > 1);
    moved.then(|| question.edited(places).into())
}

/// Columns of each file.
pub(super) fn columns(mut question: Question, _: &Spec, _: &mut Dice) -> Option<Reworded> {
    for sheet in question.sheets.values_mut() {
        sheet.heads.reverse();
        sheet.rows.iter_mut().for_each(|row| row.reverse());
    }
    Some(question.into())
}

/// Records.
pub(super) fn records(question: Question, spec: &Spec, _: &mut Dice) -> Option<Reworded> {
    let all: Vec<_> = read(spec).map(|record| record.span).collect();
    let text = |span: &phisindy_expr::Span| question.spec[span.range()].to_owned();
    let places = all.iter().zip(all.iter().rev()).map(|(to, from)| (*to, text(from))).collect();
    (all.len() > 1).then(|| question.edited(places).into())
}
