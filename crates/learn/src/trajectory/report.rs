//! A fit as a result: terms and parameters with error bars, warnings, free runs, a verdict.

use crate::decisions::{
    CHANCE_OF_NOISE, COLOURED_PART, COMPLETE, LAW_MISSING, OTHER_MACHINE, PROFILED_TERMS, RARE, WORST_NRMSE,
};
use crate::differentiator_dependence::{Number, dependence};
use crate::input_noise::{self, InputNoiseEffect};
use crate::result::estimate::Estimate;
use crate::result::identified::{Identified, NoiseModel, PathPoint, StopReason};
use crate::result::parameter::FoundParameter;
use crate::result::quantity::{Quantity, TermId};
use crate::result::record_fit::RecordFit;
use crate::result::remainder::Remainder;
use crate::result::term::FoundTerm;
use crate::result::verdict::{Contradiction, FitFailure, Rejection, Verdict, verdict};
use crate::result::warning::Chaos;
use crate::result::warning::{Warning, at_bounds, sensitive_starts};
use crate::trajectory::agreement::{Agreement, disagreements};
use crate::trajectory::analogues::columns_with_remains;
use crate::trajectory::contradiction::contradiction;
use crate::trajectory::elasticities::elasticities;
use crate::trajectory::error_bars::ErrorBars;
use crate::trajectory::fit::{Fit, misfit};
use crate::trajectory::free_run::{Solution, free_runs};
use crate::trajectory::horizon::horizons;
use crate::trajectory::jacobian::Singular;
use crate::trajectory::problem::Meaning;
use crate::trajectory::remainder::remainders;
use crate::trajectory::separability::inseparable;
use crate::trajectory::unknowns::Unknowns;
use crate::trajectory::validated_chain::ValidatedChain;
use crate::trajectory::worth_of_laws::against_laws;
use phisindy_phys::spec::Method;
use phisindy_phys::{Case, Note, Record, System};
use phisindy_signal::Differentiator;
use rayon::prelude::*;

/// The result of a fit to the Fit records of `records`. `filled` are the records with smoothed samples of
/// every state; `path` is the path of the selection.
pub(crate) fn report(
    case: &Case,
    records: &[Record],
    filled: &[Record],
    fit: &Fit<'_>,
    path: Vec<PathPoint>,
    stop_reason: StopReason,
) -> Identified {
    let system = &case.system;
    let unknowns = Unknowns::new(system, records, fit);
    let bars = ErrorBars::new(fit);
    let mut terms = coefficients(fit, &bars);
    let moved = unknowns.parameters(|k| bars.estimate(k));
    let named = named(system, fit, &moved);
    let (places, mut parameters): (Vec<usize>, Vec<FoundParameter>) = moved.into_iter().unzip();

    let mut warnings: Vec<Warning> = notes(records).collect();
    warnings.extend(at_bounds(&parameters));
    let failure = failure(fit);
    // Where the fit has not moved its covariance says nothing of the data.
    let fitted = failure.is_none();
    // Work that is to end tells what it has, and fits and simulates no more than that takes.
    let ends = fit.problem.stop.requested();
    let mut input_noise = InputNoiseEffect::default();
    if fitted {
        warnings.extend(inseparable(&bars.sandwich, &named, &fit.x));
        let numbers: Vec<Number> = named.iter().map(|(k, name)| (*k, name.clone(), bars.error(*k))).collect();
        warnings.extend(dependence(&numbers, &fit.normal, |how| differentiated_by(fit, how)));
        if !ends {
            input_noise = input_noise::effect(fit, &numbers);
            warnings.extend(input_noise.warning.take());
        }
    }
    let colour = coloured(fit);
    let only_noise = colour.is_none();
    warnings.extend(colour);

    let mut solution = unknowns.solution();
    let mut fits = free_runs(system, records, filled, &mut solution);
    let chains = ValidatedChain::all(system, fit, &solution, records, filled, &fits);
    let judged = chaos_of(fit, &unknowns.fitted, &chains, &fits);
    let chaos = judged.iter().map(|(_, chaos)| chaos.clone()).reduce(Chaos::worse);
    // No run from a fitted start could follow such a motion.
    if failure.is_none() && only_noise && chaos.as_ref().is_some_and(Chaos::holds) {
        judged.iter().for_each(|(r, chaos)| fits[*r].segments = Some(chaos.nrmse));
    }
    warnings.extend(chaos.map(Warning::Chaotic).or_else(|| segmented(fit)));
    warnings.extend(sensitive_starts(&fits));
    let Agreement { warnings: apart, scatter } = if ends {
        Agreement::default()
    } else {
        disagreements(fit, &bars.sandwich, &solution, records, filled, &fits, &chains)
    };
    warnings.extend(apart);
    let of = |all: &[f64], k: usize| all.get(k).copied().unwrap_or(0.0);
    let variance = |k: usize| of(&scatter, k) + of(&input_noise.variance, k);
    terms.iter_mut().enumerate().for_each(|(k, term)| term.coefficient.widen(variance(k)));
    for (p, &k) in parameters.iter_mut().zip(&places) {
        p.estimate.widen(variance(k));
        p.estimate.ci95 = (p.estimate.ci95.0.max(p.bounds.0), p.estimate.ci95.1.min(p.bounds.1));
    }
    let horizon = if ends { vec![] } else { horizons(fit, records, filled, &solution, &fits) };
    let without = free_runs(system, records, filled, &mut known_part(solution, records));
    let remainder = remainders(fit);
    let judged = match &fit.force {
        Some(_) => with_force(system, &terms, &remainder, &without),
        None => match verdict(system, &terms, &fits, &without, only_noise) {
            held if held.holds() && !only_noise => with_remains(held, system, records, &fits),
            other => other,
        },
    };
    let verdict = match (judged, failure) {
        (Verdict::Rejected(_), Some(failure)) => Verdict::Rejected(Rejection::FitFailed(failure)),
        (held, _) if held.holds() => {
            let against = |without| against_laws(without, fit, &parameters, &fits, only_noise);
            case.without_laws.as_deref().and_then(against).map_or(held, Verdict::Rejected)
        }
        (verdict, _) => verdict,
    };
    // What the records say against each other comes before what they say of the model.
    let verdict = limited(verdict, fit, &terms, &warnings);
    for (i, &r) in unknowns.fitted.iter().enumerate() {
        fits[r].noise = noise_of(fit, i);
    }
    let numbers: Vec<usize> = named.iter().map(|(k, _)| *k).collect();
    let covariance = with_scatter(bars.covariance(&numbers), &numbers, variance);
    // A share of a number that is not told from zero says nothing.
    let near_zero = |i: usize| {
        let error = covariance.get(i).map_or(f64::NAN, |row| row[i].sqrt());
        let (low, high) = Estimate::normal(fit.x[numbers[i]], error).ci95;
        low <= 0.0 && high >= 0.0
    };
    let freed = case.with_constants.as_deref().filter(|_| fitted && !ends && !fit.problem.chained);
    Identified {
        method: Method::Trajectory,
        selection: with_nrmse(path, terms.len(), unknowns.fitted.iter().map(|&r| &fits[r])),
        terms,
        parameters,
        records: fits,
        noise_model: noise_model(fit),
        remainder,
        horizon,
        held: freed.map_or(vec![], |freed| elasticities(freed, fit, &named, &near_zero)),
        covariance,
        late: None,
        deviance: fit.deviance(),
        warnings,
        verdict,
        stop_reason,
    }
}

