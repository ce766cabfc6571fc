//! The one-step loss over all samples: data laid out once, evaluated many times, on all cores.

use crate::step::onestep::OneStep;
use crate::step::options::StepOptions;
use crate::step::rollout::Rollout;
use crate::step::single::Single;
use crate::step::windows::{deviations, step_contacts, window_starts};
use phisindy_expr::Cost;
use phisindy_phys::spec::Optimiser;
use phisindy_phys::{Record, System};
use std::collections::HashMap;

/// The loss of the paper: mean squared error of the forward and of the backward prediction, each state in
/// units of its standard deviation, over `horizon` steps.
pub(crate) struct Batch {
    kind: Kind,
    /// Number of coefficients and movable constants.
    pub(crate) parameters: usize,
    /// Number of residuals: samples times states times directions times horizon.
    pub(crate) residuals: usize,
}

enum Kind {
    /// One step: what depends on data alone is evaluated once.
    Single(Box<Single>),
    /// Several steps, rolled out.
    Rollout(Box<Rollout>),
}

impl Batch {
    /// Lays out the data of all records. Every record must have samples of every state; `constants[r]` are
    /// the record constants.
    pub(crate) fn new(
        step: &OneStep,
        free: usize,
        records: &[&Record],
        deviations: &[f64],
        options: &StepOptions,
    ) -> Batch {
        let horizon = options.horizon;
        let n = step.states.len();
        let starts: Vec<Vec<usize>> =
            records.iter().map(|r| window_starts(&step_contacts(step, free, r), r.len(), options)).collect();
        let steps: usize = starts.iter().map(Vec::len).sum();
        let residuals = 2 * n * steps * horizon;
        let weight = (1.0 / (n * horizon * steps.max(1)) as f64).sqrt();
        let weights: Vec<f64> = deviations.iter().map(|d| weight / d).collect();
        let kind = if horizon > 1 {
            let rollout = Rollout::new(step.clone(), free, records, &starts, &weights, horizon);
            Kind::Rollout(Box::new(rollout))
        } else {
            Kind::Single(Box::new(Single::new(step, free, records, &starts, &weights)))
        };
        Batch { kind, parameters: free, residuals }
    }

    /// What the loss tape costs per sample and direction.
    pub(crate) fn cost(&self) -> Cost {
        match &self.kind {
            Kind::Single(single) => single.cost(),
            Kind::Rollout(rollout) => rollout.cost(),
        }
    }

    /// The loss and its gradient.
    pub(crate) fn loss(&self, parameters: &[f64], gradient: &mut [f64]) -> f64 {
        let sums = match &self.kind {
            Kind::Single(single) => single.loss(parameters),
            Kind::Rollout(rollout) => rollout.loss(parameters),
        };
        gradient.copy_from_slice(&sums[1..]);
        sums[0]
    }

    /// The loss and the normal equations of its Gauss-Newton step: upper triangle of `J^T J` row by row, then
    /// `J^T e`.
    pub(crate) fn normal(&self, parameters: &[f64]) -> (f64, Vec<f64>, Vec<f64>) {
        let p = self.parameters;
        let sums = match &self.kind {
            Kind::Single(single) => single.normal(parameters),
            Kind::Rollout(rollout) => rollout.normal(parameters),
        };
        let (triangle, right) = sums[1..].split_at(p * (p + 1) / 2);
        (sums[0], triangle.to_vec(), right.to_vec())
    }
}

/// Lays out the loss of some terms; `parameters` are the values of fixed constants.
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
    // Fixed constants become numbers. Free ones become numbers in the contacts alone, which tell crossing
    // steps.
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

#[cfg(test)]
mod tests;
