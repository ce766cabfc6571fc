//! What there is to say of a discovered force beside its formula: where it is known, what it is about zero,
//! which laws of the catalogue come nearest.

use crate::table::short;
use phisindy_gap::{DISCOVERED, Gap, ObservedRange, Step, Tried};
use phisindy_phys::LawEntry;

/// Most laws that are told as near.
const NEAREST: usize = 3;

/// The laws of the catalogue that leave the smallest gap where a force was discovered, nearest first.
pub(super) fn nearest<'a>(found: &'a Gap, step: &'a Step) -> impl Iterator<Item = &'a Tried> {
    let mut all: Vec<&Tried> = Vec::new();
    if step.effect.entry.id == DISCOVERED {
        all.extend(found.tried.iter().filter(|t| t.gap.is_some() && t.vetoed.is_none()));
        all.sort_by(|a, b| a.gap.unwrap_or(f64::NAN).total_cmp(&b.gap.unwrap_or(f64::NAN)));
    }
    all.into_iter().take(NEAREST)
}

/// The sentences about a discovered force; none for a law of the catalogue.
pub(crate) fn remarks(found: &Gap, step: &Step, catalogue: &[LawEntry]) -> Vec<String> {
    if step.effect.entry.id != DISCOVERED {
        return vec![];
    }
    let mut all = Vec::new();
    if !step.observed.is_empty() {
        let ranges: Vec<String> = step.observed.iter().map(range).collect();
        all.push(format!("known for {}; beyond that the formula is a guess", ranges.join(" and ")));
    }
    all.extend(step.expansion.as_ref().map(|terms| format!("about zero it is {terms} (SI)")));
    let name = |id: &str| {
        catalogue.iter().find(|e| e.id == id).map_or_else(|| id.to_owned(), |e| e.law.name.clone())
    };
    let near: Vec<String> = nearest(found, step)
        .filter_map(|t| {
            Some(format!("{} at {} (leaves a gap of {})", name(&t.at.law), t.at.at, short(three(t.gap?))))
        })
        .collect();
    if !near.is_empty() {
        all.push(format!("nearest laws of the catalogue: {}", near.join(", ")));
    }
    all
}

/// The run that tells a discovered force from formulas that do as well: one that goes farther.
pub(super) fn beyond(step: &Step) -> Option<String> {
    if step.effect.entry.id != DISCOVERED || step.observed.is_empty() {
        return None;
    }
    let far =
        |of: &ObservedRange| format!("|{}| > {}", of.quantity, in_unit(of.low.abs().max(of.high.abs()), of));
    let all: Vec<String> = step.observed.iter().map(far).collect();
    Some(format!("a run to {}", all.join(" or ")))
}

fn range(of: &ObservedRange) -> String {
    let low = short(three(of.low / of.factor));
    format!("{} from {low} to {}", of.quantity, in_unit(of.high, of))
}

/// A value with three digits and its unit.
fn in_unit(value: f64, of: &ObservedRange) -> String {
    let unit = if of.unit.is_empty() { String::new() } else { format!(" {}", of.unit) };
    format!("{}{unit}", short(three(value / of.factor)))
}

fn three(x: f64) -> f64 {
    format!("{x:.2e}").parse().unwrap_or(x)
}
