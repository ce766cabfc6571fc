//! Method `trajectory`: the event-located simulation fitted to the records, terms selected, error bars.

use crate::differentiators::{Number, dependence, otherwise};
use crate::identify::{at_bounds, verdict};
use crate::linear::covariance;
use crate::result::identified::{
    Estimate, FoundParameter, FoundTerm, Identified, LearnError, PathPoint, sensitive_starts,
};
use crate::trajectory::agreement::disagreements;
use crate::trajectory::assess::{Solution, assess};
use crate::trajectory::fit::{Context, Fit};
use crate::trajectory::initial::{Regression, smoothed};
use crate::trajectory::problem::{Meaning, Problem};
use crate::trajectory::select::{Selection, rivals, select};
use faer::Mat;
use phisindy_phys::spec::{Method, Role, SegmentsSpec, SelectionSpec};
use phisindy_phys::unit::Unit;
use phisindy_phys::{Case, Record, System};
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
    let instead = near.first().map(|(terms, worse)| instead(system, &fit.problem.terms, terms, *worse));
    let mut found = report(case, records, &filled, fit, path, stopped);
    found.warnings.extend(instead);
    for &k in &regression.singular {
        let (candidate, state) = (&system.terms[k].candidate, &system.states[system.terms[k].state].name);
        found.warnings.push(format!(
            "candidate {candidate} of {state}' is not finite everywhere on the data: it was hardly considered"
        ));
    }
    Ok(found)
}

