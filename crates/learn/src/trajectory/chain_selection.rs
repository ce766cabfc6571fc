//! Selection of terms on a chain of segments: a search among the subsets by the quadratic model of the cost,
//! in which start states follow along, each step of it confirmed by a refit.

use crate::decisions::{CHAIN_PAIRS, CHAIN_REFITS, RIVAL, RIVAL_REACH};
use crate::result::identified::PathPoint;
use crate::trajectory::description::descriptions;
use crate::trajectory::fit::{Context, Fit};
use crate::trajectory::quadratic::Quadratic;
use crate::trajectory::select::{Selection, negligible, price};
use phisindy_phys::System;
use rayon::prelude::*;

/// The criterion: the cost, the price of so many terms, and what it takes to write them down.
pub(crate) struct Criterion {
    inflation: f64,
    independent: f64,
    descriptions: Vec<f64>,
}

impl Criterion {
    /// With as many independent samples as a fit has.
    pub(crate) fn new(system: &System, fit: &Fit<'_>) -> Criterion {
        let (inflation, independent) = (fit.inflation(), fit.effective);
        Criterion { inflation, independent, descriptions: descriptions(system) }
    }

    fn of(&self, cost: f64, terms: &[usize]) -> f64 {
        let written: f64 = terms.iter().map(|&t| self.descriptions[t]).sum();
        cost / self.inflation + price(terms.len(), self.descriptions.len(), self.independent) + written
    }

    /// Of a fit with a noise of its own: twice the negative logarithm of its likelihood in the place of the
    /// cost.
    pub(crate) fn of_fit(&self, fit: &Fit<'_>) -> f64 {
        let samples = fit.weights.iter().flatten().flatten();
        let spread: f64 = samples.filter(|w| w.is_finite() && **w > 0.0).map(|w| -w.ln()).sum();
        self.of(fit.normal.cost + spread, &fit.problem.terms)
    }
}

/// Selects among all terms of the dictionary, from a chain with all of them or a part.
pub(crate) fn select_on_chain<'a>(context: &Context<'a>, first: Fit<'a>) -> Selection<'a> {
    let criterion = Criterion::new(context.system, &first);
    let of = |fit: &Fit<'_>| criterion.of(fit.normal.cost, &fit.problem.terms);
    let mut path = vec![PathPoint { terms: first.problem.terms.len(), criterion: of(&first), nrmse: None }];
    let (mut now, mut tried) = (first, Vec::new());
    let mut quadratic = whole_dictionary(context, &now);
    for _ in 0..CHAIN_REFITS {
        tried.push(now.problem.terms.clone());
        let Some(model) = &quadratic else { break };
        let Some(terms) = promising(model, &criterion, &now.problem.terms, &tried) else { break };
        let next = context.refit(&now, &terms);
        match next {
            Some(next) if of(&next) < of(&now) => {
                path.push(PathPoint { terms: terms.len(), criterion: of(&next), nrmse: None });
                now = next;
                quadratic = whole_dictionary(context, &now);
            }
            _ => tried.push(terms),
        }
    }
    while let Some(small) = negligible(&now) {
        let terms: Vec<usize> = now.problem.terms.iter().copied().filter(|&t| t != small).collect();
        let Some(fit) = context.refit(&now, &terms) else { break };
        now = fit;
    }
    Selection { fit: now, path }
}

/// The term with which the criterion is least worse, if it is so little worse that it is no evidence against
/// the term.
pub(crate) fn addition<'a>(context: &Context<'a>, now: &Fit<'a>) -> Option<(usize, f64)> {
    let (criterion, own) = (Criterion::new(context.system, now), &now.problem.terms);
    let model = whole_dictionary(context, now)?;
    let here = criterion.of(now.normal.cost, own);
    let outside = (0..model.len()).filter(|t| !own.contains(t));
    let promised = outside.map(|t| {
        let terms = changed(own, &[], &[t]);
        (t, criterion.of(model.least(&terms), &terms) - here)
    });
    let (term, promised) = promised.min_by(|a, b| a.1.total_cmp(&b.1))?;
    // The quadratic model may promise too little: a refit decides.
    if promised > RIVAL_REACH * RIVAL {
        return None;
    }
    let terms = changed(own, &[], &[term]);
    let fit = context.refit(now, &terms)?;
    let worse = (criterion.of(fit.normal.cost, &terms) - here).max(0.0);
    (worse < RIVAL).then_some((term, worse))
}

