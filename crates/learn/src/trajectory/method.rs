//! Method `trajectory`: the event-located simulation fitted to the records, terms selected, error bars.

use crate::decisions::{LEADING_RANKS, LIKELIHOOD_GAIN, SELECTIONS, START_GAIN};
use crate::identify::LearnOptions;
use crate::result::error::{LearnError, NumericsError};
use crate::result::identified::{Identified, PathPoint, StopReason};
use crate::result::quantity::TermId;
use crate::result::warning::Warning;
use crate::trajectory::fit::{Context, Fit};
use crate::trajectory::initial::Regression;
use crate::trajectory::late_column::late_column;
use crate::trajectory::problem::Problem;
use crate::trajectory::report::report;
use crate::trajectory::select::{Selection, rivals, select, without_noise_of_inputs};
use phisindy_phys::spec::{Role, SegmentsSpec, SelectionSpec};
use phisindy_phys::{Case, Record, System};
use phisindy_sim::Stop;
use std::ops::ControlFlow;

/// Identifies by the trajectory method. `filled` is what [`super::initial::smoothed`] makes of the records.
pub(crate) fn by_trajectory(
    case: &Case,
    (records, filled): (&[Record], &[Record]),
    options: &LearnOptions,
    stop: &Stop,
    observe: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<Identified, LearnError> {
    let system = &case.system;
    let fitted: Vec<&Record> = records.iter().filter(|r| r.role == Role::Fit).collect();
    let smooth: Vec<Record> = filled.iter().filter(|r| r.role == Role::Fit).cloned().collect();
    let context = Context {
        system,
        records: fitted.clone(),
        smooth,
        segments: case.learn.segments.unwrap_or(SegmentsSpec::Auto),
        stop: stop.clone(),
    };
    let mut stopped = observe(0.02).is_break();
    let all: Vec<usize> = (0..system.terms.len()).collect();
    let parameters: Vec<f64> = system.parameters.iter().map(|p| p.start).collect();
    let regression = Regression::new(system, &context.smooth, &parameters);
    let mut hear = |part: f64| {
        stopped |= observe(part).is_break();
        stopped
    };
    let chosen = case.learn.selection.unwrap_or(SelectionSpec::Auto);
    let auto = chosen == SelectionSpec::Auto;
    let alone = if options.fitted_before { context.fresh_fit(&all, &regression.solve(&all)) } else { None };
    let known = alone.is_some();
    let selected = match alone {
        Some(fit) => Selection { path: vec![unselected(&fit)], fit },
        None => start(&context, &all, &regression, auto, &mut hear)?,
    };
    stopped |= observe(0.8).is_break();
    let ends = known || stopped || stop.requested();
    let (selected, warnings) =
        if ends { (selected, vec![]) } else { refined(&context, selected, chosen, &all, &regression) };
    stopped |= observe(0.9).is_break();
    let fit = if ends { selected.fit } else { context.past_side_minima(selected.fit) };
    let late = if known || stop.requested() { None } else { late_column(&context, &fit) };
    let fit = if stop.requested() { fit } else { context.with_random_force(fit) };
    let stop_reason =
        if stopped || stop.requested() { StopReason::Interrupted } else { StopReason::Finished };
    let found = report(case, records, filled, &fit, selected.path, stop_reason);
    let mut found = Identified { late, ..found };
    found.warnings.extend(warnings);
    let singular = |&k: &usize| Warning::SingularCandidate { term: TermId::new(system, k) };
    found.warnings.extend(regression.singular.iter().map(singular));
    Ok(found)
}

/// What was selected, in a chain where that follows the records better, in its lowest minimum; with what is nearly as
/// good.
fn refined<'a>(
    context: &Context<'a>,
    selected: Selection<'a>,
    chosen: SelectionSpec,
    all: &[usize],
    regression: &Regression,
) -> (Selection<'a>, Vec<Warning>) {
    let (system, auto) = (context.system, chosen == SelectionSpec::Auto);
    let chain = auto.then(|| context.chained(&selected.fit, regression)).flatten();
    let Selection { fit, path } = chain.unwrap_or(selected);
    let Selection { fit, path } = match chosen {
        SelectionSpec::Auto => Selection { fit, path },
        SelectionSpec::All => Selection { fit: with_all_terms(context, fit, all), path },
        SelectionSpec::Cutoff(cutoff) => cut_off(context, with_all_terms(context, fit, all), cutoff),
    };
    let fit = if auto { without_noise_of_inputs(context, fit, all) } else { fit };
    let near = if auto { rivals(context, &fit, all) } else { vec![] };
    let alternative =
        near.first().and_then(|(terms, worse)| alternative(system, &fit.problem.terms, terms, *worse));
    let further = if auto { context.nearly_there(&fit) } else { None };
    let further = further.map(|(t, worse)| Warning::Further { term: TermId::new(system, t), worse });
    let fit = from_regression(context, context.with_starts_at_rest(fit), regression);
    (Selection { fit, path }, alternative.into_iter().chain(further).collect())
}

