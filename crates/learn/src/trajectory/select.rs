//! Selection of terms from the dictionary.
//!
//! Terms leave and enter by the extended information criterion (Chen and Chen, Biometrika 95 (2008) 759-771)
//! `cost / inflation + k ln n + 2 ln C(p, k)`: the last term pays for the search among the subsets, and
//! correlated residuals count as few samples. The quadratic model of the cost proposes each step of the
//! search, a refit confirms it. Terms too small to matter are removed.

use crate::decisions::{
    HOPELESS, INSISTENT_RISE, NEW_PAIR, NEW_PART, PRACTICAL_SHARE, RIVAL, RIVAL_REACH, RIVALS,
    SELECTION_ROUNDS, TRIED_CHANGES,
};
use crate::input_noise;
use crate::least_squares::Normal;
use crate::linear::covariance;
use crate::result::identified::PathPoint;
use crate::trajectory::error_bars::ErrorBars;
use crate::trajectory::fit::{Context, Fit};
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};

/// The price of `k` terms out of `p`, for `n` independent samples.
pub(crate) fn price(k: usize, p: usize, n: f64) -> f64 {
    let choose: f64 = (0..k).map(|i| ((p - i) as f64 / (i + 1) as f64).ln()).sum();
    k as f64 * n.max(std::f64::consts::E).ln() + 2.0 * choose
}

/// A fit after selection, and the path of the selection.
pub(crate) struct Selection<'a> {
    pub(crate) fit: Fit<'a>,
    pub(crate) path: Vec<PathPoint>,
}

/// Selects among `all` terms, from a fit of them or of a part of them. Choices in `hopeless` are not tried
/// again; those found hopeless here are added to it.
pub(crate) fn select<'a>(
    context: &Context<'a>,
    first: Fit<'a>,
    all: &[usize],
    hopeless: &mut Vec<Vec<usize>>,
) -> Selection<'a> {
    let (n, inflation, p) = (first.effective, first.inflation(), all.len());
    let criterion = |cost: f64, k: usize| cost / inflation + price(k, p, n);
    let mut path: Vec<PathPoint> = Vec::new();

    // The whole way down on the quadratic model shows error against number of terms, and where to start.
    let k = first.problem.terms.len();
    let down = elimination(&first);
    let mut cost = first.normal.cost;
    let mut best = (criterion(cost, k), k);
    path.push(PathPoint { terms: k, criterion: best.0, nrmse: None });
    for (gone, (_, rise)) in down.iter().enumerate() {
        cost += rise;
        let left = k - gone - 1;
        let value = criterion(cost, left);
        path.push(PathPoint { terms: left, criterion: value, nrmse: None });
        if value < best.0 {
            best = (value, left);
        }
    }
    let dropped: Vec<usize> = down.iter().take(k - best.1).map(|&(t, _)| t).collect();
    let kept: Vec<usize> = first.problem.terms.iter().copied().filter(|t| !dropped.contains(t)).collect();
    let mut now = if dropped.is_empty() { first } else { context.refit(&first, &kept).unwrap_or(first) };
    let mut tried: Vec<Vec<usize>> = vec![now.problem.terms.clone()];
    let mut changes = neighbours(context, &now, all, &criterion);
    for _ in 0..SELECTION_ROUNDS {
        let Some(next) = promising(context, &now, &changes, &tried) else { break };
        tried.push(next.problem.terms.clone());
        let value = criterion(next.normal.cost, next.problem.terms.len());
        if value < criterion(now.normal.cost, now.problem.terms.len()) {
            path.push(PathPoint { terms: next.problem.terms.len(), criterion: value, nrmse: None });
            now = next;
            changes = neighbours(context, &now, all, &criterion);
        }
    }
    now = pruned(context, now, &criterion, hopeless);
    while let Some(small) = negligible(&now) {
        let terms: Vec<usize> = now.problem.terms.iter().copied().filter(|&t| t != small).collect();
        match context.refit(&now, &terms) {
            Some(fit) => now = fit,
            None => break,
        }
    }
    Selection { fit: context.resettle(now), path }
}