/// Another choice of terms that is nearly as good, in words.
fn instead(system: &System, terms: &[usize], other: &[usize], worse: f64) -> String {
    let of = |a: &[usize], b: &[usize]| {
        let own = a.iter().find(|t| !b.contains(t));
        own.map_or(("", ""), |&t| {
            (system.terms[t].candidate.as_str(), system.states[system.terms[t].state].name.as_str())
        })
    };
    let ((here, state), (there, _)) = (of(terms, other), of(other, terms));
    format!(
        "{there} in the place of {here} in {state}' describes the data as well (criterion {worse:.1} higher, below {:.0} is no evidence): the intervals hold only if the terms are \
         the right ones; a record at another amplitude or speed would tell",
        crate::trajectory::select::RIVAL
    )
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
    let why = Problem::new(system, &lead, &context.records, &vec![1; context.records.len()])
        .map_err(LearnError::Numerics)
        .and_then(|p| {
            let x = p.guess(&regression.solve(&lead), None, &context.smooth);
            p.residuals(&x).map_err(|e| LearnError::Numerics(format!("the model cannot be simulated: {e}")))
        });
    Err(why.err().unwrap_or_else(|| LearnError::Numerics("the fit diverges from every start".into())))
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
    let mut names: Vec<(usize, String)> = (0..t)
        .map(|k| {
            (
                k,
                format!(
                    "{} in {}'",
                    system.terms[problem.terms[k]].candidate,
                    system.states[system.terms[problem.terms[k]].state].name
                ),
            )
        })
        .collect();
    for (k, meaning) in problem.meanings().into_iter().enumerate() {
        if let Some(found) = found(system, problem, &fit, k, meaning, &fit_indices, records, &estimate) {
            names.push((k, found.name.clone()));
            parameters.push(found);
        }
    }
    let mut warnings: Vec<String> =
        records.iter().flat_map(|r| r.notes.iter().map(|n| format!("{}: {n}", r.name))).collect();
    warnings.extend(at_bounds(&parameters));
    warnings.extend(inseparable(&cov, &names, &fit.x));
    let covariance =
        names.iter().map(|(a, _)| names.iter().map(|(b, _)| cov[(*a, *b)] * inflation).collect()).collect();
    let numbers: Vec<Number> = names.iter().map(|(k, name)| (*k, name.clone(), error(*k))).collect();
    warnings.extend(dependence(&numbers, &fit.normal, |how| otherwise(&fit, how)));
    let white = fit.effective / fit.samples.max(1) as f64;
    if white < WHITE {
        warnings.push(format!(
            "the residual is not white ({:.0} % of the samples are independent): something is still missing, the known part is wrong, or the sensor filters; the intervals count \
             correlated samples as few",
            100.0 * white
        ));
    } else if fit.chance_of_noise() < NOISE {
        warnings.push(
            "the residual is not white: what is left is small, but it is not noise; something is still missing, or a number of the known part is a little wrong, and the \
             intervals, which take it as exact, may miss"
                .into(),
        );
    }
    let segmented = fit.pieces.iter().any(|&p| p > 1);
    if segmented {
        let pieces = fit.pieces.iter().max().copied().unwrap_or(1);
        warnings.push(format!(
            "a single run drifts away from the data, so each record was fitted in up to {pieces} segments with start states of their own"
        ));
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
    let kinds: Vec<&str> = (0..fit_indices.len())
        .flat_map(|i| (0..system.states.len()).map(move |k| (i, k)))
        .filter(|&(i, k)| problem.records[i].columns[k].is_some())
        .map(|(i, k)| fit.noise[i][k].kind(problem.deviations[i][k]))
        .collect();
    let noise_model = match kinds.first() {
        Some(first) if kinds.iter().all(|k| k == first) => (*first).to_owned(),
        _ => "mixed".to_owned(),
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
        stopped,
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
    let (name, unit, parameter, record) = match meaning {
        Meaning::Parameter(p, None) => {
            (system.parameters[p].name.clone(), system.parameters[p].unit.clone(), Some(p), None)
        }
        Meaning::Parameter(p, Some(r)) => {
            let record = fit_indices[r];
            let name = format!("{} [{}]", system.parameters[p].name, records[record].name);
            (name, system.parameters[p].unit.clone(), Some(p), Some(record))
        }
        Meaning::Sensor(r, state, which) => {
            let record = fit_indices[r];
            let (column, own) = system.measured(state);
            let mut name = format!("{column}.{}", Problem::sensor_name(which));
            if fit_indices.len() > 1 {
                name = format!("{name} [{}]", records[record].name);
            }
            let unit = match Problem::sensor_name(which) {
                "offset" => own.to_owned(),
                "delay" => "s".to_owned(),
                _ => String::new(),
            };
            (name, unit, None, Some(record))
        }
        Meaning::Coefficient(_) | Meaning::Start => return None,
    };
    Some(FoundParameter {
        factor: Unit::parse(&unit).map_or(1.0, |u| u.factor),
        name,
        unit,
        estimate: estimate(k),
        bounds,
        at_bound: value <= bounds.0 || value >= bounds.1,
        parameter,
        record,
    })
}

/// Pairs that the data cannot tell apart, in words, with what would.
fn inseparable(cov: &Mat<f64>, names: &[(usize, String)], values: &[f64]) -> Vec<String> {
    let mut out = Vec::new();
    let open: Vec<&str> =
        names.iter().filter(|(a, _)| !cov[(*a, *a)].is_finite()).map(|(_, name)| name.as_str()).collect();
    match open.as_slice() {
        [] => {}
        [one] => out.push(format!("the data say nothing about {one}: give it a number, or leave it out")),
        // One scale that is common to several is seen by none: each of them may be anything, and together they fit.
        several => out.push(format!(
            "the data do not tell {} apart: with any value of one of them the others fit as well, and what is printed is one choice of many; give one of them a number",
            several.join(", ")
        )),
    }
    for (i, (a, name_a)) in names.iter().enumerate() {
        if !cov[(*a, *a)].is_finite() {
            continue;
        }
        for (b, name_b) in &names[..i] {
            let r = cov[(*a, *b)] / (cov[(*a, *a)] * cov[(*b, *b)]).sqrt();
            let vague = |k: usize| cov[(k, k)].sqrt() > VAGUE * values[k].abs();
            if r.abs() > CORRELATED && (vague(*a) || vague(*b)) {
                let known = if r < 0.0 { "sum" } else { "difference" };
                out.push(format!(
                    "{name_b} and {name_a} trade off (correlation {r:.3}): their {known} is known better than either; a record at another amplitude or \
                     speed would tell them apart"
                ));
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
