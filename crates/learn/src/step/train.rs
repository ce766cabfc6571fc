//! Method `step`: Algorithm 2 of the paper. Stages of training, a cut after each; what was cut stays zero. Or the same loss solved by
//! Gauss-Newton, which lands on the same minimum in a few iterations and can move constants.

use crate::least_squares::{Limits, Normal, minimise};
use crate::linear::{covariance, symmetric};
use crate::result::identified::StopReason;
use crate::step::batch::{Batch, deviations};
use crate::step::descent::Descent;
use crate::step::onestep::OneStep;
use phisindy_expr::Cost;
use phisindy_phys::spec::{Crossings, Optimiser};
use phisindy_phys::{Record, System};
use std::collections::HashMap;
use std::ops::ControlFlow;

/// Epochs between two looks at the user.
const UNOBSERVED: u32 = 16;

/// How the step method learns; the defaults are the paper's (Table 4).
#[derive(Clone, Debug, PartialEq)]
pub struct StepOptions {
    /// Which optimiser.
    pub optimiser: Optimiser,
    /// Epochs of each stage.
    pub epochs: Vec<u32>,
    /// Learning rate of each stage.
    pub rates: Vec<f64>,
    /// Coefficients smaller than this are cut after each stage.
    pub cutoff: f64,
    /// Speed below which a contact counts as stuck (SI).
    pub tolerance: f64,
    /// Steps that are unrolled.
    pub horizon: usize,
    /// Whether steps across a change of sign are used.
    pub crossings: Crossings,
}

impl Default for StepOptions {
    fn default() -> Self {
        StepOptions {
            optimiser: Optimiser::RAdam,
            epochs: vec![1000, 1000, 1000],
            rates: vec![0.1, 0.01, 0.001],
            cutoff: 0.05,
            tolerance: 1e-3,
            horizon: 1,
            crossings: Crossings::Keep,
        }
    }
}

/// What the step method found.
#[derive(Clone, Debug)]
pub struct StepFit {
    /// Terms that survived (indices into [`System::terms`]).
    pub terms: Vec<usize>,
    /// Their coefficients.
    pub coefficients: Vec<f64>,
    /// Values of [`System::parameters`].
    pub parameters: Vec<f64>,
    /// Covariance of coefficients, then parameters, from the curvature of the loss (it does not know the bias of the loss); zero for what was held.
    pub covariance: Vec<Vec<f64>>,
    /// Loss at the end.
    pub loss: f64,
    /// Terms and loss after each stage.
    pub stages: Vec<(usize, f64)>,
    /// What the loss costs per sample and direction, with all terms.
    pub cost: Cost,
    /// Why it ended.
    pub stop_reason: StopReason,
}

impl StepFit {
    /// Standard errors of coefficients, then parameters.
    pub fn std_errors(&self) -> Vec<f64> {
        self.covariance.iter().enumerate().map(|(k, row)| row[k].sqrt()).collect()
    }
}