/// Backward elimination on the quadratic model of the cost at the minimum: terms in the order in which they
/// leave, each with the rise of the cost. Everything else that was fitted follows along.
fn elimination(fit: &Fit<'_>) -> Vec<(usize, f64)> {
    let p = fit.problem.terms.len();
    let full = covariance(&fit.normal.matrix);
    let mut c: Vec<Vec<f64>> = (0..p).map(|i| (0..p).map(|j| full[(i, j)]).collect()).collect();
    let mut x: Vec<f64> = fit.x[..p].to_vec();
    let mut alive: Vec<usize> = (0..p).collect();
    let mut out = Vec::new();
    while !alive.is_empty() {
        let rise = |k: usize| if c[k][k].is_finite() && c[k][k] > 0.0 { x[k] * x[k] / c[k][k] } else { 0.0 };
        let &k = alive.iter().min_by(|&&a, &&b| rise(a).total_cmp(&rise(b))).expect("not empty");
        out.push((fit.problem.terms[k], rise(k)));
        alive.retain(|&a| a != k);
        if c[k][k].is_finite() && c[k][k] > 0.0 {
            let (row, pivot, value) = (c[k].clone(), c[k][k], x[k]);
            for &i in &alive {
                x[i] -= row[i] * value / pivot;
                for &j in &alive {
                    c[i][j] -= row[i] * row[j] / pivot;
                }
            }
        }
    }
    out
}

/// A change of the terms: what they are then, the cost that is promised, and where new ones begin.
#[derive(Debug)]
struct Change {
    terms: Vec<usize>,
    cost: f64,
    /// A term that stands in the place of another begins at its promised coefficient: at 0 the motion is another one.
    new: Vec<(usize, f64)>,
}

/// Changes by one term (or a pair that only helps together) that promise a better criterion, best first.
/// Scores come from one evaluation of the full dictionary at the present solution.
fn neighbours(
    context: &Context<'_>,
    now: &Fit<'_>,
    all: &[usize],
    criterion: &impl Fn(f64, usize) -> f64,
) -> Vec<Change> {
    let mut changes: Vec<Change> = Vec::new();
    for (gone, rise) in elimination(now).into_iter().take(1) {
        let terms = now.problem.terms.iter().copied().filter(|&t| t != gone).collect();
        changes.push(Change { terms, cost: now.normal.cost + rise, new: vec![] });
    }
    for (added, fall) in scores(context, now, all) {
        let mut terms: Vec<usize> = now.problem.terms.iter().copied().chain(added.iter().copied()).collect();
        terms.sort_unstable();
        changes.push(Change { terms, cost: now.normal.cost - fall, new: vec![] });
    }
    changes.extend(swaps(context, now, all));
    let value = |change: &Change| criterion(change.cost, change.terms.len());
    let here = criterion(now.normal.cost, now.problem.terms.len());
    changes.retain(|change| value(change) < here);
    changes.sort_by(|a, b| value(a).total_cmp(&value(b)));
    changes
}

/// The most promising change that was not tried yet, refitted.
fn promising<'a>(
    context: &Context<'a>,
    now: &Fit<'a>,
    changes: &[Change],
    tried: &[Vec<usize>],
) -> Option<Fit<'a>> {
    changes.iter().filter(|change| !tried.contains(&change.terms)).take(TRIED_CHANGES).find_map(|change| {
        let look = context.trial_fit(now, &change.terms, &change.new)?;
        context.refit(&look, &change.terms)
    })
}

