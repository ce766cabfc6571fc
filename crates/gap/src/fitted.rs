//! A draft with its numbers: calibrated, scored, compared with noise.

use crate::draft::{Draft, starting};
use crate::effect::Effect;
use crate::verdict::EXPLAINED;
use crate::whiteness::{COLOURED, score};
use phisindy_learn::{Calibration, Effort, FoundParameter, RecordFit, calibrate};
use phisindy_phys::spec::Role;
use phisindy_phys::{Parameter, Record};
use phisindy_signal::{noise_level, standard_deviation};

/// A clean column still counts as known to this part of its standard deviation: the simulation itself is not better.
const CLEAN: f64 = 1e-5;

/// The noise of every column by record and state: from the spectrum above the motion, so that no model is needed.
pub(crate) fn noise(records: &[Record]) -> Vec<Vec<f64>> {
    let of = |column: &Option<Vec<f64>>| {
        column
            .as_ref()
            .map_or(1.0, |c| noise_level(c).max(CLEAN * standard_deviation(c)).max(f64::MIN_POSITIVE))
    };
    records.iter().map(|r| r.columns.iter().map(of).collect()).collect()
}

/// Where Fit records leave less than this, what is left on Validate records may be the uncertainty of what was fitted.
const LITTLE: f64 = 1.1;
/// The price of a sensor that is early.
const EARLY: f64 = 15.0;

/// A gap on Fit records above this is far from the noise: more than one effect is missing.
pub(crate) const FAR_OFF: f64 = 2.0;

/// A column of which so much is left is not followed: as much as that a model leaves that stands still.
const STANDS_STILL: f64 = 0.95;

/// A calibrated draft.
#[derive(Clone, Debug)]
pub(crate) struct Fitted {
    pub(crate) draft: Draft,
    pub(crate) cal: Calibration,
    /// rms of residual / noise over all columns and samples of the Fit records, and of the Validate records if there are any.
    pub(crate) fit: f64,
    pub(crate) validate: Option<f64>,
    /// The gap on Validate records but for what the errors of the numbers found account for, where that was asked; else the same.
    pub(crate) carried: Option<f64>,
    /// Fit and Validate records fitted together, where that moves the numbers no further than their errors allow.
    joint: Option<Calibration>,
    /// The largest score of whiteness of any column; see [`crate::whiteness`].
    pub(crate) colour: f64,
}

impl Fitted {
    /// Calibrates a draft.
    pub(crate) fn new(draft: Draft, noise: &[Vec<f64>], effort: Effort) -> Result<Fitted, String> {
        let cal = calibrate(&draft.case.system, &draft.records, &draft.smooth, noise, effort)
            .map_err(|e| e.to_string())?;
        let (fit, validate) = gaps(&cal, noise);
        let colour = colour(&cal, &draft.records, |_| true);
        let alone = Fitted { draft, cal, fit, validate, carried: validate, joint: None, colour };
        Ok(match alone.together(noise) {
            Some((joint, colour)) => Fitted { joint: Some(joint), colour, ..alone }.measured_by(noise),
            None => alone,
        })
    }

