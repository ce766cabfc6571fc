//! Whether the laws that a spec names are in the data. A law cannot leave the model as a term does, and one
//! whose level is nothing, or that follows the noise, fits as well as none: the known part alone is fitted
//! again, and the laws must lower its cost by the price of their numbers.
//!
//! The price is that of the terms, `k ln n`. It pays for a number that was searched for, too: the best of the
//! `n/2` frequencies of a record lowers the cost by about `2 ln(n/2)` where nothing is there, and a force
//! with a frequency has three numbers (J. H. Horne and S. L. Baliunas, Astrophys. J. 302 (1986) 757-763).

use crate::decisions::{COMPLETE, FINE_MINIMUM};
use crate::least_squares::Limits;
use crate::result::parameter::FoundParameter;
use crate::result::record_fit::RecordFit;
use crate::result::verdict::Rejection;
use crate::trajectory::fit::Fit;
use crate::trajectory::problem::{Meaning, Problem};
use crate::trajectory::select::price;
use phisindy_phys::spec::Role;
use phisindy_phys::{Record, System};

/// Why not to believe in the laws of a model that otherwise holds: they are not worth their numbers, or one
/// of them is at the end of what it allows while something is left. `without` is the system without them.
pub(crate) fn against_laws(
    without: &System,
    fit: &Fit<'_>,
    parameters: &[FoundParameter],
    fits: &[RecordFit],
    only_noise: bool,
) -> Option<Rejection> {
    let complete = only_noise || fits.iter().filter(|f| f.role == Role::Fit).all(|f| f.worst() < COMPLETE);
    let (gain, numbers) = gain(without, fit)?;
    if gain / fit.inflation() < price(numbers, numbers, fit.effective) {
        return Some(if complete { Rejection::NothingMissing } else { Rejection::NoBetter });
    }
    // A number of each record, such as a phase, says nothing of the law.
    let of_law = |p: &&FoundParameter| {
        let name = p.id.constant().map(|k| &fit.problem.system.parameters[k].name);
        p.id.owner.is_none() && name.is_some_and(|name| without.parameters.iter().all(|q| q.name != *name))
    };
    let end = parameters.iter().filter(of_law).find(|p| p.at_bound && !complete)?;
    let value = end.estimate.value / end.factor;
    Some(Rejection::LawAtBound { number: end.id.clone(), value, unit: end.unit.clone() })
}

/// By how much the laws lower the cost, and how many numbers that takes; `None` where the known part alone
/// cannot be run.
fn gain(without: &System, fit: &Fit<'_>) -> Option<(f64, usize)> {
    let (with, of) = (&fit.problem, fit.problem.system);
    let records: Vec<Record> = with.records.iter().map(|r| of_system(r, without, of)).collect();
    let refs: Vec<&Record> = records.iter().collect();
    let mut problem = Problem::new(without, &with.terms, &refs, &fit.pieces).ok()?;
    problem.belief = with.belief;
    let n = without.states.len();
    problem.continuity = with.continuity.as_ref().map(|jumps| jumps[..n].to_vec());
    let mut x = problem.guess(&fit.x[..with.terms.len()], None, &records);
    let meanings = with.meanings();
    for (k, meaning) in problem.meanings().into_iter().enumerate() {
        let same = match meaning {
            Meaning::Parameter(p, record) => {
                let name = &without.parameters[p].name;
                Meaning::Parameter(of.parameters.iter().position(|q| q.name == *name)?, record)
            }
            // Internal states of laws stand between the states and the outputs.
            Meaning::Sensor(r, k, which) if k >= n => Meaning::Sensor(r, k - n + of.states.len(), which),
            Meaning::Start => continue,
            other => other,
        };
        x[k] = fit.x[meanings.iter().position(|m| *m == same)?];
    }
    for (to, from) in problem.segments.iter().zip(&with.segments) {
        x[to.start..to.start + n].copy_from_slice(&fit.x[from.start..from.start + n]);
    }
    let all = of.states.len();
    if let Some(force) = &fit.force {
        let (weights, _) = problem.follow(&x, &fit.noise, force)?;
        let alone = problem.minimise(&mut x, &weights, Limits::of(FINE_MINIMUM)).ok()?;
        return Some((alone.cost - fit.normal.cost, numbers(meanings, &problem)));
    }
    let shared = |w: &Vec<Vec<f64>>| w[..n].iter().chain(&w[all..]).cloned().collect();
    let weights: Vec<Vec<Vec<f64>>> = fit.weights.iter().map(shared).collect();
    let alone = problem.minimise(&mut x, &weights, Limits::of(FINE_MINIMUM)).ok()?;
    Some((alone.cost - fit.normal.cost, numbers(meanings, &problem)))
}

/// How many numbers the laws have.
fn numbers(with: Vec<Meaning>, without: &Problem<'_>) -> usize {
    let moved = |all: Vec<Meaning>| all.into_iter().filter(|m| matches!(m, Meaning::Parameter(..))).count();
    moved(with).saturating_sub(moved(without.meanings()))
}

/// A record without the internal states of laws, which stand behind the other states.
fn of_system(record: &Record, without: &System, with: &System) -> Record {
    let (n, all) = (without.states.len(), with.states.len());
    let mut record = record.clone();
    record.columns.drain(n..all);
    record.start.truncate(n);
    record.sensors.drain(n..all);
    record
}
