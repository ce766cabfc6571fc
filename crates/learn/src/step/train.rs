//! Method `step`: Algorithm 2 of the paper. Training in stages, with a cut after each; terms that were cut
//! stay out. Or Gauss-Newton on the same loss, which reaches the same minimum in a few iterations and can
//! also move constants.

use crate::decisions::{OBSERVED_EPOCHS, STEP_GAIN, STEP_ITERATIONS};
use crate::least_squares::{Limits, Normal, minimise};
use crate::linear::{covariance, symmetric};
use crate::result::identified::StopReason;
use crate::step::batch::{Batch, lay_out};
use crate::step::descent::Descent;
use crate::step::options::StepOptions;
use phisindy_expr::Cost;
use phisindy_phys::spec::Optimiser;
use phisindy_phys::{Record, System};
use std::ops::ControlFlow;

/// The result of the step method.
#[derive(Clone, Debug)]
pub struct StepFit {
    /// Terms that survived (indices into [`System::terms`]).
    pub terms: Vec<usize>,
    /// Their coefficients.
    pub coefficients: Vec<f64>,
    /// Values of [`System::parameters`].
    pub parameters: Vec<f64>,
    /// Covariance of coefficients, then parameters, from the curvature of the loss (it does not know the bias
    /// of the loss); zero for fixed constants.
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

/// Fits the dictionary to records that have samples of every state. `observe` receives the progress (a
/// fraction) and may stop it.
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
    let mut fit = StepFit::start(system);
    let mut stage = 0;
    loop {
        let batch = lay_out(system, records, options, &fit.terms, &fit.parameters);
        fit.cost = fit.cost.max(batch.cost());
        let mut bounds: Vec<(f64, f64)> = fit.terms.iter().map(|&t| system.terms[t].within).collect();
        let mut values = fit.coefficients.clone();
        clamp(&mut values, &bounds);
        let (loss, interrupted) = if gauss_newton {
            values.extend(&fit.parameters);
            bounds.extend(system.parameters.iter().map(|p| p.within));
            let loss = solve(&batch, &mut values, &bounds);
            fit.parameters = values.split_off(fit.terms.len());
            (loss, observe((stage as f64 + 1.0) / (stage as f64 + 2.0)).is_break())
        } else {
            descend(&batch, &mut values, &bounds, options, stage, observe)
        };
        fit.coefficients = values;
        fit.stages.push((fit.terms.len(), loss));
        if !loss.is_finite() {
            // Cutting would hide it: NaN compares as below the cut-off.
            return fit.without_end(loss);
        }
        let cut = fit.cut(options.cutoff);
        stage += 1;
        if interrupted {
            fit.stop_reason = StopReason::Interrupted;
        }
        // Gauss-Newton repeats until nothing is cut; descent has its stages.
        let finished = if gauss_newton { !cut } else { stage >= options.epochs.len() };
        if finished || interrupted {
            break;
        }
    }
    let batch = lay_out(system, records, options, &fit.terms, &fit.parameters);
    fit.with_errors(&batch, gauss_newton)
}

impl StepFit {
    /// All terms, at zero.
    fn start(system: &System) -> StepFit {
        StepFit {
            terms: (0..system.terms.len()).collect(),
            coefficients: vec![0.0; system.terms.len()],
            parameters: system.parameters.iter().map(|p| p.start).collect(),
            covariance: vec![],
            loss: f64::NAN,
            stages: vec![],
            cost: Cost::default(),
            stop_reason: StopReason::Finished,
        }
    }

    /// Removes the terms with coefficients below the cut-off; whether there were any.
    fn cut(&mut self, cutoff: f64) -> bool {
        let kept: Vec<usize> =
            (0..self.terms.len()).filter(|&k| self.coefficients[k].abs() >= cutoff).collect();
        let cut = kept.len() < self.terms.len();
        self.terms = kept.iter().map(|&k| self.terms[k]).collect();
        self.coefficients = kept.iter().map(|&k| self.coefficients[k]).collect();
        cut
    }

    /// The fit whose loss is not a number: nothing is known of its values.
    fn without_end(self, loss: f64) -> StepFit {
        let n = self.coefficients.len() + self.parameters.len();
        let unknown = |i: usize| (0..n).map(|j| if i == j { f64::INFINITY } else { 0.0 }).collect();
        let covariance = (0..n).map(unknown).collect();
        StepFit { covariance, loss, stop_reason: StopReason::LossNotFinite, ..self }
    }

    /// The fit with its loss and its covariance, from the curvature of the loss where it ended.
    fn with_errors(self, batch: &Batch, gauss_newton: bool) -> StepFit {
        let mut values = self.coefficients.clone();
        if gauss_newton {
            values.extend(&self.parameters);
        }
        let (loss, triangle, _) = batch.normal(&values);
        let n = values.len();
        let freedom = (batch.residuals.saturating_sub(n)).max(1) as f64;
        let inverse = covariance(&symmetric(&triangle, n));
        let all = self.coefficients.len() + self.parameters.len();
        let entry = |i: usize, j: usize| if i.max(j) < n { inverse[(i, j)] * loss / freedom } else { 0.0 };
        let covariance = (0..all).map(|i| (0..all).map(|j| entry(i, j)).collect()).collect();
        StepFit { covariance, loss, ..self }
    }
}

fn clamp(values: &mut [f64], bounds: &[(f64, f64)]) {
    values.iter_mut().zip(bounds).for_each(|(x, within)| *x = x.clamp(within.0, within.1));
}

/// One stage of gradient descent: the loss at its end, and whether the observer stopped it.
fn descend(
    batch: &Batch,
    values: &mut [f64],
    bounds: &[(f64, f64)],
    options: &StepOptions,
    stage: usize,
    observe: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> (f64, bool) {
    let mut descent = match options.optimiser {
        Optimiser::Sgd => Descent::Sgd,
        _ => Descent::radam(values.len()),
    };
    let total: u32 = options.epochs.iter().sum();
    let mut done: u32 = options.epochs[..stage].iter().sum();
    let mut gradient = vec![0.0; values.len()];
    let (mut left, mut interrupted) = (options.epochs[stage], false);
    while left > 0 && !interrupted {
        let now = left.min(OBSERVED_EPOCHS);
        // Inside the pool its threads stay awake between epochs.
        rayon::scope(|_| {
            for _ in 0..now {
                batch.loss(values, &mut gradient);
                descent.update(values, &gradient, options.rates[stage]);
                clamp(values, bounds);
            }
        });
        left -= now;
        done += now;
        interrupted = observe(f64::from(done) / f64::from(total)).is_break();
    }
    (batch.loss(values, &mut gradient), interrupted)
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

/// Solves the loss within bounds; returns the loss at the end.
fn solve(batch: &Batch, values: &mut [f64], bounds: &[(f64, f64)]) -> f64 {
    let n = values.len();
    let evaluate = |x: &[f64], _| {
        let (cost, triangle, gradient) = batch.normal(x);
        cost.is_finite().then(|| Normal { cost, matrix: symmetric(&triangle, n), gradient })
    };
    minimise(values, bounds, Limits::new(STEP_ITERATIONS, STEP_GAIN), evaluate)
        .map_or(f64::NAN, |end| end.cost)
}