/// The verdict on a model that leaves a force.
fn with_force(
    system: &System,
    terms: &[FoundTerm],
    remainder: &[Remainder],
    without: &[RecordFit],
) -> Verdict {
    // Without a term there may still be constants that were asked for.
    if terms.is_empty() && !system.terms.is_empty() && system.parameters.is_empty() {
        let known = without.iter().map(|f| (f.name.clone(), f.worst())).collect();
        return Verdict::Rejected(Rejection::NoTerms { known });
    }
    let worst = remainder.iter().max_by(|a, b| a.of_motion.total_cmp(&b.of_motion));
    match worst.filter(|r| r.of_motion > LAW_MISSING) {
        Some(of) => Verdict::Rejected(Rejection::LawMissing {
            record: of.record.clone(),
            of: system.states[of.state].name.clone(),
            output: false,
            share: of.of_motion,
        }),
        // What is a hundredth of the whole is not worth a word, as it is not worth a term.
        None if remainder.iter().all(|left| left.share < COMPLETE) => Verdict::Identified,
        None => Verdict::Named,
    }
}

/// What a verdict that holds says where more than noise is left. Coloured noise leaves it as it is. If it is large and
/// something moves, it may be a force as well. What follows the motion is a force; of an output, a large one is a law that
/// is missing.
fn with_remains(held: Verdict, system: &System, records: &[Record], fits: &[RecordFit]) -> Verdict {
    let missed = fits.iter().flat_map(|f| f.nrmse.iter().map(move |(column, share)| (f, column, *share)));
    let most = missed.max_by(|a, b| a.2.total_cmp(&b.2)).filter(|m| m.2 > LAW_MISSING);
    // Where states jump no force is fitted beside the model, so that what is left is seen in the columns alone.
    if let Some((fit, column, share)) = most.filter(|_| system.jumps()) {
        let (record, of) = (fit.name.clone(), column.clone());
        return Verdict::Rejected(Rejection::LawMissing { record, of, output: true, share });
    }
    let all = columns_with_remains(system, records, fits);
    let outputs = all.iter().filter(|(k, share)| *k >= system.states.len() && *share > LAW_MISSING);
    match outputs.max_by(|a, b| a.1.total_cmp(&b.1)) {
        Some(&(k, share)) => {
            let shows = |r: &&Record| r.columns[k].is_some();
            let record = records.iter().find(shows).map_or(String::new(), |r| r.name.clone());
            let of = system.measured(k).0.to_owned();
            Verdict::Rejected(Rejection::LawMissing { record, of, output: true, share })
        }
        None if all.is_empty() && (most.is_none() || system.states.is_empty()) => held,
        None => Verdict::Named,
    }
}

