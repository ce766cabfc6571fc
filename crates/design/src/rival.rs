//! A model that may be the true one, and what it predicts of a run.

use crate::limits::{Limits, step};
use crate::trial::Trial;
use faer::{Mat, Side};
use phisindy_learn::{FoundParameter, ModelError, Predicted, Predictor};
use phisindy_phys::spec::Role;
use phisindy_phys::{OwnTimes, Record, System};
use phisindy_signal::{Interpolation, Signal};
use std::sync::Arc;

/// Variances smaller than this part of the largest are rounding.
const ROUNDING: f64 = 1e-12;

/// A speed at the start is known from so many samples of its place.
const SAMPLES_OF_A_SPEED: f64 = 8.0;

/// A model that may be the true one.
#[derive(Clone, Debug)]
pub struct Rival {
    /// What it is called.
    pub name: String,
    /// How probable it is, among those that are left.
    pub probability: f64,
    /// The model, once for each setting of the constants that can be set.
    pub systems: Vec<System>,
    /// A record for this model: its sensors, and what its columns are like.
    pub like: Record,
    /// Name, value (SI) and bounds of each number that was found.
    pub numbers: Vec<(String, f64, (f64, f64))>,
    /// In which directions these are uncertain, each one standard deviation (SI).
    pub directions: Vec<Vec<f64>>,
    /// By how much each state may move at the start (SI), one after the other: a sensor shows no more.
    pub starts: Vec<Vec<f64>>,
    /// The state at rest.
    pub rest: Vec<f64>,
}

impl Rival {
    /// The rival of these results of a fit. `noise` is that of each measured column, and says how
    /// well a few samples show the start.
    pub fn new(
        (name, probability): (String, f64),
        systems: Vec<System>,
        like: Record,
        (found, covariance): (&[FoundParameter], &[Vec<f64>]),
        noise: &[Noise],
    ) -> Rival {
        let system = &systems[0];
        // Numbers that belong to a record are those of the one that stands for the next; of sensors of one record
        // alone nothing is known in the next.
        let kept: Vec<usize> = (0..found.len())
            .filter(|&k| found[k].id.constant().is_some() && found[k].id.holds_in(0))
            .collect();
        let named = |&k: &usize| {
            let p = &found[k];
            (system.parameters[p.id.constant().unwrap_or(0)].name.clone(), p.estimate.value, p.bounds)
        };
        let numbers: Vec<(String, f64, (f64, f64))> = kept.iter().map(named).collect();
        let states = system.states.len();
        // What no record determines is believed within its bounds, and to be as large as it is by itself.
        let uniform = |(_, value, (low, high)): &(String, f64, (f64, f64))| {
            let wide = (high - low) / 12f64.sqrt();
            if *value == 0.0 { wide } else { wide.min(value.abs()) }
        };
        let otherwise: Vec<f64> = numbers.iter().map(uniform).collect();
        let directions = spreads(&kept, covariance, &otherwise);
        let measured = (0..system.columns()).filter(|&k| like.columns[k].is_some());
        let mut sizes: Vec<Option<f64>> = vec![None; states];
        for (k, sigma) in measured.zip(noise).filter(|(k, _)| *k < states) {
            sizes[k] = Some(sigma.additive);
            if let Some(v) = system.states[k].velocity {
                sizes[v] = sizes[v].or(Some(sigma.additive / (SAMPLES_OF_A_SPEED * step(&like))));
            }
        }
        let along = |(k, size): (usize, &Option<f64>)| size.map(|by| unit(states, k, by));
        let starts = sizes.iter().enumerate().filter_map(along).collect();
        let rest = vec![0.0; states];
        Rival { name, probability, systems, like, numbers, directions, starts, rest }
    }

    /// Lets it come to rest, with its inputs at rest: where a run of it starts. A model that does not is released from
    /// where its record starts.
    pub fn settled(mut self, limits: &Limits, from: &[f64]) -> Rival {
        let n = self.systems[0].states.len();
        let start: Vec<f64> = (0..n).map(|k| from.get(k).copied().unwrap_or(0.0)).collect();
        let trial = Trial::at_rest(limits, &self.like);
        let last = |predicted: &Predicted| -> Vec<f64> {
            (0..n).map(|k| predicted.columns[k].last().copied().unwrap_or(0.0)).collect()
        };
        let numbers: Vec<f64> = self.numbers.iter().map(|(_, value, _)| *value).collect();
        let record = trial.record(&self.like);
        self.rest.clone_from(&start);
        let Ok(run) = self.predicted(&trial, &record, &numbers, &start) else { return self };
        let system = &self.systems[0];
        let moves = |k: usize| {
            let largest = run.columns[k].iter().fold(0.0_f64, |m, x| m.max(x.abs()));
            run.columns[k].last().is_some_and(|x| x.abs() > AT_REST * largest)
        };
        let speeds: Vec<usize> = system.states.iter().filter_map(|s| s.velocity).collect();
        if !speeds.iter().any(|&v| moves(v)) {
            self.rest = last(&run);
            speeds.iter().for_each(|&v| self.rest[v] = 0.0);
        }
        self
    }