/// The fit with a coefficient that its records hardly tell, or that of the same terms from the regression of
/// all: where a cost has several minima the lowest counts, whichever start led there.
fn from_regression<'a>(context: &Context<'a>, fit: Fit<'a>, regression: &Regression) -> Fit<'a> {
    if fit.most_pieces() > 1 || !fit.is_blurred() {
        return fit;
    }
    let terms = fit.problem.terms.clone();
    let other = context.fresh_fit(&terms, &regression.solve(&terms));
    let lower = |other: &Fit<'a>| {
        let cost = fit.problem.cost(&other.x, &fit.weights);
        other.pieces == fit.pieces && cost.is_ok_and(|cost| cost < fit.normal.cost - LIKELIHOOD_GAIN)
    };
    match other.filter(lower) {
        Some(other) => other,
        None => fit,
    }
}

/// Another choice of terms that is nearly as good: what stands in the place of what.
fn alternative(system: &System, terms: &[usize], other: &[usize], worse: f64) -> Option<Warning> {
    let only =
        |a: &[usize], b: &[usize]| -> Vec<usize> { a.iter().copied().filter(|t| !b.contains(t)).collect() };
    let (gone, new) = (only(terms, other), only(other, terms));
    let id = |t: usize| TermId::new(system, t);
    let of = |t: usize| new.iter().copied().find(|&n| system.terms[n].state == system.terms[t].state);
    let swaps: Vec<_> = gone.iter().filter_map(|&t| Some((id(t), id(of(t)?)))).collect();
    (!swaps.is_empty() && swaps.len() == new.len()).then_some(Warning::Alternative { swaps, worse })
}

/// The best fit from several starts, with its terms selected if `auto`.
///
/// Collinear candidates make a regression of the whole dictionary ill-conditioned, so the first start has
/// only the best term of each equation, the next ones the best two, three, all. From each start terms enter
/// and leave. Only if the residual is not white, the whole dictionary is fitted at once and the next start is
/// tried.
fn start<'a>(
    context: &Context<'a>,
    all: &[usize],
    regression: &Regression,
    auto: bool,
    stopped: &mut dyn FnMut(f64) -> bool,
) -> Result<Selection<'a>, LearnError> {
    let system = context.system;
    let first_terms = first_terms(context, regression);
    let poor = context.fresh_fit(&first_terms, &regression.solve(&first_terms));
    let richer = [regression.best(system, 2), regression.best(system, 3), all.to_vec()];
    let fits = poor
        .into_iter()
        .chain(richer.into_iter().filter_map(|start| context.fresh_fit(&start, &regression.solve(&start))));
    let mut best: Option<(f64, Selection<'a>)> = None;
    let chosen = |fit: Fit<'a>| {
        if auto {
            select_until_stable(context, fit, all)
        } else {
            Selection { path: vec![unselected(&fit)], fit }
        }
    };
    for (k, poor) in fits.enumerate() {
        if stopped(0.1 + 0.2 * k as f64) && best.is_some() {
            break;
        }
        let mut found = chosen(poor);
        if !found.fit.is_white() && found.fit.problem.terms.len() < all.len() {
            let rich = context.richer(&found.fit, all).map(&chosen);
            if let Some(rich) = rich.filter(|r| context.misfit(&r.fit) < context.misfit(&found.fit)) {
                found = rich;
            }
        }
        let Some(misfit) = context.misfit(&found.fit) else { continue };
        let white = found.fit.is_white();
        // A start that leads to no term says nothing of the next one.
        let empty = found.fit.problem.terms.is_empty();
        let gained = best.as_ref().is_none_or(|(least, _)| misfit < (1.0 - START_GAIN) * least);
        if best.as_ref().is_none_or(|(least, _)| misfit < *least) {
            best = Some((misfit, found));
        }
        // Without a measured state a start that is no better says little of the next one.
        if white || !gained && !empty && !context.is_blind() {
            break;
        }
    }
    if let Some((_, found)) = best {
        return Ok(found);
    }
    let simulated = Problem::new(system, &first_terms, &context.records, &vec![1; context.records.len()])
        .and_then(|p| Ok(p.residuals(&p.guess(&regression.solve(&first_terms), None, &context.smooth))?));
    Err(simulated.err().map_or(NumericsError::Diverged, NumericsError::Model).into())
}