/// The quadratic model in the coefficients of all terms, where a fit of some of them has ended.
fn whole_dictionary(context: &Context<'_>, now: &Fit<'_>) -> Option<Quadratic> {
    let all: Vec<usize> = (0..context.system.terms.len()).collect();
    let problem = context.problem(&all, now)?;
    let own = now.problem.terms.len();
    let mut x = vec![0.0; all.len()];
    now.problem.terms.iter().zip(&now.x).for_each(|(&t, c)| x[t] = *c);
    x.extend(&now.x[own..]);
    let normal = problem.normal(&x, &now.weights).ok()?.reduced(all.len());
    Some(Quadratic::new(&normal, &x[..all.len()], &problem.bounds))
}

/// The best choice of terms near these ones that was not tried and promises a better criterion: first steps
/// down and up by one term and exchanges of two as long as they gain, then exchanges of pairs.
fn promising(
    model: &Quadratic,
    criterion: &Criterion,
    from: &[usize],
    tried: &[Vec<usize>],
) -> Option<Vec<usize>> {
    let value = |terms: &[usize]| criterion.of(model.least(terms), terms);
    let best = |choices: Vec<Vec<usize>>| -> Option<(f64, Vec<usize>)> {
        let untried: Vec<Vec<usize>> = choices.into_iter().filter(|c| !tried.contains(c)).collect();
        let values: Vec<f64> = untried.par_iter().map(|c| value(c)).collect();
        let k = (0..values.len()).min_by(|&a, &b| values[a].total_cmp(&values[b]))?;
        Some((values[k], untried.into_iter().nth(k)?))
    };
    let (here, mut now) = (value(from), from.to_vec());
    let mut least = here;
    loop {
        let mut next = best(neighbours(&now, model.len()));
        if next.as_ref().is_none_or(|(value, _)| *value >= least)
            && pairs(now.len(), model.len()) <= CHAIN_PAIRS
        {
            next = best(neighbours_of_neighbours(&now, model.len()));
        }
        match next {
            Some((value, terms)) if value < least => (least, now) = (value, terms),
            _ => break,
        }
    }
    (least < here).then_some(now)
}

/// Choices that differ by one term, or by one in the place of another.
fn neighbours(terms: &[usize], all: usize) -> Vec<Vec<usize>> {
    let outside: Vec<usize> = (0..all).filter(|t| !terms.contains(t)).collect();
    let mut out: Vec<Vec<usize>> = outside.iter().map(|&new| changed(terms, &[], &[new])).collect();
    for &gone in terms {
        out.push(changed(terms, &[gone], &[]));
        out.extend(outside.iter().map(|&new| changed(terms, &[gone], &[new])));
    }
    out
}

/// Choices in which up to two terms stand in the place of two others.
fn neighbours_of_neighbours(terms: &[usize], all: usize) -> Vec<Vec<usize>> {
    let outside: Vec<usize> = (0..all).filter(|t| !terms.contains(t)).collect();
    let of_two = |from: &[usize]| -> Vec<Vec<usize>> {
        let pairs = (0..from.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
        pairs.map(|(i, j)| vec![from[j], from[i]]).collect()
    };
    let up_to_two = |from: &[usize]| -> Vec<Vec<usize>> {
        [vec![vec![]], from.iter().map(|&t| vec![t]).collect(), of_two(from)].concat()
    };
    let (gone, new) = (up_to_two(terms), up_to_two(&outside));
    gone.iter().flat_map(|gone| new.iter().map(move |new| changed(terms, gone, new))).collect()
}

/// How many choices that are.
fn pairs(terms: usize, all: usize) -> usize {
    let up_to_two = |n: usize| 1 + n + n * n.saturating_sub(1) / 2;
    up_to_two(terms) * up_to_two(all - terms)
}

fn changed(terms: &[usize], gone: &[usize], new: &[usize]) -> Vec<usize> {
    let mut out: Vec<usize> = terms.iter().filter(|t| !gone.contains(t)).chain(new).copied().collect();
    out.sort_unstable();
    out
}
