//! A fitted model: calibration, score and residual noise.

use super::error::ModelError;
use super::input_error::{ColumnError, input_errors, rms};
use super::occam_factor::OccamFactor;
use super::score::Score;
use super::trial_model::TrialModel;
use crate::decisions::{CHANCE, CHOW, LITTLE_LEFT, NOT_WHITE, RESTS, STANDS_STILL};
use crate::model::records::{growing_noise, least_noise_of};
use crate::place::Effect;
use crate::whiteness::score;
use phisindy_learn::{Calibration, Effort, FoundParameter, RecordFit, SegmentFit, calibrate, calibrate_from};
use phisindy_phys::spec::Role;
use phisindy_phys::{Parameter, Record};
use phisindy_signal::noise_level_at;
use std::borrow::Cow;
use std::sync::Arc;

/// A calibrated model.
#[derive(Clone, Debug)]
pub(crate) struct Fitted {
    pub(crate) model: TrialModel,
    pub(crate) cal: Calibration,
    pub(crate) score: Score,
    /// Joint fit of Fit and Validate records, where it moves the parameters no further than their errors
    /// allow.
    joint: Option<Calibration>,
    /// What the Validate records leave, where it is the error of the inputs between their samples; else
    /// empty.
    pub(crate) input_errors: Vec<ColumnError>,
}

/// A joint fit of Fit and Validate records that these allow.
struct Together {
    cal: Calibration,
    /// The whiteness score of the columns that leave no error of the inputs.
    whiteness: f64,
    input_errors: Vec<ColumnError>,
}

impl Fitted {
    /// Calibrates a model.
    pub(crate) fn new(model: TrialModel, noise: &[Vec<f64>], effort: Effort) -> Result<Fitted, ModelError> {
        Fitted::from(model, None, noise, effort)
    }

    /// Calibrates a model from where the fit over its segments ended.
    pub(crate) fn from(
        mut model: TrialModel,
        segments: Option<&SegmentFit>,
        noise: &[Vec<f64>],
        effort: Effort,
    ) -> Result<Fitted, ModelError> {
        let TrialModel { system, records, smooth, stop, .. } = &model;
        let cal = calibrate_from(segments, system, records, smooth, noise, effort, stop)?;
        if model.effects.is_empty() && cal.chi2.is_finite() {
            model.missed = model.missed.max(cal.chi2);
        }
        let (fit, validate) = gaps(&cal, noise);
        let whiteness = whiteness(&cal, &model.records, |_| true);
        let effects = || model.effects.iter().map(|a| &a.effect);
        let score = Score {
            fit,
            validate,
            predictive: validate,
            least: least(&cal, &model.records, noise),
            whiteness,
            samples: cal.samples,
            judged: match validate {
                Some(_) => power(&cal, noise, &of(&cal, Role::Validate)).1,
                None => cal.samples,
            },
            effective: cal.effective,
            effects: model.effects.len(),
            parameters: model.size(),
            occam: OccamFactor::of(&model, &cal),
            sensors: effects().filter(|e| e.entry.law.sensor.is_some()).count(),
            inputs: effects().filter(|e| e.entry.law.input.is_some()).count(),
            early: 0,
        };
        let mut alone = Fitted { model, cal, score, joint: None, input_errors: vec![] };
        alone.score.early = alone.early_sensors();
        Ok(match alone.together(noise) {
            Some(Together { cal, whiteness, input_errors }) => {
                alone.score.whiteness = whiteness;
                Fitted { joint: Some(cal), input_errors, ..alone }.measured_by(noise)
            }
            None => alone,
        })
    }

    /// The same as the start of trials: fits from here end without a result once the work is to end.
    pub(crate) fn on_trial(self) -> Fitted {
        let stop = self.model.stop.aborting();
        Fitted { model: self.model.stopped_by(stop), ..self }
    }

    /// The same as a result: fits from here end with what they have.
    pub(crate) fn chosen(self) -> Fitted {
        let stop = self.model.stop.finishing();
        Fitted { model: self.model.stopped_by(stop), ..self }
    }

    /// The whiteness score of the Fit records, where these leave only noise and the Validate records more.
    fn only_noise_on_fit(&self) -> Option<f64> {
        if self.score.validate.is_none() || self.score.fit > LITTLE_LEFT || self.score.is_white() {
            return None;
        }
        let white = whiteness(&self.cal, &self.model.records, |r| r.role == Role::Fit);
        (white < NOT_WHITE).then_some(white)
    }