    /// What a run would show at its samples.
    ///
    /// # Errors
    /// The model cannot be simulated.
    pub fn predicted(
        &self,
        trial: &Trial,
        record: &Record,
        numbers: &[f64],
        start: &[f64],
    ) -> Result<Predicted, ModelError> {
        let system = &self.systems[trial.setting];
        Predictor::new(system, record)?.run(Some(&self.values(system, numbers)), start)
    }

    /// The numbers of a system: those that were found by name, the others as it starts them.
    fn values(&self, system: &System, numbers: &[f64]) -> Vec<f64> {
        let of = |name: &str| self.numbers.iter().position(|(own, ..)| own == name).map(|k| numbers[k]);
        system.parameters.iter().map(|p| of(&p.name).unwrap_or(p.start)).collect()
    }

    /// The standard error of a number.
    pub fn std_error(&self, number: usize) -> f64 {
        self.directions.iter().map(|d| d[number].powi(2)).sum::<f64>().sqrt()
    }

    /// Where a run starts.
    pub fn start(&self, trial: &Trial) -> Vec<f64> {
        let system = &self.systems[trial.setting];
        let own = |k: usize| trial.start.iter().find(|(name, _)| *name == system.states[k].name);
        (0..system.states.len()).map(|k| own(k).map_or(self.rest[k], |(_, x)| *x)).collect()
    }

    /// What a run would show (SI): the mean, and how the numbers that are not sure move it, by differences between points of
    /// the spherical cubature (I. Arasaratnam, S. Haykin 2009, doi 10.1109/TAC.2009.2019800), so that a stop that comes
    /// or goes within the errors is seen.
    ///
    /// # Errors
    /// The model cannot be simulated, or a point of it leaves the limits.
    pub fn response(&self, trial: &Trial, limits: Option<&Limits>) -> Result<Response, Unfit> {
        let record = trial.record(&self.like);
        let system = &self.systems[trial.setting];
        let predictor = Predictor::new(system, &record).map_err(Unfit::Model)?;
        let measured: Vec<usize> = (0..system.columns()).filter(|&k| record.columns[k].is_some()).collect();
        let centre: Vec<f64> = self.numbers.iter().map(|(_, value, _)| *value).collect();
        let from = self.start(trial);
        let run = |by: f64, direction: &[f64], start: &[f64]| {
            let moved = |(k, x): (usize, &f64)| {
                let (low, high) = self.numbers[k].2;
                (x + by * direction[k]).clamp(low, high)
            };
            let numbers: Vec<f64> = centre.iter().enumerate().map(moved).collect();
            let start: Vec<f64> = from.iter().zip(start).map(|(x, d)| x + by * d).collect();
            let run = predictor.run(Some(&self.values(system, &numbers)), &start).map_err(Unfit::Model)?;
            if let Some(name) = limits.and_then(|limits| limits.left_by(&run.columns, system)) {
                return Err(Unfit::Leaves(name));
            }
            let rows = (0..record.len()).flat_map(|i| measured.iter().map(move |&k| (i, k)));
            let readings: Vec<f64> = rows.map(|(i, k)| run.columns[k][i]).collect();
            Ok((readings, run.stops))
        };
        let (held, still) = (vec![0.0; centre.len()], vec![0.0; from.len()]);
        let (mean, counted) = run(0.0, &held, &still)?;
        let of_numbers = self.directions.iter().map(|direction| (direction, &still));
        let moves: Vec<_> = of_numbers.chain(self.starts.iter().map(|start| (&held, start))).collect();
        let reach = (moves.len() as f64).sqrt();
        let mut stops = vec![counted];
        let mut spread: Vec<Vec<f64>> = Vec::new();
        for (direction, start) in moves {
            // A point beyond what the model can do says nothing; the other side of it does.
            let side = |by: f64| match run(by, direction, start) {
                Err(Unfit::Model(_)) => Ok(None),
                other => other.map(Some),
            };
            let (up, down) = (side(reach)?, side(-reach)?);
            let apart = reach * (f64::from(u8::from(up.is_some())) + f64::from(u8::from(down.is_some())));
            if apart == 0.0 {
                return Err(run(reach, direction, start).err().unwrap_or(Unfit::Leaves(String::new())));
            }
            let of =
                |point: &Option<(Vec<f64>, Vec<usize>)>, i: usize| point.as_ref().map_or(mean[i], |p| p.0[i]);
            spread.push((0..mean.len()).map(|i| (of(&up, i) - of(&down, i)) / apart).collect());
            stops.extend([up, down].into_iter().flatten().map(|(_, stops)| stops));
        }
        let starts = spread.split_off(self.directions.len());
        Ok(Response { mean, spread, starts, stops })
    }
}

/// A speed below this part of its largest value is rest.
const AT_REST: f64 = 1e-3;

/// The noise of a column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Its standard deviation where the column reads zero (SI).
    pub additive: f64,
    /// The part of the reading that is noise.
    pub relative: f64,
}

/// Why a rival cannot go through a trial.
#[derive(Clone, Debug, PartialEq)]
pub enum Unfit {
    /// It cannot be simulated.
    Model(ModelError),
    /// This quantity leaves its limits.
    Leaves(String),
}

