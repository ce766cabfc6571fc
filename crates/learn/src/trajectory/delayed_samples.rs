//! Sample times of the columns of a record: each sensor may be late by a delay of its own.
//!
//! One simulation serves all columns. It is sampled at the times of every delay, and each column takes the
//! samples of its own delay.

use phisindy_phys::LAG_MOMENTS;
use phisindy_sim::Trajectory;

/// Times at which a run is sampled, and which of them belong to which column.
pub(crate) struct DelayedSamples {
    /// Sample times, not decreasing.
    pub(crate) times: Vec<f64>,
    /// For each distinct delay, the indices of its samples in `times`. The first delay is that of the states
    /// themselves.
    at: Vec<Vec<usize>>,
    /// For each column, the moments whose sum a sample is.
    moments: Vec<Vec<Moment>>,
}

/// A moment that a sample shows.
#[derive(Clone, Copy)]
struct Moment {
    /// The index of its delay in [`DelayedSamples::at`].
    of: usize,
    /// The part that it has of the sample.
    part: f64,
    /// How many time constants of the lag it is back.
    lags: f64,
}

/// How late a sensor is, and by what its clock drifts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Lateness {
    pub(crate) delay: f64,
    pub(crate) clock: f64,
    /// Since when the clock drifts.
    pub(crate) since: f64,
    /// Over how long a sample is the mean, up to its time.
    pub(crate) average: f64,
    /// The time constant of its lag.
    pub(crate) lag: f64,
}

impl Lateness {
    /// The moments whose weighted sum a sample is, each with its part and how many lags it is back. A mean has the nodes of
    /// Gauss's rule with three, which is exact for polynomials up to the fifth degree, a lag has [`LAG_MOMENTS`]. The
    /// one in the middle is the mean moment.
    fn moments(self) -> Vec<(Lateness, f64, f64)> {
        let apart = 0.5 * 0.6_f64.sqrt();
        let mean = [(0.5 - apart, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.5 + apart, 5.0 / 18.0)];
        let mean = if self.average == 0.0 { &[(0.0, 1.0)][..] } else { &mean[..] };
        let lags = if self.lag == 0.0 { &[(1.0, 1.0)][..] } else { &LAG_MOMENTS[..] };
        let at = |back: f64, lags: f64| {
            let delay = self.delay + back * self.average + lags * self.lag;
            Lateness { delay, average: 0.0, lag: 0.0, ..self }
        };
        let of = |&(back, part): &(f64, f64)| lags.iter().map(move |(l, of)| (at(back, *l), part * of, *l));
        mean.iter().flat_map(of).collect()
    }

    /// The middle of what a sample at `t` shows.
    pub(crate) fn middle(self, t: f64) -> f64 {
        self.shown(t) - 0.5 * self.average - self.lag
    }

    /// The first that a sample at `t` shows, but for a thousandth part of it.
    pub(crate) fn oldest(self, t: f64) -> f64 {
        let told = LAG_MOMENTS.iter().filter(|(_, part)| *part > 1e-3);
        self.shown(t) - self.average - told.fold(0.0, |most, (back, _)| back.max(most)) * self.lag
    }

    /// When what a sample at `t` shows was.
    pub(crate) fn shown(self, t: f64) -> f64 {
        t - self.delay + self.clock * (t - self.since)
    }
}

/// A sample of a column.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reading {
    pub(crate) column: usize,
    pub(crate) sample: usize,
}

impl DelayedSamples {
    /// Samples at `samples`, each state's column as late as its sensor. The states themselves are sampled as
    /// the sensor of state `first` is.
    pub(crate) fn new(samples: &[f64], late: &[Lateness], first: usize) -> DelayedSamples {
        let middle = |moments: Vec<(Lateness, f64, f64)>| moments[moments.len() / 2].0;
        let mut distinct = vec![middle(late.get(first).copied().unwrap_or_default().moments())];
        let mut place = |own: Lateness| {
            distinct.iter().position(|other| *other == own).unwrap_or_else(|| {
                distinct.push(own);
                distinct.len() - 1
            })
        };
        let mut moment = |(own, part, lags)| Moment { of: place(own), part, lags };
        let moments = late.iter().map(|own| own.moments().into_iter().map(&mut moment).collect());
        let moments = moments.collect();
        if let [late] = distinct[..] {
            let times = samples.iter().map(|t| late.shown(*t)).collect();
            return DelayedSamples { times, at: vec![(0..samples.len()).collect()], moments };
        }
        let mut all: Vec<(f64, usize, usize)> = distinct
            .iter()
            .enumerate()
            .flat_map(|(g, late)| samples.iter().enumerate().map(move |(i, t)| (late.shown(*t), g, i)))
            .collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut at = vec![vec![0; samples.len()]; distinct.len()];
        all.iter().enumerate().for_each(|(k, &(_, g, i))| at[g][i] = k);
        DelayedSamples { times: all.into_iter().map(|(t, ..)| t).collect(), at, moments }
    }