    /// Number of sensors with a negative delay.
    fn early_sensors(&self) -> usize {
        let delays =
            self.model.effects.iter().filter(|a| a.effect.entry.law.sensor.as_deref() == Some("delay"));
        delays.filter(|a| values(self, &a.names, &a.effect.start).iter().any(|v| *v < 0.0)).count()
    }

    /// Joint fit of Fit and Validate records; `None` where it does not apply. It applies where Fit records
    /// leave only noise, and the misfit on Validate records may come from errors of start states and
    /// parameters. The misfit does come from them if the joint fit leaves only noise on all records, or the
    /// error of the inputs between their samples, and chi^2 of the Fit records rises no more than chance
    /// allows (the predictive test of Chow 1960, doi
    /// 10.2307/1910133). The calibration itself stays unchanged.
    fn together(&self, noise: &[Vec<f64>]) -> Option<Together> {
        self.only_noise_on_fit().filter(|_| !self.model.stop.requested())?;
        let model = self.settled();
        let joint = |records: &[Record]| -> Vec<Record> {
            records.iter().map(|r| Record { role: Role::Fit, continues: None, ..r.clone() }).collect()
        };
        let (records, smooth) = (joint(&model.records), joint(&model.smooth));
        let cal = calibrate(&model.system, &records, &smooth, noise, Effort::Plain).ok()?;
        let fits = of(&self.cal, Role::Fit);
        let rise = power(&cal, noise, &fits).0 - power(&self.cal, noise, &fits).0;
        // The rise of chi^2 that this many parameters cause by chance: mean plus five standard deviations.
        let freedom = (self.cal.moved + fits.len() * model.system.states.len()) as f64;
        let chance = freedom + CHOW * (2.0 * freedom).sqrt();
        if rise >= chance {
            return None;
        }
        let white = whiteness(&cal, &records, |_| true);
        if white < NOT_WHITE {
            return Some(Together { cal, whiteness: white, input_errors: vec![] });
        }
        let there = model.starting_at(&shared(&model, &cal.parameters, |_| true));
        let input_errors = input_errors(&there, &cal.records)?;
        // What is left on these columns is as good as noise.
        let counts = |r: usize, k: usize| !input_errors.iter().any(|e| (e.record, e.column) == (r, k));
        let whiteness = whiteness_of(&cal, &records, counts);
        (whiteness < NOT_WHITE).then_some(Together { cal, whiteness, input_errors })
    }