/// What the records take back of a verdict that holds: they contradict each other, or say nothing of a number.
fn limited(held: Verdict, fit: &Fit<'_>, terms: &[FoundTerm], warnings: &[Warning]) -> Verdict {
    let system = fit.problem.system;
    let of_validated = |w: &Warning| match w {
        Warning::Disagreement { number, record, alone, fitted, errors }
            if *errors > RARE && (alone - fitted).abs() > OTHER_MACHINE * alone.abs().max(fitted.abs()) =>
        {
            Some(Contradiction {
                number: number.clone(),
                records: [record.clone(), "the fitted records".to_owned()],
                values: [*alone, *fitted],
                errors: *errors,
            })
        }
        _ => None,
    };
    if let Some(apart) = Some(fit).filter(|fit| !fit.problem.stop.requested()).and_then(contradiction) {
        return Verdict::Contradictory(apart);
    }
    if !held.holds() {
        return held;
    }
    if let Some(apart) = warnings.iter().find_map(of_validated) {
        return Verdict::Contradictory(apart);
    }
    let open = |w: &Warning| match w {
        Warning::BoundToBound { number: Quantity::Parameter(id) } => Some(id.clone()),
        // Beside a force that is left a number at its bound is what that force made of it.
        Warning::AtBound { number: Quantity::Parameter(id), .. } if fit.force.is_some() => Some(id.clone()),
        _ => None,
    };
    let of_laws = warnings.iter().filter_map(open).filter(|id| id.owner.is_none()).map(Quantity::Parameter);
    let over_zero = |t: &&FoundTerm| {
        let Estimate { std_error, ci95: (low, high), .. } = t.coefficient;
        std_error.is_finite() && low <= 0.0 && high >= 0.0
    };
    let of_terms = terms.iter().filter(over_zero).map(|t| Quantity::Coefficient(TermId::new(system, t.term)));
    let open: Vec<Quantity> = of_terms.chain(of_laws).collect();
    if open.is_empty() { held } else { Verdict::Undetermined(open) }
}