    /// The first sample time of the states themselves.
    pub(crate) fn first(&self) -> f64 {
        self.at[0].first().map_or(0.0, |&i| self.times[i])
    }

    /// The readings that are due at each of the times, of the columns that are measured.
    pub(crate) fn due(&self, measured: impl Fn(usize) -> bool) -> Vec<Vec<Reading>> {
        let mut due = vec![vec![]; self.times.len()];
        for column in (0..self.moments.len()).filter(|&k| measured(k)) {
            let middle = self.moments[column][self.moments[column].len() / 2];
            let of_column = self.at[middle.of].iter().enumerate();
            of_column.for_each(|(sample, &at)| due[at].push(Reading { column, sample }));
        }
        due
    }

    /// Sorts a run that an observer followed, whose readings before each correction are `read`, by column.
    pub(crate) fn followed(&self, run: Trajectory, read: Vec<Option<Delayed>>) -> SampledRun {
        let SampledRun { run, end, late } = self.split(run);
        let late = late.into_iter().chain(std::iter::repeat_with(|| None));
        let late = read.into_iter().zip(late).map(|(read, late)| read.or(late)).collect();
        SampledRun { run, end, late }
    }

    /// Adds a sample of the states at a time, or at the last sample time if that is later.
    pub(crate) fn push(&mut self, time: f64) {
        self.at[0].push(self.times.len());
        self.times.push(self.times.last().map_or(time, |last| last.max(time)));
    }

    /// Sorts a run that was sampled at [`DelayedSamples::times`] by column.
    pub(crate) fn split(&self, run: Trajectory) -> SampledRun {
        let end = self.at[0].last().map_or(0.0, |&i| self.times[i]);
        if let [_] = self.at[..] {
            return SampledRun { run, end, late: vec![] };
        }
        let (n, m) = (run.n, run.m);
        let late = (0..n)
            .map(|k| {
                let moments = self.moments.get(k).filter(|own| !matches!(own[..], [Moment { of: 0, .. }]))?;
                let samples = self.at[0].len();
                let mut own = Delayed {
                    values: vec![(0.0, 0.0); samples],
                    by_lag: vec![0.0; samples],
                    sensitivities: vec![0.0; samples * m],
                };
                for &Moment { of, part, lags } in moments {
                    for (sample, i) in self.at[of].iter().take(samples).enumerate() {
                        let (value, rate) = &mut own.values[sample];
                        *value += part * run.states[i * n + k];
                        *rate += part * run.rates[i * n + k];
                        own.by_lag[sample] -= part * lags * run.rates[i * n + k];
                        let slopes = &run.sensitivities[(i * n + k) * m..][..m];
                        let sums = own.sensitivities[sample * m..][..m].iter_mut();
                        sums.zip(slopes).for_each(|(sum, slope)| *sum += part * slope);
                    }
                }
                Some(own)
            })
            .collect();
        let rows = |of: &[f64], width: usize| -> Vec<f64> {
            if of.is_empty() {
                return vec![];
            }
            self.at[0].iter().flat_map(|i| &of[i * width..][..width]).copied().collect()
        };
        let switches = run.modes.len() / self.times.len().max(1);
        let run = Trajectory {
            states: rows(&run.states, n),
            rates: rows(&run.rates, n),
            sensitivities: rows(&run.sensitivities, n * m),
            modes: self.at[0].iter().flat_map(|i| &run.modes[i * switches..][..switches]).copied().collect(),
            ..run
        };
        SampledRun { run, end, late }
    }
}

/// A run at the sample times of each column.
pub(crate) struct SampledRun {
    /// All states with the delay of the first column.
    pub(crate) run: Trajectory,
    /// Time of the last sample of `run`.
    pub(crate) end: f64,
    /// The columns with other delays; empty if all have the same.
    late: Vec<Option<Delayed>>,
}

/// What a column shows at its own sample times.
#[derive(Default)]
pub(crate) struct Delayed {
    /// Value and rate at every sample.
    pub(crate) values: Vec<(f64, f64)>,
    /// The derivative of each value by the lag of the sensor.
    pub(crate) by_lag: Vec<f64>,
    /// Derivatives, row-major samples x m.
    pub(crate) sensitivities: Vec<f64>,
}