    /// Noise of every measured column from the residuals, by record. For a model with white residuals this is
    /// better than the estimate from the columns, where the motion covers most of the spectrum.
    pub(crate) fn noise(&self, noise: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let residual = |r: usize, k: usize| self.cal.records[r].residuals.get(k).map(Vec::as_slice);
        let growing = growing_noise(&self.model.records, residual);
        // What the inputs leave between their samples is as good as noise, and hides what noise there is.
        let hidden = |r: usize, k: usize| self.input_errors.iter().find(|e| (e.record, e.column) == (r, k));
        let of = |r: usize, own: f64, residual: Cow<'_, [f64]>, k: usize| {
            let record = &self.model.records[r];
            if let Some(error) = hidden(r, k) {
                return own.max(error.left);
            }
            if residual.is_empty() {
                return own;
            }
            let form = growing.get(k).copied().flatten().zip(record.own_column(k));
            let grown = form.map_or(0.0, |(form, (_, column))| form.root_mean_square(&column));
            let level = noise_level_at(&record.own_times.of(k, &record.time), &residual)
                .min(rms(residual.iter().copied()));
            grown.max(level).max(record.rounding(k)).max(least_noise_of(record, k))
        };
        let record = |r: usize| {
            let columns = &self.model.records[r].columns;
            let columns = (0..columns.len()).filter(|&k| columns[k].is_some());
            // A run that failed leaves no residuals.
            let residuals = measured(&self.cal.records[r]).chain(std::iter::repeat(Cow::Borrowed(&[][..])));
            noise[r].iter().zip(residuals).zip(columns).map(|((&own, e), c)| of(r, own, e, c)).collect()
        };
        (0..noise.len()).map(record).collect()
    }

    /// The noise of every measured column, by record: what the columns tell, but no more than the model leaves. A column alone
    /// does not tell its noise where few samples in a period of the motion leave no part of the spectrum to it.
    pub(crate) fn least_noise(&self, noise: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let less = |((_, samples), (own, left)): ((usize, usize), (&f64, f64))| {
            let chance = CHANCE * (2.0 / samples as f64).sqrt();
            if left < own * (1.0 - chance).max(0.0).sqrt() { left } else { *own }
        };
        let all = self.model.records.iter().zip(noise.iter().zip(self.noise(noise)));
        all.map(|(record, (own, left))| own_samples(record).zip(own.iter().zip(left)).map(less).collect())
            .collect()
    }

    /// The noise by what the model leaves: a white residual is the noise itself, any other one bounds it.
    pub(crate) fn noise_left(&self, noise: &[Vec<f64>]) -> Vec<Vec<f64>> {
        if self.score.is_white() { self.noise(noise) } else { self.least_noise(noise) }
    }

    /// Recomputes the gaps in units of this noise.
    pub(crate) fn measured_by(mut self, noise: &[Vec<f64>]) -> Fitted {
        (self.score.fit, self.score.validate) = gaps(&self.cal, noise);
        self.score.least = least(&self.cal, &self.model.records, noise);
        self.score.predictive = self.score.validate;
        if let Some(joint) = &self.joint {
            let (fits, validates) = (of(&self.cal, Role::Fit), of(&self.cal, Role::Validate));
            let rise = power(joint, noise, &fits).0 - power(&self.cal, noise, &fits).0;
            let (left, samples) = power(joint, noise, &validates);
            let left = left - self.power_of_input_errors(joint, noise);
            let within = ((left + rise.max(0.0)) / samples.max(1) as f64).sqrt();
            // Allowing for errors takes away from a gap, and adds nothing to it.
            self.score.predictive = self.score.validate.map(|gap| gap.min(within));
        }
        self
    }

    /// The part of the sum of (residual / noise)^2 of a joint fit by which columns that leave the error of
    /// the inputs exceed noise.
    fn power_of_input_errors(&self, joint: &Calibration, noise: &[Vec<f64>]) -> f64 {
        let of = |error: &ColumnError| {
            let residuals = &joint.records[error.record].residuals;
            let own = residuals[..error.column].iter().filter(|e| !e.is_empty()).count();
            let ratio = error.left / noise[error.record][own];
            joint.records[error.record].own_residual(error.column).len() as f64
                * (ratio.powi(2) - 1.0).max(0.0)
        };
        self.input_errors.iter().map(of).sum()
    }

    /// Mean square difference of the residuals of this model and another one on the records of a role, in units
    /// of the noise.
    pub(crate) fn difference(&self, other: &Fitted, on: Role, noise: &[Vec<f64>]) -> f64 {
        let (sum, count) = self.squares_apart(other, &|role| role == on, &|_| true, noise);
        sum / count.max(1) as f64
    }

    /// The chi square of the difference of the residuals of this model and another one in all records, at the samples that tell
    /// of both: the residual of one that does not is zero.
    pub(crate) fn apart(&self, other: &Fitted, noise: &[Vec<f64>]) -> f64 {
        let both = |(a, b): (&f64, &f64)| *a != 0.0 && *b != 0.0;
        self.squares_apart(other, &|_| true, &both, noise).0
    }

    /// The sum of squares of that difference, in units of the noise, and the number of samples.
    fn squares_apart(
        &self,
        other: &Fitted,
        on: &dyn Fn(Role) -> bool,
        counts: &dyn Fn((&f64, &f64)) -> bool,
        noise: &[Vec<f64>],
    ) -> (f64, usize) {
        let (mut sum, mut count) = (0.0, 0usize);
        let records = other.cal.records.iter().zip(&self.cal.records).zip(noise);
        for ((other, own), noise) in records.filter(|((own, _), _)| on(own.role)) {
            for ((a, b), noise) in measured(other).zip(measured(own)).zip(noise) {
                for (a, b) in a.iter().zip(b.iter()).filter(|pair| counts(*pair)) {
                    sum += ((a - b) / noise).powi(2);
                    count += 1;
                }
            }
        }
        (sum, count)
    }

    /// Whether a run rests for more than one sample in `RESTS`.
    pub(crate) fn rests(&self) -> bool {
        self.cal.records.iter().filter_map(|r| r.run.as_ref()).any(|run| {
            let still = run.modes.iter().filter(|m| **m == 0).count();
            RESTS * still > run.modes.len().max(1)
        })
    }

    /// The role of the records on which the gap for decisions is measured.
    pub(crate) fn judged_by(&self) -> Role {
        if self.score.validate.is_some() { Role::Validate } else { Role::Fit }
    }

    /// Whether any column of the Validate records (of the Fit records if there are none) follows the motion.
    pub(crate) fn follows(&self) -> bool {
        let counts = self.cal.records.iter().filter(|r| r.role == self.judged_by());
        counts.flat_map(|r| &r.nrmse).any(|(_, left)| *left < STANDS_STILL)
    }

    /// Whether an effect has a clearance. The linear response does not describe impacts on a stop.
    pub(crate) fn has_clearance(&self) -> bool {
        self.model.effects.iter().any(|a| a.effect.entry.law.has_clearance())
    }

    /// Whether other starts are worth a fit: the residual is above the noise, and not so large that the model
    /// is simply wrong.
    pub(crate) fn may_gain(&self) -> bool {
        phisindy_learn::RESTART_RANGE.contains(&self.score.fit.powi(2))
    }

    /// Estimates of the movable constants, by name (SI). A constant with one value per record has that of the
    /// first record.
    pub(crate) fn estimates(&self, which: impl Fn(&Parameter) -> bool) -> Vec<(String, f64)> {
        shared(&self.model, &self.cal.parameters, which)
    }

    /// The model with every movable number starting where this fit ended.
    pub(crate) fn settled(&self) -> TrialModel {
        let mut model = self.model.starting_at(&self.estimates(|_| true));
        self.starts(&mut model);
        model
    }

    /// Sets the start states of a model of the same records to those of this fit.
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