/// Fits the dictionary to records that have samples of every state. `observe` hears of the progress (a fraction) and may stop it.
///
/// ```
/// use phisindy_learn::{StepOptions, train};
/// use phisindy_phys::{Origin, SourceId, check, spec};
/// use phisindy_sim::synthesize;
/// use std::ops::ControlFlow;
/// let text = r#"(states: { "x": "m", "v": "m/s" }, constants: { "k": (1.0, "1/s^2") }, known: { "x": "v", "v": "-k*x" },
///     unknown: { "v": (factor: "-sgn(v)", candidates: ["1", "x"]) }, contacts: ["v"],
///     data: [ Synthetic(truth: { "v": "-0.3*sgn(v)" }, start: { "x": 2.0, "v": 0.0 }, duration: 10.0, step: 0.01, noise: Relative(0), seed: 1) ])"#;
/// let (spec, _) = spec::read(text, SourceId(0)).unwrap();
/// let (case, _) = check(&spec, SourceId(0)).unwrap();
/// let Origin::Synthetic(truth) = &case.records[0].origin else { panic!("a measured record") };
/// let (record, _) = synthesize(&case.records[0], truth, &case.system, None, &|_| Err("no files here".into())).unwrap();
/// let options = StepOptions { epochs: vec![300, 100], rates: vec![0.1, 0.01], ..StepOptions::default() };
/// let fit = train(&case.system, &[&record], &options, &mut |_| ControlFlow::Continue(()));
/// // Clean data: the cut-off leaves the one true term.
/// assert!(fit.terms == [0] && (fit.coefficients[0] - 0.3).abs() < 0.01);
/// ```
pub fn train(
    system: &System,
    records: &[&Record],
    options: &StepOptions,
    observe: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> StepFit {
    let gauss_newton = options.optimiser == Optimiser::GaussNewton;
    let mut terms: Vec<usize> = (0..system.terms.len()).collect();
    let mut coefficients = vec![0.0; terms.len()];
    let mut moved: Vec<f64> = system.parameters.iter().map(|p| p.start).collect();
    let mut fit = StepFit {
        terms: vec![],
        coefficients: vec![],
        parameters: vec![],
        covariance: vec![],
        loss: f64::NAN,
        stages: vec![],
        cost: Cost::default(),
        stop_reason: StopReason::Finished,
    };
    let mut stopped = false;
    let make = |terms: &[usize], parameters: &[f64]| lay_out(system, records, options, terms, parameters);
    let total: u32 = options.epochs.iter().sum();
    let mut done = 0;
    let mut stage = 0;
    loop {
        let batch = make(&terms, &moved);
        fit.cost = fit.cost.max(batch.cost());
        let within = |k: usize| system.terms[terms[k]].within;
        let bound = |values: &mut [f64]| {
            values.iter_mut().enumerate().for_each(|(k, c)| *c = c.clamp(within(k).0, within(k).1));
        };
        let mut values = coefficients.clone();
        bound(&mut values);
        let loss = if gauss_newton {
            values.extend(&moved);
            let bounds: Vec<(f64, f64)> =
                (0..terms.len()).map(within).chain(system.parameters.iter().map(|p| p.within)).collect();
            let loss = solve(&batch, &mut values, &bounds);
            moved = values.split_off(terms.len());
            stopped = observe((stage as f64 + 1.0) / (stage as f64 + 2.0)).is_break();
            loss
        } else {
            let mut descent = match options.optimiser {
                Optimiser::Sgd => Descent::Sgd,
                _ => Descent::radam(values.len()),
            };
            let mut gradient = vec![0.0; values.len()];
            let mut left = options.epochs[stage];
            while left > 0 && !stopped {
                let now = left.min(UNOBSERVED);
                // Inside of the pool its threads stay awake from epoch to epoch.
                rayon::scope(|_| {
                    for _ in 0..now {
                        batch.loss(&values, &mut gradient);
                        descent.update(&mut values, &gradient, options.rates[stage]);
                        bound(&mut values);
                    }
                });
                left -= now;
                done += now;
                stopped = observe(f64::from(done) / f64::from(total)).is_break();
            }
            batch.loss(&values, &mut gradient)
        };
        coefficients = values;
        if !loss.is_finite() {
            // Cutting would hide it: what is not a number is not at least the cut-off.
            fit.stages.push((terms.len(), loss));
            let n = coefficients.len() + moved.len();
            let unknown = |i: usize| (0..n).map(|j| if i == j { f64::INFINITY } else { 0.0 }).collect();
            fit.covariance = (0..n).map(unknown).collect();
            let stop_reason = StopReason::LossNotFinite;
            return StepFit { terms, coefficients, parameters: moved, loss, stop_reason, ..fit };
        }
        let kept: Vec<usize> =
            (0..terms.len()).filter(|&k| coefficients[k].abs() >= options.cutoff).collect();
        let cut = kept.len() < terms.len();
        fit.stages.push((terms.len(), loss));
        terms = kept.iter().map(|&k| terms[k]).collect();
        coefficients = kept.iter().map(|&k| coefficients[k]).collect();
        stage += 1;
        // Gauss-Newton repeats until nothing is cut; descent has its stages.
        let finished = if gauss_newton { !cut } else { stage >= options.epochs.len() };
        if finished || stopped {
            break;
        }
    }
    let batch = make(&terms, &moved);
    let mut values = coefficients.clone();
    if gauss_newton {
        values.extend(&moved);
    }
    let (loss, triangle, _) = batch.normal(&values);
    let n = values.len();
    let freedom = batch.residuals.saturating_sub(n).max(1) as f64;
    let inverse = covariance(&symmetric(&triangle, n));
    let all = coefficients.len() + moved.len();
    let entry = |i: usize, j: usize| if i.max(j) < n { inverse[(i, j)] * loss / freedom } else { 0.0 };
    fit.covariance = (0..all).map(|i| (0..all).map(|j| entry(i, j)).collect()).collect();
    fit.loss = loss;
    if stopped {
        fit.stop_reason = StopReason::Interrupted;
    }
    fit.terms = terms;
    fit.coefficients = coefficients;
    fit.parameters = moved;
    fit
}

/// The normal equations of the loss where a fit ended, on the same or on other records.
pub(crate) fn normal_of_steps(
    system: &System,
    records: &[&Record],
    options: &StepOptions,
    fit: &StepFit,
) -> Normal {
    let mut values = fit.coefficients.clone();
    if options.optimiser == Optimiser::GaussNewton {
        values.extend(&fit.parameters);
    }
    let (cost, triangle, gradient) =
        lay_out(system, records, options, &fit.terms, &fit.parameters).normal(&values);
    Normal { cost, matrix: symmetric(&triangle, values.len()), gradient }
}

/// The loss of some terms; `parameters` are the values of what is held.
pub(crate) fn lay_out(
    system: &System,
    records: &[&Record],
    options: &StepOptions,
    terms: &[usize],
    parameters: &[f64],
) -> Batch {
    let gauss_newton = options.optimiser == Optimiser::GaussNewton;
    let model = system.model(terms);
    let mut step = OneStep::new(system, &model, options.tolerance);
    // What is held becomes a number; what moves stays, but for telling which steps cross a change of direction.
    let held: HashMap<_, _> =
        system.parameters.iter().zip(parameters).map(|(p, &v)| (p.node, step.graph.constant(v))).collect();
    step.contacts = step.graph.replace(&step.contacts, &held);
    if !gauss_newton {
        step.next = step.graph.replace(&step.next, &held);
        step.parameters.retain(|id| !held.contains_key(id));
    }
    let free = if gauss_newton { terms.len() + parameters.len() } else { terms.len() };
    Batch::new(&step, free, records, &deviations(system, records), options)
}

/// Solves the loss within bounds; returns the loss at the end.
fn solve(batch: &Batch, values: &mut [f64], bounds: &[(f64, f64)]) -> f64 {
    let n = values.len();
    let evaluate = |x: &[f64], _| {
        let (cost, triangle, gradient) = batch.normal(x);
        cost.is_finite().then(|| Normal { cost, matrix: symmetric(&triangle, n), gradient })
    };
    minimise(values, bounds, Limits::new(60, 1e-14), evaluate).map_or(f64::NAN, |end| end.cost)
}