    /// Fit and Validate records fitted together, and the colour of what that leaves, where it decides: on Fit records nothing but noise is left, and what is left on
    /// Validate records may come from the errors of starts and parameters. It does if the same model leaves nothing but noise on both, and Fit records are fitted no worse
    /// than chance has it (the predictive test of Chow 1960, doi 10.2307/1910133). The fit itself stays as it is.
    fn together(&self, noise: &[Vec<f64>]) -> Option<(Calibration, f64)> {
        if self.validate.is_none() || self.fit > LITTLE || self.is_white() {
            return None;
        }
        if colour(&self.cal, &self.draft.records, |r| r.role == Role::Fit) >= COLOURED {
            return None;
        }
        let draft = self.settled().ok()?;
        let joint = |records: &[Record]| -> Vec<Record> {
            records.iter().map(|r| Record { role: Role::Fit, continues: None, ..r.clone() }).collect()
        };
        let (records, smooth) = (joint(&draft.records), joint(&draft.smooth));
        let cal = calibrate(&draft.case.system, &records, &smooth, noise, Effort::Plain).ok()?;
        let fits = of(&self.cal, Role::Fit);
        let rise = power(&cal, noise, &fits).0 - power(&self.cal, noise, &fits).0;
        // The rise of chi^2 that as many numbers make by chance, five standard deviations high.
        let freedom = (self.cal.moved + fits.len() * draft.case.system.states.len()) as f64;
        let chance = freedom + 5.0 * (2.0 * freedom).sqrt();
        let colour = colour(&cal, &records, |_| true);
        (rise < chance && colour < COLOURED).then_some((cal, colour))
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
        (self.fit, self.validate) = gaps(&self.cal, noise);
        self.carried = self.validate;
        if let Some(joint) = &self.joint {
            let (fits, validates) = (of(&self.cal, Role::Fit), of(&self.cal, Role::Validate));
            let rise = power(joint, noise, &fits).0 - power(&self.cal, noise, &fits).0;
            let (left, samples) = power(joint, noise, &validates);
            self.carried = Some(((left + rise.max(0.0)) / samples.max(1) as f64).sqrt());
        }
        self
    }

    /// Whether its runs come to rest for more than a moment.
    pub(crate) fn rests(&self) -> bool {
        self.cal.records.iter().filter_map(|r| r.run.as_ref()).any(|run| {
            let still = run.modes.iter().filter(|m| **m == 0).count();
            50 * still > run.modes.len().max(1)
        })
    }

    /// Whether it follows the motion in any column of the records that count: those of the role Validate, if there are any.
    pub(crate) fn follows(&self) -> bool {
        let role = if self.validate.is_some() { Role::Validate } else { Role::Fit };
        let counts = self.cal.records.iter().filter(|r| r.role == role);
        counts.flat_map(|r| &r.nrmse).any(|(_, left)| *left < STANDS_STILL)
    }

    /// Whether there is a clearance in it: a body that strikes a stop answers in a way that no linear response knows.
    pub(crate) fn strikes(&self) -> bool {
        self.draft.effects.iter().any(|(e, ..)| e.entry.law.has_clearance())
    }

    /// Whether other starts are worth a try: what is left is more than noise, and not so much that the model is simply wrong.
    pub(crate) fn may_gain(&self) -> bool {
        phisindy_learn::RESTARTED.contains(&(self.fit * self.fit))
    }

    /// Whether it leaves nothing but noise, on records that were not fitted too but for what the errors of its numbers account for.
    pub(crate) fn explains(&self) -> bool {
        self.is_white() && self.carried.unwrap_or(self.fit) < EXPLAINED
    }

    pub(crate) fn is_white(&self) -> bool {
        self.colour < COLOURED
    }

    /// The criterion: twice the negative logarithm of the likelihood plus the price of what was added; smaller is better. `candidates` is how many effects there were to choose
    /// from, `independent` the part of the samples that counts.
    ///
    /// Far from the noise a rich law bends to the Fit records whatever is missing: there the gap on the records that were not fitted counts.
    ///
    /// Down to the noise the likelihood is that of known noise. Above it the misfit itself is the scatter: what is left of a real rig is many times its sensor noise, and a law that
    /// takes away a hundredth of that has explained nothing, however large the number in units of the noise.
    pub(crate) fn score(&self, candidates: usize, independent: f64) -> f64 {
        let effects: Vec<&Effect> = self.draft.effects.iter().map(|(e, ..)| e).collect();
        let n = self.cal.samples as f64;
        // Of the free run: segments with starts of their own would flatter a model that cannot be run.
        let ratio = match self.validate {
            Some(validate) if self.fit > FAR_OFF => validate.max(FAR_OFF).powi(2),
            _ => self.fit.powi(2),
        };
        let cost = if ratio > 1.0 { n * (1.0 + ratio.ln()) } else { n * ratio };
        let size: usize = effects.iter().map(|e| e.entry.law.parameters.len()).sum();
        let sensors = effects.iter().filter(|e| e.entry.law.sensor.is_some()).count();
        let price = size as f64 * (n * independent).max(2.0).ln();
        // A sensor may be late; one that is early is a worse story: of a motion without a clock of its own both are the same.
        let early = self.draft.effects.iter().filter(|(e, names, _)| {
            e.entry.law.sensor.as_deref() == Some("delay")
                && values(self, names, &e.start).iter().any(|v| *v < 0.0)
        });
        let odd = 6.0 * sensors as f64 + EARLY * early.count() as f64;
        cost * independent + price + 2.0 * ln_choose(candidates, effects.len()) + odd
    }