/// Values of movable constants, by name (SI). A constant with one value per record has that of the first
/// record.
fn shared(
    model: &TrialModel,
    found: &[FoundParameter],
    which: impl Fn(&Parameter) -> bool,
) -> Vec<(String, f64)> {
    let of = |p: &FoundParameter| {
        let parameter = &model.system.parameters[p.id.constant().filter(|_| p.id.holds_in(0))?];
        which(parameter).then(|| (parameter.name.clone(), p.estimate.value))
    };
    found.iter().filter_map(of).collect()
}

/// The largest whiteness score of any column of some of the records; infinite where a run fails.
fn whiteness(cal: &Calibration, records: &[Record], of: impl Fn(&RecordFit) -> bool) -> f64 {
    whiteness_of(cal, records, |r, _| of(&cal.records[r]))
}

/// The largest whiteness score of some columns (record, column); infinite where a run of their records fails.
fn whiteness_of(cal: &Calibration, records: &[Record], of: impl Fn(usize, usize) -> bool) -> f64 {
    let mut worst = 0.0_f64;
    for (r, (replay, record)) in cal.records.iter().zip(records).enumerate() {
        if !(0..record.columns.len()).any(|k| of(r, k)) {
            continue;
        }
        for k in (0..replay.residuals.len()).filter(|&k| of(r, k) && !replay.residuals[k].is_empty()) {
            if let Some((_, column)) = record.own_column(k) {
                worst = worst.max(score(&replay.own_residual(k), &column));
            }
        }
        if replay.run.is_none() {
            worst = f64::INFINITY;
        }
    }
    worst
}

/// The residuals of the measured columns of a record, each at its own samples; none where its run fails.
pub(crate) fn measured(fit: &RecordFit) -> impl Iterator<Item = Cow<'_, [f64]>> {
    let measured = (0..fit.residuals.len()).filter(|&k| !fit.residuals[k].is_empty());
    measured.map(|k| fit.own_residual(k))
}

/// Indices of the records of one role.
fn of(cal: &Calibration, role: Role) -> Vec<usize> {
    (0..cal.records.len()).filter(|&r| cal.records[r].role == role).collect()
}

/// Sum of (residual / noise)^2 over some records, and the number of samples; infinite where a run fails.
fn power(cal: &Calibration, noise: &[Vec<f64>], of: &[usize]) -> (f64, usize) {
    power_of(of.iter().map(|&r| (&cal.records[r], noise[r].as_slice())))
}

