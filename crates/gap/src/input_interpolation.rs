//! How an input goes between its samples. A spline through a force that a controller holds moves the model by
//! a fraction of a sample, which looks like a delay or a gain of a sensor. A force with a few samples in a
//! period may be drawn in several ways, and no effect smaller than their difference can be told.

use crate::decisions::SIMPLER;
use crate::model::{Fitted, Measure, TrialModel, current};
use crate::result::CoarseInput;
use phisindy_learn::{Effort, RecordFit, predicted};
use phisindy_phys::Record;
use phisindy_phys::spec::Role;
use phisindy_signal::{Interpolation, Signal};
use rayon::prelude::*;
use std::cell::OnceCell;
use std::sync::Arc;

const KINDS: [Interpolation; 3] = [Interpolation::Hold, Interpolation::Linear, Interpolation::Cubic];

/// A model that explains the data with its inputs drawn in another way.
pub(crate) struct Redrawn {
    pub(crate) fitted: Fitted,
    /// The model without effects, with the same inputs.
    pub(crate) base: Fitted,
    pub(crate) from: Interpolation,
    pub(crate) to: Interpolation,
}

/// The models of a path (no effect, one, two, ...), each with the inputs drawn in every other way. Returns
/// the best one that explains the data, if its criterion is lower than that of `last` or it has fewer effects
/// and does as well. `None` if there is none or no input is sampled.
pub(crate) fn redrawn(
    path: &[Fitted],
    last: &Fitted,
    noise: &[Vec<f64>],
    candidates: usize,
) -> Option<Redrawn> {
    let from = drawn(&last.model)?;
    let plain = path.first()?;
    let kinds = KINDS.into_iter().filter(|kind| *kind != from);
    let bases: Vec<(Interpolation, TrialModel)> =
        kinds.filter_map(|kind| Some((kind, with_inputs(&plain.settled(), kind)?))).collect();
    let trials: Vec<(Interpolation, &Fitted, TrialModel)> = bases
        .iter()
        .flat_map(|(kind, base)| {
            path.iter().filter_map(move |f| {
                let mut model = base.with_all(&current(f)).ok()?;
                f.starts(&mut model);
                Some((*kind, f, model))
            })
        })
        .collect();
    let fitted = trials.into_par_iter().filter_map(|(kind, own, model)| {
        // A fit is worth its time where the same numbers do better.
        let better = model.segment_cost(noise, 1)? < own.settled().segment_cost(noise, 1)?;
        let fitted = if better { Fitted::new(model, noise, Effort::Plain).ok()? } else { return None };
        fitted.score.explains().then_some((kind, fitted))
    });
    let all: Vec<(Interpolation, Fitted)> = fitted.collect();
    let by = Measure::of(all.iter().map(|(_, f)| &f.score).chain([&last.score]), candidates);
    let (to, best) =
        all.into_iter().min_by(|(_, a), (_, b)| by.criterion(&a.score).total_cmp(&by.criterion(&b.score)))?;
    let fewer = best.model.effects.len() < last.model.effects.len();
    let limit = if fewer { SIMPLER } else { -SIMPLER };
    let better = by.criterion(&best.score) - by.criterion(&last.score) < limit;
    if !better && last.score.explains() {
        return None;
    }
    let base = Fitted::new(best.model.without_effects(), noise, Effort::Plain).ok()?;
    Some(Redrawn { fitted: best, base, from, to })
}

/// The number of effects of a path (no effect, one, two, ...) that the drawing of the inputs leaves
/// determined, with what it leaves open. An effect that moves the model less than another drawing of the
/// inputs does may stand for that drawing, and so may what the last model leaves beyond the noise. `None` if
/// there is neither.
pub(crate) fn coarse_inputs(path: &[Fitted], noise: &[Vec<f64>]) -> Option<(usize, CoarseInput)> {
    let (base, last) = (path.first()?, path.last()?);
    let open = Drawing::of(base, noise).open()?;
    let moved = |k: usize| path[k - 1].difference(&path[k], Role::Fit, noise);
    let (left, effect) = match (1..path.len()).find(|&k| moved(k) < open) {
        Some(first) => (first - 1, moved(first)),
        None => (path.len() - 1, Some(beyond_noise(last)).filter(|left| *left > 0.0 && *left < open)?),
    };
    let inputs = last.model.system.inputs.iter().map(|u| u.name.clone()).collect();
    Some((left, CoarseInput { inputs, open: open.sqrt(), effect: effect.sqrt() }))
}

/// How much the drawing of the inputs between their samples leaves open, found when it is first asked for.
pub(crate) struct Drawing<'a> {
    /// The model without effects.
    base: &'a Fitted,
    noise: &'a [Vec<f64>],
    open: OnceCell<Option<f64>>,
}