impl SampledRun {
    /// Value and rate of a column's state at its own sample time.
    pub(crate) fn value(&self, sample: usize, state: usize) -> (f64, f64) {
        match self.late.get(state) {
            Some(Some(late)) => late.values[sample],
            _ => {
                let at = sample * self.run.n + state;
                (self.run.states[at], self.run.rates[at])
            }
        }
    }

    /// The derivative of that value by the lag of its sensor.
    pub(crate) fn by_lag(&self, sample: usize, state: usize) -> f64 {
        match self.late.get(state) {
            Some(Some(late)) => late.by_lag[sample],
            _ => -self.value(sample, state).1,
        }
    }

    /// Derivatives of that value by the start and the free parameters.
    pub(crate) fn sensitivities(&self, sample: usize, state: usize) -> &[f64] {
        let m = self.run.m;
        match self.late.get(state) {
            Some(Some(late)) => &late.sensitivities[sample * m..][..m],
            _ => &self.run.sensitivities[(sample * self.run.n + state) * m..][..m],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_column_is_sampled_with_its_own_delay() {
        let late = [0.25, 0.0, 0.25].map(|delay| Lateness { delay, ..Lateness::default() });
        let samples = DelayedSamples::new(&[0.0, 1.0, 2.0], &late, 1);
        assert_eq!(samples.times, [-0.25, 0.0, 0.75, 1.0, 1.75, 2.0]);
        // Three states that are the time, its double and its triple.
        let states = samples.times.iter().flat_map(|t| [*t, 2.0 * t, 3.0 * t]).collect();
        let rates = samples.times.iter().flat_map(|_| [1.0, 2.0, 3.0]).collect();
        let run = Trajectory { n: 3, states, rates, modes: vec![1; 6], ..Default::default() };
        let sampled = samples.split(run);
        assert_eq!(sampled.run.states, [0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 2.0, 4.0, 6.0]);
        assert_eq!(sampled.run.modes.len(), 3);
        assert_eq!([0, 1, 2].map(|k| sampled.value(1, k)), [(0.75, 1.0), (2.0, 2.0), (2.25, 3.0)]);
    }

    /// What a filter of first order shows of `t^3` when it has settled, `y + y' tau = t^3`, and how that moves with `tau`.
    #[test]
    fn a_slow_sensor_shows_the_past() {
        let late = [0.0, 0.3].map(|lag| Lateness { lag, ..Lateness::default() });
        let samples = DelayedSamples::new(&[0.0, 1.0, 2.0], &late, 0);
        let states = samples.times.iter().flat_map(|t| [*t, t.powi(3)]).collect();
        let rates = samples.times.iter().flat_map(|t| [1.0, 3.0 * t * t]).collect();
        let run =
            Trajectory { n: 2, states, rates, modes: vec![1; samples.times.len()], ..Default::default() };
        let sampled = samples.split(run);
        for (sample, t) in [0.0_f64, 1.0, 2.0].into_iter().enumerate() {
            let lag = 0.3_f64;
            let shown = t.powi(3) - 3.0 * lag * t * t + 6.0 * lag * lag * t - 6.0 * lag.powi(3);
            assert!((sampled.value(sample, 1).0 - shown).abs() < 1e-12, "{shown}");
            let moves = -3.0 * t * t + 12.0 * lag * t - 18.0 * lag * lag;
            assert!((sampled.by_lag(sample, 1) - moves).abs() < 1e-12, "{moves}");
            assert!((late[1].middle(t) - (t - lag)).abs() < 1e-15);
        }
    }

    /// The mean of `t^5` over the half second before a sample, and the middle of it for the states themselves.
    #[test]
    fn a_logger_shows_means() {
        let late = [0.0, 0.5].map(|average| Lateness { average, ..Lateness::default() });
        let samples = DelayedSamples::new(&[0.0, 1.0, 2.0], &late, 0);
        let states = samples.times.iter().flat_map(|t| [*t, t.powi(5)]).collect();
        let rates = samples.times.iter().flat_map(|t| [1.0, 5.0 * t.powi(4)]).collect();
        let count = samples.times.len();
        let run = Trajectory { n: 2, states, rates, modes: vec![1; count], ..Default::default() };
        let sampled = samples.split(run);
        for (sample, t) in [0.0_f64, 1.0, 2.0].into_iter().enumerate() {
            let mean = |f: &dyn Fn(f64) -> f64| (f(t) - f(t - 0.5)) / 0.5;
            let (value, rate) = sampled.value(sample, 1);
            assert!((value - mean(&|t| t.powi(6) / 6.0)).abs() < 1e-12, "{value}");
            assert!((rate - mean(&|t| t.powi(5))).abs() < 1e-12, "{rate}");
            assert_eq!(sampled.value(sample, 0), (t, 1.0));
        }
    }
}