/// Simpler models beyond a barrier of the cost, which the quadratic model does not show: for each equation
/// with several terms, each term alone and all but each pair are tried. Trials run in parallel; the first
/// better one in their order is taken, whatever the number of threads.
fn pruned<'a>(
    context: &Context<'a>,
    mut now: Fit<'a>,
    criterion: &(impl Fn(f64, usize) -> f64 + Sync),
    hopeless: &mut Vec<Vec<usize>>,
) -> Fit<'a> {
    for state in 0..context.system.states.len() {
        let of_state = |fit: &Fit<'_>| -> Vec<usize> {
            fit.problem.terms.iter().copied().filter(|&t| context.system.terms[t].state == state).collect()
        };
        let own = of_state(&now);
        if own.len() < 2 {
            continue;
        }
        let mut simpler: Vec<Vec<usize>> = own.iter().map(|&t| vec![t]).collect();
        if own.len() > 3 {
            for i in 0..own.len() {
                simpler.extend(
                    (0..i).map(|j| own.iter().copied().filter(|t| *t != own[i] && *t != own[j]).collect()),
                );
            }
        }
        let mut left = &simpler[..];
        loop {
            let present = of_state(&now);
            let here = criterion(now.normal.cost, now.problem.terms.len());
            let with = |keep: &[usize]| -> Vec<usize> {
                let stays = |t: &usize| !present.contains(t) || keep.contains(t);
                now.problem.terms.iter().copied().filter(stays).collect()
            };
            let far: Vec<AtomicBool> = left.iter().map(|_| AtomicBool::new(false)).collect();
            let better = |(k, keep): (usize, &Vec<usize>)| {
                if keep.len() >= present.len() || !keep.iter().all(|t| present.contains(t)) {
                    return None;
                }
                let terms = with(keep);
                if hopeless.contains(&terms) {
                    return None;
                }
                let look = context.trial_fit(&now, &terms, &[]);
                let near = look.filter(|look| look.normal.cost <= HOPELESS * now.normal.cost);
                far[k].store(near.is_none(), Ordering::Relaxed);
                near.filter(|look| criterion(look.normal.cost, terms.len()) < here).map(|look| (k, look))
            };
            let Some((k, look)) = left.par_iter().enumerate().find_map_first(better) else {
                // All were tried, whatever the number of threads.
                let found = left.iter().zip(&far).filter(|(_, far)| far.load(Ordering::Relaxed));
                hopeless.extend(found.map(|(keep, _)| with(keep)));
                break;
            };
            now = context.refit(&look, &look.problem.terms).unwrap_or(look);
            left = &left[k + 1..];
        }
    }
    now
}

/// All candidates at the present solution: their terms, the unknowns, and the quadratic model of the cost.
/// `None` if there are no others, or they cannot be simulated.
fn quadratic_model<'a>(
    context: &Context<'a>,
    now: &Fit<'a>,
    all: &[usize],
) -> Option<(Vec<usize>, Vec<f64>, Normal)> {
    let mut terms: Vec<usize> = all.iter().chain(&now.problem.terms).copied().collect();
    terms.sort_unstable();
    terms.dedup();
    if terms.len() == now.problem.terms.len() {
        return None;
    }
    let problem = context.problem(&terms, now)?;
    // The same point: unknowns after the coefficients are laid out alike.
    let mut x = vec![0.0; problem.unknowns];
    for (i, t) in terms.iter().enumerate() {
        x[i] = now.problem.terms.iter().position(|u| u == t).map_or(0.0, |j| now.x[j]);
    }
    x[terms.len()..].copy_from_slice(&now.x[now.problem.terms.len()..]);
    let normal = problem.normal(&x, &now.weights).ok()?;
    if problem.chained {
        // The start states follow each change alike.
        x.truncate(terms.len());
        let normal = normal.reduced(x.len());
        return Some((terms, x, normal));
    }
    Some((terms, x, normal))
}

/// For each term of the model and each one of the same equation outside of it: the terms with the one in the
/// place of the other, as the quadratic model promises. A better model may be two steps away, each of which is worse.
fn swaps<'a>(context: &Context<'a>, now: &Fit<'a>, all: &[usize]) -> Vec<Change> {
    let Some((terms, x, normal)) = quadratic_model(context, now, all) else { return vec![] };
    let (a, system) = (&normal.matrix, context.system);
    let inside = |i: &usize| now.problem.terms.contains(&terms[*i]);
    let mut out = Vec::new();
    for gone in (0..terms.len()).filter(inside) {
        // The others are refitted.
        let stays: Vec<usize> =
            (0..x.len()).filter(|i| *i != gone && (*i >= terms.len() || inside(i))).collect();
        let inner = covariance(&faer::Mat::from_fn(stays.len(), stays.len(), |i, j| a[(stays[i], stays[j])]));
        let followed = |column: &dyn Fn(usize) -> f64, row: usize| -> f64 {
            let along = |i: usize| {
                let seen = (0..stays.len()).filter(|&j| inner[(i, j)].is_finite());
                seen.map(|j| inner[(i, j)] * column(stays[j])).sum::<f64>()
            };
            (0..stays.len()).map(|i| a[(row, stays[i])] * along(i)).sum()
        };
        let left = |i: usize, j: usize| a[(i, j)] - followed(&|s| a[(s, j)], i);
        let slope = |i: usize| normal.gradient[i] - followed(&|s| normal.gradient[s], i);
        let less = -x[gone];
        let without = normal.cost + 2.0 * slope(gone) * less + left(gone, gone) * less * less;
        let same = |i: &usize| system.terms[terms[*i]].state == system.terms[terms[gone]].state;
        for new in (0..terms.len()).filter(|i| !inside(i)).filter(same) {
            let (own, pull) = (left(new, new), slope(new) + left(new, gone) * less);
            let (low, high) = system.terms[terms[new]].within;
            if own.is_nan() || own <= NEW_PART * a[(new, new)] || !(low..=high).contains(&(-pull / own)) {
                continue;
            }
            let mut with: Vec<usize> =
                now.problem.terms.iter().copied().filter(|t| *t != terms[gone]).chain([terms[new]]).collect();
            with.sort_unstable();
            let new = vec![(terms[new], -pull / own)];
            out.push(Change { terms: with, cost: without - pull * pull / own, new });
        }
    }
    out
}

