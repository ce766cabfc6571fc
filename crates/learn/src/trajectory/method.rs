//! Method `trajectory`: the event-located simulation fitted to the records, terms selected, error bars.

use crate::differentiators::{Number, dependence, otherwise};
use crate::linear::covariance;
use crate::result::error::{LearnError, NumericsError};
use crate::result::estimate::Estimate;
use crate::result::identified::{Identified, NoiseModel, PathPoint, StopReason};
use crate::result::parameter::FoundParameter;
use crate::result::quantity::{ParameterId, ParameterOf, Quantity, RecordId, SensorPart, TermId};
use crate::result::term::FoundTerm;
use crate::result::verdict::verdict;
use crate::result::warning::{Warning, at_bounds, sensitive_starts};
use crate::trajectory::agreement::disagreements;
use crate::trajectory::assess::{Solution, assess};
use crate::trajectory::fit::{Context, Fit};
use crate::trajectory::initial::{Regression, smoothed};
use crate::trajectory::problem::{Meaning, Problem};
use crate::trajectory::select::{Selection, rivals, select};
use faer::Mat;
use phisindy_phys::spec::{Method, Role, SegmentsSpec, SelectionSpec};
use phisindy_phys::unit::Unit;
use phisindy_phys::{Case, Parameter, Record, System};
use rayon::prelude::*;
use std::ops::ControlFlow;

/// Correlations beyond this are told in words.
const CORRELATED: f64 = 0.95;
/// ... if one of the two is known worse than to this part of itself.
const VAGUE: f64 = 0.02;
/// The coefficients of more terms than this keep the quadratic interval: each end of a profile costs some evaluations of the whole fit, and a model
/// with so many terms was asked for, not selected.
const PROFILED: usize = 12;
/// Effective samples below this part of all samples are told in words.
const WHITE: f64 = 0.5;
/// What noise looks like less often than this is no noise: once in ten thousand right models.
const NOISE: f64 = 1e-4;

/// Identifies by the trajectory method.
pub(crate) fn by_trajectory(
    case: &Case,
    records: &[Record],
    observe: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<Identified, LearnError> {
    let system = &case.system;
    let fitted: Vec<&Record> = records.iter().filter(|r| r.role == Role::Fit).collect();
    let filled: Vec<Record> = records.iter().map(|r| smoothed(system, r)).collect();
    let smooth: Vec<Record> = filled.iter().filter(|r| r.role == Role::Fit).cloned().collect();
    let context = Context {
        system,
        records: fitted.clone(),
        smooth,
        segments: case.learn.segments.unwrap_or(SegmentsSpec::Auto),
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
    let Selection { fit, path } =
        start(&context, &all, &regression, chosen == SelectionSpec::Auto, &mut hear)?;
    let Selection { fit, path } = match chosen {
        SelectionSpec::Auto => Selection { fit, path },
        SelectionSpec::All => Selection { fit: whole(&context, fit, &all), path },
        SelectionSpec::Cutoff(cutoff) => cut(&context, whole(&context, fit, &all), cutoff),
    };
    stopped |= observe(0.9).is_break();
    let near = if chosen == SelectionSpec::Auto { rivals(&context, &fit, &all) } else { vec![] };
    let alternative =
        near.first().and_then(|(terms, worse)| alternative(system, &fit.problem.terms, terms, *worse));
    let mut found = report(case, records, &filled, fit, path, stopped);
    found.warnings.extend(alternative);
    let singular = |&k: &usize| Warning::SingularCandidate { term: TermId::new(system, k) };
    found.warnings.extend(regression.singular.iter().map(singular));
    Ok(found)
}

/// Another choice of terms that is nearly as good; `None` if the choices do not differ by one term.
fn alternative(system: &System, terms: &[usize], other: &[usize], worse: f64) -> Option<Warning> {
    let own = |a: &[usize], b: &[usize]| a.iter().find(|t| !b.contains(t)).map(|&t| TermId::new(system, t));
    Some(Warning::Alternative { term: own(terms, other)?, other: own(other, terms)?, worse })
}

/// A start that lowers the misfit by less than this part was not worth trying: neither will the next one be.
const WORTH: f64 = 0.02;

/// The best fit from several starts, with its terms selected if `auto`.
///
/// Collinear candidates make a regression of the whole dictionary wild, so the start is poor: the best term of each equation (friction is never
/// started from zero), then the best two, three, all. From each, terms enter and leave; only where something is left that is not noise is the whole
/// dictionary fitted at once, and the next start tried.
fn start<'a>(
    context: &Context<'a>,
    all: &[usize],
    regression: &Regression,
    auto: bool,
    stopped: &mut dyn FnMut(f64) -> bool,
) -> Result<Selection<'a>, LearnError> {
    let system = context.system;
    let lead = lead(context, regression);
    let poor = context.fresh_fit(&lead, &regression.solve(&lead));
    let richer = [regression.best(system, 2), regression.best(system, 3), all.to_vec()];
    let fits = poor
        .into_iter()
        .chain(richer.into_iter().filter_map(|start| context.fresh_fit(&start, &regression.solve(&start))));
    let mut best: Option<(f64, Selection<'a>)> = None;
    let chosen = |fit: Fit<'a>| {
        if auto { structure(context, fit, all) } else { Selection { path: vec![unselected(&fit)], fit } }
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
        let gained = best.as_ref().is_none_or(|(least, _)| misfit < (1.0 - WORTH) * least);
        if best.as_ref().is_none_or(|(least, _)| misfit < *least) {
            best = Some((misfit, found));
        }
        if white || !gained {
            break;
        }
    }
    if let Some((_, found)) = best {
        return Ok(found);
    }
    let simulated = Problem::new(system, &lead, &context.records, &vec![1; context.records.len()])
        .and_then(|p| Ok(p.residuals(&p.guess(&regression.solve(&lead), None, &context.smooth))?));
    Err(simulated.err().map_or(NumericsError::Diverged, NumericsError::Model).into())
}