/// What a model predicts of a run (SI, or in units of the noise): all columns of a sample, then the next sample.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Response {
    /// The mean.
    pub mean: Vec<f64>,
    /// How one standard deviation along each direction moves it.
    pub spread: Vec<Vec<f64>>,
    /// How it moves with the state at the start. A run begins as near as this to where it is meant to; a fit of it does not know that.
    pub starts: Vec<Vec<f64>>,
    /// For each point that was simulated how often each contact came to rest; the mean's first.
    pub stops: Vec<Vec<usize>>,
}

impl Response {
    /// The same of the first part of the run.
    pub fn first(&self, readings: usize) -> Response {
        let cut = |of: &Vec<f64>| of[..readings.min(of.len())].to_vec();
        Response {
            mean: cut(&self.mean),
            spread: self.spread.iter().map(cut).collect(),
            starts: self.starts.iter().map(cut).collect(),
            stops: self.stops.clone(),
        }
    }

    /// The same in other units: each reading by its size.
    pub fn over(&self, sizes: &[f64]) -> Response {
        let of =
            |values: &Vec<f64>| values.iter().zip(sizes.iter().cycle()).map(|(x, size)| x / size).collect();
        Response {
            mean: of(&self.mean),
            spread: self.spread.iter().map(of).collect(),
            starts: self.starts.iter().map(of).collect(),
            stops: self.stops.clone(),
        }
    }

    /// The share of the points in which contacts stop as often as in the mean: elsewhere a small error makes another
    /// motion, and no prediction holds.
    pub fn steady(&self) -> f64 {
        let same = self.stops.iter().filter(|stops| **stops == self.stops[0]).count();
        if self.stops.is_empty() { 1.0 } else { same as f64 / self.stops.len() as f64 }
    }
}

/// One coordinate alone.
fn unit(n: usize, k: usize, by: f64) -> Vec<f64> {
    let mut row = vec![0.0; n];
    row[k] = by;
    row
}

/// The principal directions of some rows of a covariance. Where the records say nothing of a number, it is uncertain by
/// `otherwise`, alone.
fn spreads(kept: &[usize], covariance: &[Vec<f64>], otherwise: &[f64]) -> Vec<Vec<f64>> {
    let variance = |i: usize| covariance.get(kept[i]).map_or(f64::INFINITY, |row| row[kept[i]]);
    let blind = (0..kept.len()).filter(|&i| !variance(i).is_finite() && otherwise[i] > 0.0);
    let mut all: Vec<Vec<f64>> = blind.map(|i| unit(kept.len(), i, otherwise[i])).collect();
    let seen: Vec<usize> =
        (0..kept.len()).filter(|&i| variance(i).is_finite() && variance(i) > 0.0).collect();
    let n = seen.len();
    if n == 0 {
        return all;
    }
    let size = |i: usize| variance(seen[i]).sqrt();
    // Of correlations, so that units play no part.
    let correlation = Mat::from_fn(n, n, |i, j| covariance[kept[seen[i]]][kept[seen[j]]] / size(i) / size(j));
    let Ok(eigen) = correlation.self_adjoint_eigen(Side::Lower) else { return all };
    let (values, basis) = (eigen.S(), eigen.U());
    let largest = (0..n).map(|k| values[k]).fold(0.0, f64::max);
    for k in (0..n).filter(|&k| values[k] > ROUNDING * largest) {
        let mut row = vec![0.0; kept.len()];
        for i in 0..n {
            row[seen[i]] = values[k].sqrt() * basis[(i, k)] * size(i);
        }
        all.push(row);
    }
    all
}

impl Trial {
    /// The run as a record that nobody has measured: its columns only say how large each is.
    pub fn record(&self, like: &Record) -> Record {
        let time: Arc<[f64]> = (0..self.samples).map(|i| i as f64 * self.step).collect();
        let of = |column: &Vec<f64>| (0..self.samples).map(|i| column[i % column.len()]).collect();
        let inputs = self.inputs.iter().map(|values| {
            Signal::new(time.clone(), values.clone(), Interpolation::Linear)
                .expect("finite values at growing times")
        });
        Record {
            name: "the next run".to_owned(),
            role: Role::Fit,
            columns: like.columns.iter().map(|column| column.as_ref().map(of)).collect(),
            own_times: OwnTimes::default(),
            inputs: inputs.collect(),
            start: vec![None; like.start.len()],
            continues: None,
            derivations: vec![],
            notes: vec![],
            time,
            ..like.clone()
        }
    }

    /// Nothing but rest, for twice the longest run.
    fn at_rest(limits: &Limits, like: &Record) -> Trial {
        let step = step(like);
        let samples = ((2.0 * limits.duration.0 / step) as usize).clamp(2, MOST_AT_REST);
        let inputs = (0..like.inputs.len()).map(|k| vec![limits.rest(k, like); samples]).collect();
        Trial { waveform: None, start: vec![], setting: 0, step, samples, inputs }
    }
}

/// Most samples of a run at rest.
const MOST_AT_REST: usize = 20_000;