/// Choices of as many terms that the data describe nearly as well, and by how much the criterion is worse;
/// the nearest first.
pub(crate) fn rivals<'a>(context: &Context<'a>, now: &Fit<'a>, all: &[usize]) -> Vec<(Vec<usize>, f64)> {
    let worse = |cost: f64| (cost - now.normal.cost) / now.inflation();
    let mut near = swaps(context, now, all);
    let together = together(context, now, &near);
    // The quadratic model may promise too little: a refit decides.
    near.retain(|change| worse(change.cost) < RIVAL_REACH * RIVAL);
    near.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let fitted = near.into_iter().take(RIVALS).chain(together).filter_map(|change| {
        let fit = context.refit_with(now, &change.terms, &change.new)?;
        Some((change.terms, worse(fit.normal.cost).max(0.0)))
    });
    let mut out: Vec<(Vec<usize>, f64)> = fitted.filter(|(_, worse)| *worse < RIVAL).collect();
    out.sort_by(|a, b| a.1.total_cmp(&b.1));
    out
}

/// The best swap of each equation, all at once: `sin(y)` and `sin(x)` may stand for `y` and `x`, and one of them alone
/// for none. `None` where less than two equations have one.
fn together(context: &Context<'_>, now: &Fit<'_>, swaps: &[Change]) -> Option<Change> {
    let of_state = |terms: &[usize], state: usize| -> Vec<usize> {
        terms.iter().copied().filter(|&t| context.system.terms[t].state == state).collect()
    };
    let mut all = Change { terms: vec![], cost: f64::INFINITY, new: vec![] };
    for state in 0..context.system.states.len() {
        let here = of_state(&now.problem.terms, state);
        let differ = swaps.iter().filter(|swap| of_state(&swap.terms, state) != here);
        match differ.min_by(|a, b| a.cost.total_cmp(&b.cost)) {
            Some(best) => {
                all.terms.extend(of_state(&best.terms, state));
                all.new.extend(&best.new);
            }
            None => all.terms.extend(here),
        }
    }
    all.terms.sort_unstable();
    (all.new.len() > 1).then_some(all)
}