/// The first term of each equation: of the best by regression the one that predicts best. (With noise a wrong
/// term may be best by regression alone.)
fn first_terms(context: &Context<'_>, regression: &Regression) -> Vec<usize> {
    let system = context.system;
    let mut first_terms = regression.single(system, 0);
    let misfit = |terms: &[usize]| {
        let coefficients = regression.solve(terms);
        let misfit = context.misfit_of_first_part(terms, &coefficients);
        misfit.or_else(|| context.misfit_of_guess(terms, &coefficients)).unwrap_or(f64::INFINITY)
    };
    let mut least = misfit(&first_terms);
    for rank in 1..LEADING_RANKS {
        for other in regression.single(system, rank) {
            // An equation without so many candidates has its last one again.
            if first_terms.contains(&other) {
                continue;
            }
            let state = system.terms[other].state;
            let mut trial: Vec<usize> =
                first_terms.iter().copied().filter(|&t| system.terms[t].state != state).collect();
            trial.push(other);
            trial.sort_unstable();
            let miss = misfit(&trial);
            if miss < least {
                (first_terms, least) = (trial, miss);
            }
        }
    }
    first_terms
}

/// Selects until the terms do not change. Each selection uses the noise estimate of the fit that it starts
/// from, and a better fit has a smaller one.
fn select_until_stable<'a>(context: &Context<'a>, fit: Fit<'a>, all: &[usize]) -> Selection<'a> {
    let mut hopeless = Vec::new();
    let mut found = select(context, fit, all, &mut hopeless);
    for _ in 0..SELECTIONS {
        let terms = found.fit.problem.terms.clone();
        let again = context.joined(&found.fit).or_else(|| context.through_means(&found.fit));
        let same = again.is_none();
        found = select(context, again.unwrap_or(found.fit), all, &mut hopeless);
        if same && found.fit.problem.terms == terms {
            break;
        }
    }
    found
}

fn unselected(fit: &Fit<'_>) -> PathPoint {
    PathPoint { terms: fit.problem.terms.len(), criterion: fit.normal.cost, nrmse: None }
}

/// The fit with every candidate in it, if it can be simulated.
fn with_all_terms<'a>(context: &Context<'a>, fit: Fit<'a>, all: &[usize]) -> Fit<'a> {
    if fit.problem.terms.len() == all.len() { fit } else { context.richer(&fit, all).unwrap_or(fit) }
}

/// The fixed cut-off of the paper applied to the trajectory fit: cut and refit until nothing is cut.
fn cut_off<'a>(context: &Context<'a>, full: Fit<'a>, cutoff: f64) -> Selection<'a> {
    let mut now = full;
    let mut path =
        vec![PathPoint { terms: now.problem.terms.len(), criterion: now.normal.cost, nrmse: None }];
    loop {
        let kept: Vec<usize> = now
            .problem
            .terms
            .iter()
            .enumerate()
            .filter(|(k, _)| now.x[*k].abs() >= cutoff)
            .map(|(_, &t)| t)
            .collect();
        if kept.len() == now.problem.terms.len() {
            return Selection { fit: now, path };
        }
        match context.refit(&now, &kept) {
            Some(fit) => now = fit,
            None => return Selection { fit: now, path },
        }
        path.push(PathPoint { terms: kept.len(), criterion: now.normal.cost, nrmse: None });
    }
}

#[cfg(test)]
mod tests;