impl<'a> Drawing<'a> {
    pub(crate) fn of(base: &'a Fitted, noise: &'a [Vec<f64>]) -> Drawing<'a> {
        Drawing { base, noise, open: OnceCell::new() }
    }

    /// Whether a model leaves less than another drawing of the inputs moves: no further effect can be made
    /// out.
    pub(crate) fn hides_the_rest(&self, of: &Fitted) -> bool {
        self.open().is_some_and(|open| beyond_noise(of) < open)
    }

    /// How much another drawing moves the model without effects: the mean square in units of the noise.
    /// `None` if no input is drawn between samples, or is held: that is what a controller puts out.
    fn open(&self) -> Option<f64> {
        let moved = || {
            let model = with_inputs(&self.base.settled(), other_drawing(&self.base.model)?)?;
            let with_its_numbers = moved(self.base, &model, self.noise)?;
            let redrawn = Fitted::new(model, self.noise, Effort::Thorough).ok()?;
            // A fit that ends in another minimum moves the model too, and no drawing did that.
            Some(self.base.difference(&redrawn, Role::Fit, self.noise).min(with_its_numbers))
        };
        *self.open.get_or_init(moved)
    }
}

/// How much the runs of the Fit records move if the records are those of another model, the numbers being the same:
/// the mean square in units of the noise.
pub(crate) fn moved(base: &Fitted, other: &TrialModel, noise: &[Vec<f64>]) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0usize);
    let records = base.cal.records.iter().zip(noise).filter(|(fit, _)| fit.role == Role::Fit);
    for (changes, (_, noise)) in changes(base, other)?.iter().zip(records) {
        for (changes, noise) in changes.iter().filter(|c| !c.is_empty()).zip(noise) {
            sum += changes.iter().map(|d| (d / noise).powi(2)).sum::<f64>();
            count += changes.len();
        }
    }
    Some(sum / count.max(1) as f64)
}

/// How the runs of the Fit records move if their inputs are drawn in another way, by record and measured column. `None`
/// where no input is drawn between its samples.
pub(crate) fn redrawn_runs(of: &Fitted) -> Option<Vec<Vec<Vec<f64>>>> {
    changes(of, &with_inputs(&of.settled(), other_drawing(&of.model)?)?)
}

/// How the runs of the Fit records move if the records are those of another model, by record and column; empty where a
/// column is not measured.
fn changes(base: &Fitted, other: &TrialModel) -> Option<Vec<Vec<Vec<f64>>>> {
    let settled = base.settled();
    let records = base.model.records.iter().zip(other.records.iter()).zip(&base.cal.records);
    let of = |((own, other), fit): ((&Record, &Record), &RecordFit)| {
        let run = |record: &Record| predicted(&settled.system, record, &fit.start, &[]).ok();
        let columns = own.columns.iter().zip(run(own)?.into_iter().zip(run(other)?));
        let change = |(column, (a, b)): (&Option<_>, (Vec<f64>, Vec<f64>))| match column {
            Some(_) => a.iter().zip(&b).map(|(a, b)| a - b).collect(),
            None => vec![],
        };
        Some(columns.map(change).collect())
    };
    records.filter(|(_, fit)| fit.role == Role::Fit).map(of).collect()
}

/// What a model leaves beyond the noise, on Fit or Validate records, whichever is more: the mean square in
/// units of the noise. An effect that lowers it moves the model no more, where the model is linear in it: the
/// residual of a least-squares fit is orthogonal to what the fit moves.
pub(crate) fn beyond_noise(of: &Fitted) -> f64 {
    (of.score.gap().max(of.score.fit).powi(2) - 1.0).max(0.0)
}

/// The other smooth way to draw the inputs; `None` where they are not drawn between samples, or are held: that is what a
/// controller puts out.
fn other_drawing(model: &TrialModel) -> Option<Interpolation> {
    match drawn(model)? {
        Interpolation::Hold => None,
        Interpolation::Linear => Some(Interpolation::Cubic),
        Interpolation::Cubic => Some(Interpolation::Linear),
    }
}

/// How the inputs of the Fit records are drawn; `None` where they are not drawn from samples, or not all in
/// one way, or where one is derived from another.
fn drawn(model: &TrialModel) -> Option<Interpolation> {
    let records = model.records.iter().filter(|r| r.role == Role::Fit);
    let mut kinds = records.clone().flat_map(|r| &r.inputs).map(Signal::kind);
    let first = kinds.next()?;
    (kinds.all(|kind| kind == first) && model.records.iter().all(|r| r.derivations.is_empty()))
        .then_some(first)
}

/// A model without effects with the inputs of all records drawn in this way.
fn with_inputs(model: &TrialModel, kind: Interpolation) -> Option<TrialModel> {
    let mut out = model.clone();
    let change = |record: &mut Record| -> Option<()> {
        for signal in &mut record.inputs {
            *signal = Signal::new(signal.time().clone(), signal.values().to_vec(), kind).ok()?;
        }
        Some(())
    };
    Arc::make_mut(&mut out.records).iter_mut().try_for_each(change)?;
    Arc::make_mut(&mut out.smooth).iter_mut().try_for_each(change)?;
    Some(out)
}