/// For terms outside the model, alone and in pairs of one equation: the fall of the cost that the quadratic
/// model promises.
fn scores<'a>(context: &Context<'a>, now: &Fit<'a>, all: &[usize]) -> Vec<(Vec<usize>, f64)> {
    let outside: Vec<usize> = all.iter().copied().filter(|t| !now.problem.terms.contains(t)).collect();
    let Some((terms, x, normal)) = quadratic_model(context, now, all) else { return vec![] };
    let new: Vec<usize> = outside.iter().filter_map(|t| terms.iter().position(|u| u == t)).collect();
    let old: Vec<usize> = (0..x.len()).filter(|i| !new.contains(i)).collect();
    // Schur complement of what is fitted already.
    let a = &normal.matrix;
    let inner = covariance(&faer::Mat::from_fn(old.len(), old.len(), |i, j| a[(old[i], old[j])]));
    let solved = |column: &dyn Fn(usize) -> f64| -> Vec<f64> {
        let b: Vec<f64> = old.iter().map(|&i| column(i)).collect();
        (0..old.len())
            .map(|i| {
                (0..old.len())
                    .map(|j| if inner[(i, j)].is_finite() { inner[(i, j)] * b[j] } else { 0.0 })
                    .sum()
            })
            .collect()
    };
    let columns: Vec<Vec<f64>> = new.iter().map(|&c| solved(&|i| a[(i, c)])).collect();
    let left = |i: usize, j: usize| {
        a[(new[i], new[j])] - old.iter().zip(&columns[j]).map(|(&o, s)| a[(o, new[i])] * s).sum::<f64>()
    };
    let shift = solved(&|i| normal.gradient[i]);
    let g: Vec<f64> = new
        .iter()
        .map(|&c| normal.gradient[c] - old.iter().zip(&shift).map(|(&o, s)| a[(o, c)] * s).sum::<f64>())
        .collect();
    // A coefficient outside its bounds cannot give the promised fall.
    let reaches = |k: usize, step: f64| {
        let (low, high) = context.system.terms[outside[k]].within;
        (low..=high).contains(&step)
    };
    let mut out = Vec::new();
    for i in 0..new.len() {
        let ii = left(i, i);
        let own = a[(new[i], new[i])];
        if ii.is_nan() || ii <= NEW_PART * own {
            continue;
        }
        if reaches(i, -g[i] / ii) {
            out.push((vec![outside[i]], g[i] * g[i] / ii));
        }
        for j in 0..i {
            let same = context.system.terms[outside[i]].state == context.system.terms[outside[j]].state;
            let (jj, ij) = (left(j, j), left(i, j));
            let det = ii * jj - ij * ij;
            if same && det > NEW_PAIR * ii * jj {
                let fall = (jj * g[i] * g[i] - 2.0 * ij * g[i] * g[j] + ii * g[j] * g[j]) / det;
                let steps = [(j, (ij * g[i] - ii * g[j]) / det), (i, (ij * g[j] - jj * g[i]) / det)];
                if steps.into_iter().all(|(k, step)| reaches(k, step)) {
                    out.push((vec![outside[j], outside[i]], fall));
                }
            }
        }
    }
    out
}

/// The fit without the terms that noise of inputs explains. It moves the coefficients beside the noise of the
/// columns, so a term is worth its price only where its coefficient is large against both.
pub(crate) fn without_noise_of_inputs<'a>(context: &Context<'a>, mut fit: Fit<'a>, all: &[usize]) -> Fit<'a> {
    while fit.problem.terms.len() > 1 {
        let Some(added) = input_noise::variance(&fit) else { break };
        let (k, bars) = (fit.problem.terms.len(), ErrorBars::new(&fit));
        let rise = |i: usize| fit.x[i] * fit.x[i] / (bars.error(i).powi(2) + added[i]);
        let Some(least) = (0..k).min_by(|&a, &b| rise(a).total_cmp(&rise(b))) else { break };
        let saved = price(k, all.len(), fit.effective) - price(k - 1, all.len(), fit.effective);
        if rise(least) >= saved {
            break;
        }
        let gone = fit.problem.terms[least];
        let terms: Vec<usize> = fit.problem.terms.iter().copied().filter(|t| *t != gone).collect();
        let Some(next) = context.refit(&fit, &terms) else { break };
        fit = context.resettle(next);
    }
    fit
}

/// A term that is a negligible part of the unknown rate of its state, if there is one; the smallest.
pub(crate) fn negligible(fit: &Fit<'_>) -> Option<usize> {
    if fit.problem.terms.len() < 2 {
        return None;
    }
    let sizes = crate::trajectory::term_sizes::term_sizes(fit)?;
    let system = fit.problem.system;
    let cov = if fit.problem.chained {
        covariance(&fit.normal.reduced(fit.problem.terms.len()).matrix)
    } else {
        covariance(&fit.normal.matrix)
    };
    let mut smallest: Option<(f64, usize)> = None;
    for (k, &t) in fit.problem.terms.iter().enumerate() {
        let state = system.terms[t].state;
        let total: f64 = (0..sizes.len())
            .filter(|&j| system.terms[fit.problem.terms[j]].state == state)
            .map(|j| sizes[j])
            .sum();
        let share = if total > 0.0 { sizes[k] / total } else { 0.0 };
        let rise = fit.x[k] * fit.x[k] / (cov[(k, k)] * fit.inflation());
        if share < PRACTICAL_SHARE && rise < INSISTENT_RISE && smallest.is_none_or(|(s, _)| share < s) {
            smallest = Some((share, t));
        }
    }
    smallest.map(|(_, t)| t)
}

#[cfg(test)]
mod tests;