/// The same of runs of records, each with the noise of its columns.
pub(crate) fn power_of<'a>(runs: impl Iterator<Item = (&'a RecordFit, &'a [f64])>) -> (f64, usize) {
    let (mut sum, mut count) = (0.0, 0);
    for (fit, noise) in runs {
        if fit.run.is_none() {
            return (f64::INFINITY, 1);
        }
        for (residual, noise) in measured(fit).zip(noise) {
            sum += residual.iter().map(|e| (e / noise).powi(2)).sum::<f64>();
            count += residual.len();
        }
    }
    (sum, count)
}

/// rms of residual / noise over the Fit records and over the Validate records; infinite where a run fails.
fn gaps(cal: &Calibration, noise: &[Vec<f64>]) -> (f64, Option<f64>) {
    let gap = |role: Role| -> Option<f64> {
        let (sum, count) = power(cal, noise, &of(cal, role));
        (count > 0).then(|| (sum / count as f64).sqrt())
    };
    (gap(Role::Fit).unwrap_or(f64::INFINITY), gap(Role::Validate))
}

/// The gap on the Fit records that the error of the simulation makes.
fn least(cal: &Calibration, records: &[Record], noise: &[Vec<f64>]) -> f64 {
    let (mut sum, mut count) = (0.0, 0);
    for r in of(cal, Role::Fit) {
        for ((k, samples), noise) in own_samples(&records[r]).zip(&noise[r]) {
            sum += samples as f64 * (least_noise_of(&records[r], k) / noise).powi(2);
            count += samples;
        }
    }
    (sum / count.max(1) as f64).sqrt()
}

/// The measured columns of a record, each with the number of its own samples.
fn own_samples(record: &Record) -> impl Iterator<Item = (usize, usize)> {
    let own = |k| record.own_column(k).map(|(time, _)| (k, time.len()));
    (0..record.columns.len()).filter_map(own)
}

/// The effects of a fitted model with the estimates as start values.
pub(crate) fn current(now: &Fitted) -> Vec<Effect> {
    let own = |name: &str| now.model.effects.iter().any(|a| a.names.iter().any(|n| n == name));
    let beside = now.estimates(|p| !p.each && !own(&p.name));
    let of = |a: &super::Applied| Effect {
        start: values(now, &a.names, &a.effect.start),
        beside: beside.clone(),
        ..a.effect.clone()
    };
    now.model.effects.iter().map(of).collect()
}

/// The estimates of an effect's parameters; `otherwise` where there is none.
pub(crate) fn values(fitted: &Fitted, names: &[String], otherwise: &[f64]) -> Vec<f64> {
    names
        .iter()
        .zip(otherwise)
        .map(|(name, other)| {
            let estimate =
                fitted.cal.parameters.iter().find(|p| {
                    p.id.constant().is_some_and(|k| fitted.model.system.parameters[k].name == *name)
                });
            estimate.map_or(*other, |p| p.estimate.value)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_models::model;
    use std::f64::consts::SQRT_2;

    /// With four samples in a period the column alone gives a level that is mostly motion; the model gives that of the noise.
    /// With forty both give that of the noise, a hundredth of the motion.
    #[test]
    fn noise_is_no_more_than_the_model_leaves() {
        let levels = |step: f64, duration: f64| {
            let (base, noise) = model(&format!(
                r#"(states: {{ "x": "m", "v": "m/s" }}, constants: {{ "k": (1.0, "1/s^2") }},
                    known: {{ "x": "v", "v": "-k*x" }}, unknown: {{}},
                    data: [ Synthetic(truth: {{}}, start: {{ "x": 2.0, "v": 0.0 }}, duration: {duration}, step: {step}, measure: ["x"],
                        noise: Additive(0.01), seed: 1) ])"#
            ));
            let fitted = Fitted::new(base, &noise, Effort::Plain).expect("a fit");
            (noise[0][0], fitted.least_noise(&noise)[0][0])
        };
        let is_that_of_the_sensor = |level: f64| (level / (0.01 * SQRT_2) - 1.0).abs() < 0.2;
        let (own, left) = levels(1.7, 250.0);
        assert!(own > 0.1 && is_that_of_the_sensor(left), "{own} {left}");
        let (own, left) = levels(0.15, 40.0);
        assert!(is_that_of_the_sensor(own) && own == left, "{own} {left}");
    }
}