/// What the chains of records whose motion forgets its start say, each with the place of its record.
fn chaos_of(
    fit: &Fit<'_>,
    fitted: &[usize],
    chains: &[Option<ValidatedChain<'_>>],
    fits: &[RecordFit],
) -> Vec<(usize, Chaos)> {
    let of_fitted: Vec<&RecordFit> = fitted.iter().map(|&r| &fits[r]).collect();
    let of_fit = Chaos::of_fit(fit, &of_fitted);
    let together = fitted.iter().filter_map(|&r| Some((r, of_fit.clone()?)));
    let of_validated =
        |(r, chain): (usize, &Option<_>)| Some((r, Chaos::of_validated(chain.as_ref()?, &fits[r])?));
    together.chain(chains.iter().enumerate().filter_map(of_validated)).collect()
}

/// Why a fit did not move; `None` if it did, or had nothing to move.
fn failure(fit: &Fit<'_>) -> Option<FitFailure> {
    let (problem, system) = (&fit.problem, fit.problem.system);
    let start = |meaning: &Meaning| match *meaning {
        Meaning::Parameter(p, _) => Some(system.parameters[p].start),
        Meaning::Sensor(r, column, which) => {
            Some(problem.records[r].sensors[column].parameters()[which].start)
        }
        // Where the regression starts a coefficient is where it belongs.
        Meaning::Coefficient(_) | Meaning::Start => None,
    };
    let blind = fit.normal.gradient.iter().any(|g| !g.is_finite());
    // What nothing depends on, or what starts at the minimum, need not move.
    let misses = || misfit(problem, &fit.x).is_some_and(|missed| missed > WORST_NRMSE);
    let felt = problem.meanings().into_iter().enumerate().filter(|(k, _)| fit.normal.matrix[(*k, *k)] > 0.0);
    let mut starts = felt.filter_map(|(k, meaning)| Some((start(&meaning)?, fit.x[k]))).peekable();
    let stands = starts.peek().is_some() && starts.all(|(start, x)| start == x);
    let moved = !(stands && misses());
    if moved && !blind {
        return None;
    }
    match problem.singularity(&fit.x) {
        Some(Singular { expression, state, .. }) => Some(FitFailure::Singular {
            expression,
            state: system.states[state].name.clone(),
            value: fit.x[problem.segments[0].start + state],
        }),
        None => Some(FitFailure::Stuck),
    }
}

fn coefficients(fit: &Fit<'_>, bars: &ErrorBars<'_>) -> Vec<FoundTerm> {
    let terms = &fit.problem.terms;
    let coefficient =
        |k: usize| if terms.len() > PROFILED_TERMS { bars.quadratic(k) } else { bars.estimate(k) };
    (0..terms.len()).into_par_iter().map(|k| FoundTerm::new(terms[k], coefficient(k))).collect()
}

/// The unknowns of the result: coefficients, then parameters.
fn named(system: &System, fit: &Fit<'_>, moved: &[(usize, FoundParameter)]) -> Vec<(usize, Quantity)> {
    let terms = fit.problem.terms.iter().enumerate();
    let coefficients = terms.map(|(k, &t)| (k, Quantity::Coefficient(TermId::new(system, t))));
    coefficients.chain(moved.iter().map(|(k, p)| (*k, Quantity::Parameter(p.id.clone())))).collect()
}

/// What was done to the data.
fn notes(records: &[Record]) -> impl Iterator<Item = Warning> {
    let note = |r: &Record, note: &Note| Warning::DataNote { record: r.name.clone(), note: note.clone() };
    records.iter().flat_map(move |r| r.notes.iter().map(move |n| note(r, n)))
}

/// The normal equations of a fit with its inputs differentiated otherwise; `None` where none was derived.
fn differentiated_by(fit: &Fit<'_>, how: Differentiator) -> Option<crate::least_squares::Normal> {
    let problem = &fit.problem;
    if problem.records.iter().all(|r| r.derivations.is_empty()) {
        return None;
    }
    let records: Vec<Record> = problem.records.iter().map(|r| r.rederived(how)).collect::<Option<_>>()?;
    fit.normal_of(&records)
}

/// A covariance of these unknowns with the variance between records on its diagonal.
fn with_scatter(
    mut covariance: Vec<Vec<f64>>,
    of: &[usize],
    variance: impl Fn(usize) -> f64,
) -> Vec<Vec<f64>> {
    covariance.iter_mut().zip(of).enumerate().for_each(|(i, (row, &k))| row[i] += variance(k));
    covariance
}

/// A residual that is more than noise.
fn coloured(fit: &Fit<'_>) -> Option<Warning> {
    let independent = fit.effective / fit.samples.max(1) as f64;
    if independent < COLOURED_PART {
        Some(Warning::Coloured { independent })
    } else {
        (fit.chance_of_noise() < CHANCE_OF_NOISE).then_some(Warning::NotNoise)
    }
}

/// Records that no single run follows.
fn segmented(fit: &Fit<'_>) -> Option<Warning> {
    let pieces = fit.pieces.iter().max().copied().unwrap_or(1);
    (pieces > 1).then_some(Warning::Segmented { pieces })
}

/// The same numbers without the identified terms, start states open.
fn known_part(solution: Solution, records: &[Record]) -> Solution {
    Solution { terms: vec![], coefficients: vec![], starts: vec![None; records.len()], ..solution }
}

/// The path of the selection, with the worst NRMSE of the Fit records where it ended.
fn with_nrmse<'r>(
    mut path: Vec<PathPoint>,
    terms: usize,
    fitted: impl Iterator<Item = &'r RecordFit>,
) -> Vec<PathPoint> {
    let worst = fitted.map(RecordFit::worst).fold(0.0, f64::max);
    if let Some(point) = path.iter_mut().find(|p| p.terms == terms) {
        point.nrmse = worst.is_finite().then_some(worst);
    }
    path
}

/// The noise of each measured column of a fitted record.
fn noise_of(fit: &Fit<'_>, record: usize) -> Vec<(String, f64)> {
    let problem = &fit.problem;
    let columns = problem.records[record].columns.iter().enumerate();
    let noise = |k: usize| fit.noise[record][k].variance(problem.deviations[record][k]).sqrt();
    let named = |k: usize| (problem.system.measured(k).0.to_owned(), noise(k));
    columns.filter_map(|(k, column)| column.as_ref().map(|_| named(k))).collect()
}

/// The form of the noise, if it is one for all columns.
fn noise_model(fit: &Fit<'_>) -> NoiseModel {
    let problem = &fit.problem;
    let of_record = |i: usize| {
        let measured =
            (0..problem.system.columns()).filter(move |&k| problem.records[i].columns[k].is_some());
        measured.map(move |k| fit.noise[i][k].kind(problem.deviations[i][k]))
    };
    let mut kinds = (0..problem.records.len()).flat_map(of_record);
    match kinds.next() {
        Some(first) if kinds.all(|kind| kind == first) => first,
        _ => NoiseModel::Mixed,
    }
}