    /// The part of the samples that counts as independent.
    pub(crate) fn independent(&self) -> f64 {
        let part = self.cal.effective / self.cal.samples.max(1) as f64;
        if part > 0.6 || self.is_white() { 1.0 } else { part }
    }

    /// The constants that moved, with the values that were found; of those with a value for each record that of the first one.
    pub(crate) fn found(&self, which: impl Fn(&Parameter) -> bool) -> Vec<(String, f64)> {
        let parameters = &self.draft.case.system.parameters;
        let of = |p: &FoundParameter| {
            let parameter = &parameters[p.id.constant().filter(|_| p.id.holds_in(0))?];
            which(parameter).then(|| (parameter.name.clone(), p.estimate.value))
        };
        self.cal.parameters.iter().filter_map(of).collect()
    }

    /// The draft with every movable number starting where this fit ended.
    pub(crate) fn settled(&self) -> Result<Draft, String> {
        let system = &self.draft.case.system;
        let text = starting(&self.draft.text, system, &self.found(|_| true))?;
        let mut draft = self.draft.rebuilt(text, self.draft.effects.clone(), self.draft.internal.clone())?;
        self.starts(&mut draft);
        Ok(draft)
    }

    /// Lets a draft of the same records start where this fit started its runs.
    pub(crate) fn starts(&self, draft: &mut Draft) {
        for (smooth, record) in draft.smooth.iter_mut().zip(&self.cal.records) {
            for (column, start) in smooth.columns.iter_mut().zip(&record.start) {
                if let (Role::Fit, Some(column)) = (record.role, column) {
                    column[0] = *start;
                }
            }
        }
    }
}

/// The largest score of whiteness of any column of some of the records; infinite where a run fails.
fn colour(cal: &Calibration, records: &[Record], of: impl Fn(&RecordFit) -> bool) -> f64 {
    let mut colour = 0.0_f64;
    for (replay, record) in cal.records.iter().zip(records).filter(|(replay, _)| of(replay)) {
        for (residual, column) in replay.residuals.iter().zip(&record.columns) {
            if let (false, Some(column)) = (residual.is_empty(), column) {
                colour = colour.max(score(residual, column));
            }
        }
        if replay.run.is_none() {
            colour = f64::INFINITY;
        }
    }
    colour
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

/// ln of the binomial coefficient.
fn ln_choose(n: usize, k: usize) -> f64 {
    (0..k.min(n)).map(|i| ((n - i) as f64 / (i + 1) as f64).ln()).sum()
}

/// The effects of a fitted model, from where its fit ended.
pub(crate) fn current(now: &Fitted) -> Vec<Effect> {
    let own = |name: &str| now.draft.effects.iter().any(|(_, names, _)| names.iter().any(|n| n == name));
    let beside = now.found(|p| !p.each && !own(&p.name));
    let of = |(e, names, _): &(Effect, Vec<String>, String)| Effect {
        start: values(now, names, &e.start),
        beside: beside.clone(),
        ..e.clone()
    };
    now.draft.effects.iter().map(of).collect()
}

/// The values that a fit found for an effect's parameters.
pub(crate) fn values(fitted: &Fitted, names: &[String], otherwise: &[f64]) -> Vec<f64> {
    names
        .iter()
        .zip(otherwise)
        .map(|(name, other)| {
            let found = fitted.cal.parameters.iter().find(|p| {
                p.id.constant().is_some_and(|k| fitted.draft.case.system.parameters[k].name == *name)
            });
            found.map_or(*other, |p| p.estimate.value)
        })
        .collect()
}
