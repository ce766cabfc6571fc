//! A model with its numbers: calibrated, scored, compared with noise.

use super::score::Score;
use super::trial_model::TrialModel;
use crate::decisions::{CHOW, LITTLE_LEFT, NOT_WHITE, RESTS, STANDS_STILL};
use crate::place::Effect;
use crate::result::ModelError;
use crate::whiteness::score;
use phisindy_learn::{Calibration, Effort, FoundParameter, RecordFit, calibrate};
use phisindy_phys::spec::Role;
use phisindy_phys::{Parameter, Record};
use phisindy_signal::noise_level;
use std::sync::Arc;

/// A calibrated model.
#[derive(Clone, Debug)]
pub(crate) struct Fitted {
    pub(crate) model: TrialModel,
    pub(crate) cal: Calibration,
    pub(crate) score: Score,
    /// Fit and Validate records fitted together, where that moves the numbers no further than their errors allow.
    joint: Option<Calibration>,
}

impl Fitted {
    /// Calibrates a model.
    pub(crate) fn new(model: TrialModel, noise: &[Vec<f64>], effort: Effort) -> Result<Fitted, ModelError> {
        let cal = calibrate(&model.system, &model.records, &model.smooth, noise, effort)?;
        let (fit, validate) = gaps(&cal, noise);
        let whiteness = whiteness(&cal, &model.records, |_| true);
        let effects = || model.effects.iter().map(|a| &a.effect);
        let score = Score {
            fit,
            validate,
            predictive: validate,
            whiteness,
            samples: cal.samples,
            effective: cal.effective,
            effects: model.effects.len(),
            parameters: effects().map(|e| e.entry.law.parameters.len()).sum(),
            sensors: effects().filter(|e| e.entry.law.sensor.is_some()).count(),
            early: 0,
        };
        let mut alone = Fitted { model, cal, score, joint: None };
        alone.score.early = alone.early_sensors();
        Ok(match alone.together(noise) {
            Some((joint, whiteness)) => {
                alone.score.whiteness = whiteness;
                Fitted { joint: Some(joint), ..alone }.measured_by(noise)
            }
            None => alone,
        })
    }

    /// Sensors that would have to show what has not happened yet.
    fn early_sensors(&self) -> usize {
        let delays =
            self.model.effects.iter().filter(|a| a.effect.entry.law.sensor.as_deref() == Some("delay"));
        delays.filter(|a| values(self, &a.names, &a.effect.start).iter().any(|v| *v < 0.0)).count()
    }

    /// Fit and Validate records fitted together, and the whiteness score of what that leaves, where it decides: on Fit records nothing but
    /// noise is left, and what is left on Validate records may come from the errors of starts and parameters. It does if the same model
    /// leaves nothing but noise on both, and Fit records are fitted no worse than chance has it (the predictive test of Chow 1960, doi
    /// 10.2307/1910133). The fit itself stays as it is.
    fn together(&self, noise: &[Vec<f64>]) -> Option<(Calibration, f64)> {
        if self.score.validate.is_none() || self.score.fit > LITTLE_LEFT || self.score.is_white() {
            return None;
        }
        if whiteness(&self.cal, &self.model.records, |r| r.role == Role::Fit) >= NOT_WHITE {
            return None;
        }
        let model = self.settled();
        let joint = |records: &[Record]| -> Vec<Record> {
            records.iter().map(|r| Record { role: Role::Fit, continues: None, ..r.clone() }).collect()
        };
        let (records, smooth) = (joint(&model.records), joint(&model.smooth));
        let cal = calibrate(&model.system, &records, &smooth, noise, Effort::Plain).ok()?;
        let fits = of(&self.cal, Role::Fit);
        let rise = power(&cal, noise, &fits).0 - power(&self.cal, noise, &fits).0;
        // The rise of chi^2 that as many numbers make by chance, five standard deviations high.
        let freedom = (self.cal.moved + fits.len() * model.system.states.len()) as f64;
        let chance = freedom + CHOW * (2.0 * freedom).sqrt();
        let whiteness = whiteness(&cal, &records, |_| true);
        (rise < chance && whiteness < NOT_WHITE).then_some((cal, whiteness))
    }

    /// The noise as its residuals have it, by record and state: what a model that leaves nothing but noise shows better than the columns do, in which the motion
    /// covers most of the spectrum.
    pub(crate) fn noise(&self, noise: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let of = |residual: &Vec<f64>, noise: f64| {
            if residual.is_empty() { noise } else { noise_level(residual).max(f64::MIN_POSITIVE) }
        };
        let record = |r: usize| {
            let residuals = &self.cal.records[r].residuals;
            noise[r].iter().enumerate().map(|(k, &s)| residuals.get(k).map_or(s, |e| of(e, s))).collect()
        };
        (0..noise.len()).map(record).collect()
    }

    /// Its gaps in units of this noise.
    pub(crate) fn measured_by(mut self, noise: &[Vec<f64>]) -> Fitted {
        (self.score.fit, self.score.validate) = gaps(&self.cal, noise);
        self.score.predictive = self.score.validate;
        if let Some(joint) = &self.joint {
            let (fits, validates) = (of(&self.cal, Role::Fit), of(&self.cal, Role::Validate));
            let rise = power(joint, noise, &fits).0 - power(&self.cal, noise, &fits).0;
            let (left, samples) = power(joint, noise, &validates);
            self.score.predictive = Some(((left + rise.max(0.0)) / samples.max(1) as f64).sqrt());
        }
        self
    }