/// One term for each equation to start with: of the three best by regression the one that predicts best, equation by equation. (Noise can make a wrong
/// one look good to the regression alone.)
fn lead(context: &Context<'_>, regression: &Regression) -> Vec<usize> {
    let system = context.system;
    let mut lead = regression.single(system, 0);
    let mut least = context.sketch(&lead, &regression.solve(&lead)).unwrap_or(f64::INFINITY);
    for rank in 1..3 {
        for other in regression.single(system, rank) {
            let state = system.terms[other].state;
            let mut trial: Vec<usize> =
                lead.iter().copied().filter(|&t| system.terms[t].state != state).collect();
            trial.push(other);
            trial.sort_unstable();
            let misfit = context.sketch(&trial, &regression.solve(&trial)).unwrap_or(f64::INFINITY);
            if misfit < least {
                (lead, least) = (trial, misfit);
            }
        }
    }
    lead
}

/// Selects until the terms stay: each selection runs on the noise of the fit that it starts from, and a better fit has less of it.
fn structure<'a>(context: &Context<'a>, fit: Fit<'a>, all: &[usize]) -> Selection<'a> {
    let mut hopeless = Vec::new();
    let mut found = select(context, fit, all, &mut hopeless);
    for _ in 0..4 {
        let terms = found.fit.problem.terms.clone();
        let joined = context.joined(&found.fit);
        let same = joined.is_none();
        found = select(context, joined.unwrap_or(found.fit), all, &mut hopeless);
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
fn whole<'a>(context: &Context<'a>, fit: Fit<'a>, all: &[usize]) -> Fit<'a> {
    if fit.problem.terms.len() == all.len() { fit } else { context.richer(&fit, all).unwrap_or(fit) }
}

/// The fixed cut-off of the paper on the trajectory fit: cut, refit, until nothing is cut.
fn cut<'a>(context: &Context<'a>, full: Fit<'a>, cutoff: f64) -> Selection<'a> {
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

fn report(
    case: &Case,
    records: &[Record],
    filled: &[Record],
    fit: Fit<'_>,
    mut path: Vec<PathPoint>,
    stopped: bool,
) -> Identified {
    let system = &case.system;
    let problem = &fit.problem;
    let inflation = fit.inflation();
    let cov = robust_covariance(&fit);
    let error = |k: usize| (cov[(k, k)] * inflation).sqrt();
    let bread = covariance(&fit.normal.matrix);
    let estimate = |k: usize| Estimate {
        value: fit.x[k],
        std_error: error(k),
        ci95: crate::trajectory::profile::interval(&fit, k, error(k), bread[(k, k)].sqrt()),
    };
    let t = problem.terms.len();
    let terms: Vec<FoundTerm> = (0..t)
        .into_par_iter()
        .map(|k| {
            let coefficient = if t > PROFILED { Estimate::normal(fit.x[k], error(k)) } else { estimate(k) };
            FoundTerm::new(problem.terms[k], coefficient)
        })
        .collect();
    let fit_indices: Vec<usize> = (0..records.len()).filter(|&r| records[r].role == Role::Fit).collect();
    let mut parameters = Vec::new();
    let mut names: Vec<(usize, Quantity)> =
        (0..t).map(|k| (k, Quantity::Coefficient(TermId::new(system, problem.terms[k])))).collect();
    for (k, meaning) in problem.meanings().into_iter().enumerate() {
        if let Some(found) = found(system, problem, &fit, k, meaning, &fit_indices, records, &estimate) {
            names.push((k, Quantity::Parameter(found.id.clone())));
            parameters.push(found);
        }
    }
    let note = |r: &Record, note: &String| Warning::DataNote { record: r.name.clone(), note: note.clone() };
    let mut warnings: Vec<Warning> =
        records.iter().flat_map(|r| r.notes.iter().map(move |n| note(r, n))).collect();
    warnings.extend(at_bounds(&parameters));
    warnings.extend(inseparable(&cov, &names, &fit.x));
    let covariance =
        names.iter().map(|(a, _)| names.iter().map(|(b, _)| cov[(*a, *b)] * inflation).collect()).collect();
    let numbers: Vec<Number> = names.iter().map(|(k, name)| (*k, name.clone(), error(*k))).collect();
    warnings.extend(dependence(&numbers, &fit.normal, |how| otherwise(&fit, how)));
    let independent = fit.effective / fit.samples.max(1) as f64;
    if independent < WHITE {
        warnings.push(Warning::Coloured { independent });
    } else if fit.chance_of_noise() < NOISE {
        warnings.push(Warning::NotNoise);
    }
    let segmented = fit.pieces.iter().any(|&p| p > 1);
    if segmented {
        warnings.push(Warning::Segmented { pieces: fit.pieces.iter().max().copied().unwrap_or(1) });
    }
    let mut solution = solution(system, records, &fit, &fit_indices);
    let mut fits = assess(system, records, filled, &mut solution);
    warnings.extend(sensitive_starts(&fits));
    warnings.extend(disagreements(&fit, &cov, &solution, records, filled, &fits));
    for (i, &r) in fit_indices.iter().enumerate() {
        fits[r].noise = (0..system.states.len())
            .filter(|&k| records[r].columns[k].is_some())
            .map(|k| {
                let predictions = problem.deviations[i][k];
                (system.states[k].name.clone(), fit.noise[i][k].variance(predictions).sqrt())
            })
            .collect();
    }
    let mut bare = Solution {
        terms: vec![],
        coefficients: vec![],
        starts: vec![None; records.len()],
        ..solution.clone()
    };
    let without = assess(system, records, filled, &mut bare);
    let verdict = verdict(system, &terms, &fits, &without);
    let worst = fit_indices.iter().map(|&r| fits[r].worst()).fold(0.0, f64::max);
    if let Some(point) = path.iter_mut().find(|p| p.terms == t) {
        point.nrmse = worst.is_finite().then_some(worst);
    }
    let kinds: Vec<NoiseModel> = (0..fit_indices.len())
        .flat_map(|i| (0..system.states.len()).map(move |k| (i, k)))
        .filter(|&(i, k)| problem.records[i].columns[k].is_some())
        .map(|(i, k)| fit.noise[i][k].kind(problem.deviations[i][k]))
        .collect();
    let noise_model = match kinds.first() {
        Some(&first) if kinds.iter().all(|k| *k == first) => first,
        _ => NoiseModel::Mixed,
    };
    Identified {
        method: Method::Trajectory,
        terms,
        parameters,
        records: fits,
        noise_model,
        selection: path,
        covariance,
        warnings,
        verdict,
        stop_reason: if stopped { StopReason::Interrupted } else { StopReason::Finished },
    }
}

/// The sandwich `A^-1 B A^-1`: curvature `A` of the cost, scatter `B` of its gradient. Where the noise model holds it is `A^-1`; directions that the
/// data do not see stay infinite.
pub(crate) fn robust_covariance(fit: &Fit<'_>) -> Mat<f64> {
    let bread = covariance(&fit.normal.matrix);
    let Ok(meat) = fit.problem.meat(&fit.x, &fit.weights) else { return bread };
    let n = bread.nrows();
    let seen: Vec<usize> = (0..n).filter(|&k| bread[(k, k)].is_finite()).collect();
    let pick = |m: &Mat<f64>| Mat::from_fn(seen.len(), seen.len(), |i, j| m[(seen[i], seen[j])]);
    let small = pick(&bread);
    let sandwich = &small * &pick(&meat) * &small;
    // Few residuals carry most of the information: the sandwich is a little short (HC1).
    let stretch = fit.samples as f64 / fit.samples.saturating_sub(seen.len()).max(1) as f64;
    let mut out = Mat::from_fn(n, n, |i, j| if i == j { f64::INFINITY } else { 0.0 });
    for (i, &a) in seen.iter().enumerate() {
        for (j, &b) in seen.iter().enumerate() {
            out[(a, b)] = sandwich[(i, j)] * stretch;
        }
    }
    out
}

#[allow(clippy::too_many_arguments)] // one place that names every kind of unknown
pub(crate) fn found(
    system: &System,
    problem: &Problem<'_>,
    fit: &Fit<'_>,
    k: usize,
    meaning: Meaning,
    fit_indices: &[usize],
    records: &[Record],
    estimate: &dyn Fn(usize) -> Estimate,
) -> Option<FoundParameter> {
    let bounds = problem.bounds[k];
    let value = fit.x[k];
    let owner = |r: usize| RecordId {
        index: fit_indices[r],
        name: records[fit_indices[r]].name.clone(),
        only: fit_indices.len() == 1,
    };
    let (of, unit, owner) = match meaning {
        Meaning::Parameter(index, record) => {
            let Parameter { name, unit, .. } = &system.parameters[index];
            (ParameterOf::Constant { index, name: name.clone() }, unit.clone(), record.map(owner))
        }
        Meaning::Sensor(r, column, which) => {
            let (name, own) = system.measured(column);
            let part = SensorPart::ALL[which];
            let of = ParameterOf::Sensor { column, name: name.to_owned(), part };
            (of, part.unit(own).to_owned(), Some(owner(r)))
        }
        Meaning::Coefficient(_) | Meaning::Start => return None,
    };
    Some(FoundParameter {
        id: ParameterId { of, owner },
        factor: Unit::parse(&unit).map_or(1.0, |u| u.factor),
        unit,
        estimate: estimate(k),
        bounds,
        at_bound: value <= bounds.0 || value >= bounds.1,
    })
}

/// Numbers that the data do not see, or cannot tell apart. `names` are the unknowns of the result; `cov` and `values` are of all unknowns.
fn inseparable(cov: &Mat<f64>, names: &[(usize, Quantity)], values: &[f64]) -> Vec<Warning> {
    let mut out = Vec::new();
    let unseen = names.iter().filter(|(a, _)| !cov[(*a, *a)].is_finite()).map(|(_, name)| name.clone());
    let mut numbers: Vec<Quantity> = unseen.collect();
    match numbers.len() {
        0 => {}
        1 => out.push(Warning::Unseen { number: numbers.remove(0) }),
        // One scale that is common to several is seen by none: each of them may be anything, and together they fit.
        _ => out.push(Warning::Inseparable { numbers }),
    }
    for (i, (a, name_a)) in names.iter().enumerate() {
        if !cov[(*a, *a)].is_finite() {
            continue;
        }
        for (b, name_b) in &names[..i] {
            let correlation = cov[(*a, *b)] / (cov[(*a, *a)] * cov[(*b, *b)]).sqrt();
            let vague = |k: usize| cov[(k, k)].sqrt() > VAGUE * values[k].abs();
            if correlation.abs() > CORRELATED && (vague(*a) || vague(*b)) {
                let (first, second) = (name_b.clone(), name_a.clone());
                out.push(Warning::Correlated { first, second, correlation });
            }
        }
    }
    out
}

/// The numbers of a fit, by record; Validate records take those of the record that they continue, or of the first fitted one.
pub(crate) fn solution(
    system: &System,
    records: &[Record],
    fit: &Fit<'_>,
    fit_indices: &[usize],
) -> Solution {
    let problem = &fit.problem;
    let t = problem.terms.len();
    let base: Vec<f64> = system.parameters.iter().map(|p| p.start).collect();
    let mut out = Solution::new(problem.terms.clone(), fit.x[..t].to_vec(), &base, records);
    let numbers = |i: usize| problem.model_parameters(i, &fit.x)[t..t + system.parameters.len()].to_vec();
    for (r, record) in records.iter().enumerate() {
        let owner = fit_indices.iter().position(|&f| f == r || record.continues == Some(f));
        out.parameters[r] = numbers(owner.unwrap_or(0));
    }
    for (k, meaning) in problem.meanings().into_iter().enumerate() {
        if let Meaning::Sensor(i, state, which) = meaning {
            out.sensors[fit_indices[i]][state][which] = fit.x[k];
        }
    }
    for (i, &r) in fit_indices.iter().enumerate() {
        if let Some(first) = problem.segments.iter().find(|s| s.record == i) {
            out.starts[r] = Some(fit.x[first.start..first.start + system.states.len()].to_vec());
        }
    }
    out
}

#[cfg(test)]
mod tests;