    /// Whether its runs come to rest for more than a moment.
    pub(crate) fn rests(&self) -> bool {
        self.cal.records.iter().filter_map(|r| r.run.as_ref()).any(|run| {
            let still = run.modes.iter().filter(|m| **m == 0).count();
            RESTS * still > run.modes.len().max(1)
        })
    }

    /// Whether it follows the motion in any column of the records that count: those of the role Validate, if there are any.
    pub(crate) fn follows(&self) -> bool {
        let role = if self.score.validate.is_some() { Role::Validate } else { Role::Fit };
        let counts = self.cal.records.iter().filter(|r| r.role == role);
        counts.flat_map(|r| &r.nrmse).any(|(_, left)| *left < STANDS_STILL)
    }

    /// Whether there is a clearance in it: a body that strikes a stop answers in a way that no linear response knows.
    pub(crate) fn strikes(&self) -> bool {
        self.model.effects.iter().any(|a| a.effect.entry.law.has_clearance())
    }

    /// Whether other starts are worth a try: what is left is more than noise, and not so much that the model is simply wrong.
    pub(crate) fn may_gain(&self) -> bool {
        phisindy_learn::RESTART_RANGE.contains(&self.score.fit.powi(2))
    }

    /// The constants that moved, with the values that were found; of those with a value for each record that of the first one.
    pub(crate) fn found(&self, which: impl Fn(&Parameter) -> bool) -> Vec<(String, f64)> {
        let parameters = &self.model.system.parameters;
        let of = |p: &FoundParameter| {
            let parameter = &parameters[p.id.constant().filter(|_| p.id.holds_in(0))?];
            which(parameter).then(|| (parameter.name.clone(), p.estimate.value))
        };
        self.cal.parameters.iter().filter_map(of).collect()
    }

    /// The model with every movable number starting where this fit ended.
    pub(crate) fn settled(&self) -> TrialModel {
        let mut model = self.model.starting_at(&self.found(|_| true));
        self.starts(&mut model);
        model
    }

    /// Lets a model of the same records start where this fit started its runs.
    pub(crate) fn starts(&self, model: &mut TrialModel) {
        for (smooth, record) in Arc::make_mut(&mut model.smooth).iter_mut().zip(&self.cal.records) {
            for (column, start) in smooth.columns.iter_mut().zip(&record.start) {
                if let (Role::Fit, Some(column)) = (record.role, column) {
                    column[0] = *start;
                }
            }
        }
    }
}

/// The largest whiteness score of any column of some of the records; infinite where a run fails.
fn whiteness(cal: &Calibration, records: &[Record], of: impl Fn(&RecordFit) -> bool) -> f64 {
    let mut worst = 0.0_f64;
    for (replay, record) in cal.records.iter().zip(records).filter(|(replay, _)| of(replay)) {
        for (residual, column) in replay.residuals.iter().zip(&record.columns) {
            if let (false, Some(column)) = (residual.is_empty(), column) {
                worst = worst.max(score(residual, column));
            }
        }
        if replay.run.is_none() {
            worst = f64::INFINITY;
        }
    }
    worst
}

/// The records of one role.
fn of(cal: &Calibration, role: Role) -> Vec<usize> {
    (0..cal.records.len()).filter(|&r| cal.records[r].role == role).collect()
}

/// Sum of (residual / noise)^2 over some of the records, and how many samples that are; infinite where a run fails.
fn power(cal: &Calibration, noise: &[Vec<f64>], of: &[usize]) -> (f64, usize) {
    let (mut sum, mut count) = (0.0, 0);
    for &r in of {
        if cal.records[r].run.is_none() {
            return (f64::INFINITY, 1);
        }
        for (residual, noise) in cal.records[r].residuals.iter().zip(&noise[r]) {
            sum += residual.iter().map(|e| (e / noise).powi(2)).sum::<f64>();
            count += residual.len();
        }
    }
    (sum, count)
}

/// rms of residual / noise over the Fit records, and over the Validate records; infinite where a run fails.
fn gaps(cal: &Calibration, noise: &[Vec<f64>]) -> (f64, Option<f64>) {
    let gap = |role: Role| -> Option<f64> {
        let (sum, count) = power(cal, noise, &of(cal, role));
        (count > 0).then(|| (sum / count as f64).sqrt())
    };
    (gap(Role::Fit).unwrap_or(f64::INFINITY), gap(Role::Validate))
}

/// The effects of a fitted model, from where its fit ended.
pub(crate) fn current(now: &Fitted) -> Vec<Effect> {
    let own = |name: &str| now.model.effects.iter().any(|a| a.names.iter().any(|n| n == name));
    let beside = now.found(|p| !p.each && !own(&p.name));
    let of = |a: &super::Applied| Effect {
        start: values(now, &a.names, &a.effect.start),
        beside: beside.clone(),
        ..a.effect.clone()
    };
    now.model.effects.iter().map(of).collect()
}

/// The values that a fit found for an effect's parameters.
pub(crate) fn values(fitted: &Fitted, names: &[String], otherwise: &[f64]) -> Vec<f64> {
    names
        .iter()
        .zip(otherwise)
        .map(|(name, other)| {
            let found =
                fitted.cal.parameters.iter().find(|p| {
                    p.id.constant().is_some_and(|k| fitted.model.system.parameters[k].name == *name)
                });
            found.map_or(*other, |p| p.estimate.value)
        })
        .collect()
}
