//! Sensors: how a column differs from the quantity that it measures.

use phisindy_signal::{Interpolation, Signal, SignalError};
use std::sync::Arc;

/// A sensor parameter: fixed, or found in the fit.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorParameter {
    /// The value, or where the search starts (SI).
    pub start: f64,
    /// Bounds of the search; `None` for a fixed value.
    pub within: Option<(f64, f64)>,
    /// Standard deviation of the prior round `start`, if there is one.
    pub sigma: Option<f64>,
    /// Index into [`crate::System::parameters`] if it is a parameter of the system, which has one value
    /// wherever it is named.
    pub shared: Option<usize>,
}

impl SensorParameter {
    /// A value that is known.
    pub fn fixed(value: f64) -> SensorParameter {
        SensorParameter { start: value, within: None, sigma: None, shared: None }
    }
}

/// A property of a [`Sensor`] that may be to be found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SensorPart {
    /// Zero error, in the unit of the column.
    Offset,
    /// Scale error.
    Gain,
    /// Lateness in seconds.
    Delay,
    /// The error of the rate of its clock.
    Clock,
    /// The time constant with which it follows, in seconds.
    Lag,
}

impl SensorPart {
    /// All of them, in the order of [`Sensor::parameters`].
    pub const ALL: [SensorPart; 5] =
        [SensorPart::Offset, SensorPart::Gain, SensorPart::Delay, SensorPart::Clock, SensorPart::Lag];

    /// As the spec writes it.
    pub fn name(self) -> &'static str {
        match self {
            SensorPart::Offset => "offset",
            SensorPart::Gain => "gain",
            SensorPart::Delay => "delay",
            SensorPart::Clock => "clock",
            SensorPart::Lag => "lag",
        }
    }

    /// The one of this name.
    pub fn named(name: &str) -> Option<SensorPart> {
        SensorPart::ALL.into_iter().find(|part| part.name() == name)
    }

    /// Its unit, where the column has the unit `column`; empty for a plain number.
    pub fn unit(self, column: &str) -> &str {
        match self {
            SensorPart::Offset => column,
            SensorPart::Gain | SensorPart::Clock => "",
            SensorPart::Delay | SensorPart::Lag => "s",
        }
    }
}

/// The reading of a sensor: `gain * quantity(t - delay + clock*(t - since)) + offset`, of a mean over the time `average`
/// before that, which is followed with a lag of first order.
///
/// ```
/// use phisindy_phys::{Sensor, SensorParameter};
/// use phisindy_signal::Interpolation;
/// // A laser whose zero is off by 2 mm.
/// let laser = Sensor { offset: SensorParameter::fixed(2e-3), ..Sensor::default() };
/// let place = laser.corrected(&[0.0, 0.1].into(), vec![2e-3, 5e-3], Interpolation::Linear).unwrap();
/// assert!((place[1] - 3e-3).abs() < 1e-15);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Sensor {
    /// Zero offset.
    pub offset: SensorParameter,
    /// Scale factor.
    pub gain: SensorParameter,
    /// Delay in seconds.
    pub delay: SensorParameter,
    /// By which part of itself the true time that passes is longer than that of the sensor's clock.
    pub clock: SensorParameter,
    /// The time constant with which it follows (s).
    pub lag: SensorParameter,
    /// Since when its clock drifts: the first time of its file (s).
    pub since: f64,
    /// The step of the column (SI), if it is known.
    pub quantum: Option<f64>,
    /// Over how long each sample is the mean, up to its time (s).
    pub average: f64,
    /// For an input derived from another one: the index of that input, which has the sensor.
    pub follows: Option<usize>,
}

impl Sensor {
    /// What may be to be found, in the order of [`SensorPart::ALL`].
    pub fn parameters(&self) -> [&SensorParameter; SensorPart::ALL.len()] {
        [&self.offset, &self.gain, &self.delay, &self.clock, &self.lag]
    }

    /// The same, to be changed.
    pub fn parameters_mut(&mut self) -> [&mut SensorParameter; SensorPart::ALL.len()] {
        [&mut self.offset, &mut self.gain, &mut self.delay, &mut self.clock, &mut self.lag]
    }

    /// Offset and gain as far as they are known before a fit: a zero that is to be found is taken for none, for the
    /// motion is nearly the same about any; a scale counts from where it starts.
    ///
    /// ```
    /// use phisindy_phys::{Sensor, SensorParameter};
    /// let millimetres = Sensor { gain: SensorParameter::fixed(1e3), ..Sensor::default() };
    /// assert_eq!(millimetres.known_before(), (0.0, 1e3));
    /// ```
    pub fn known_before(&self) -> (f64, f64) {
        let offset = if self.offset.within.is_none() { self.offset.start } else { 0.0 };
        (offset, self.gain.start)
    }

    /// The reading at the sample times, from the quantity at these times. Parameters that are to be found are
    /// taken as perfect. Beyond the ends a delayed column is extrapolated by its interpolation.
    ///
    /// # Errors
    /// The quantity is no signal.
    pub fn reading(
        &self,
        time: &Arc<[f64]>,
        values: Vec<f64>,
        kind: Interpolation,
    ) -> Result<Vec<f64>, SignalError> {
        let known = |p: &SensorParameter, perfect: f64| if p.within.is_none() { p.start } else { perfect };
        let (offset, gain, delay) =
            (known(&self.offset, 0.0), known(&self.gain, 1.0), known(&self.delay, 0.0));
        let (clock, lag) = (known(&self.clock, 0.0), known(&self.lag, 0.0));
        let late = if (delay, clock, self.average, lag) == (0.0, 0.0, 0.0, 0.0) {
            values
        } else {
            let signal = Signal::new(time.clone(), values, kind)?;
            let shown = |t: &f64| t - delay + clock * (t - self.since);
            let mean = |t: f64| {
                let parts = (0..MEAN_OF).map(|k| (k as f64 + 0.5) / MEAN_OF as f64 * self.average);
                parts.map(|back| signal.value(t - back)).sum::<f64>() / MEAN_OF as f64
            };
            let moment = |t: f64| if self.average > 0.0 { mean(t) } else { signal.value(t) };
            let followed =
                |t: f64| LAG_MOMENTS.iter().map(|(back, part)| part * moment(t - back * lag)).sum();
            time.iter().map(shown).map(|t| if lag > 0.0 { followed(t) } else { moment(t) }).collect()
        };
        Ok(if (offset, gain) == (0.0, 1.0) { late } else { late.iter().map(|x| gain * x + offset).collect() })
    }

    /// When what it reads at `t` was, each parameter at its start.
    pub(crate) fn shown(&self, t: f64) -> f64 {
        t - self.lateness() + self.clock.start * (t - self.since)
    }

    /// How late it is, each parameter at its start. A mean over a time is late by half of it, a lag by its time constant.
    pub fn lateness(&self) -> f64 {
        self.delay.start + 0.5 * self.average + self.lag.start
    }

    /// The quantity at the sample times, from the reading, each parameter at its start. Beyond the ends a
    /// delayed column is extrapolated by its interpolation.
    ///
    /// # Errors
    /// The column is no signal.
    pub fn corrected(
        &self,
        time: &Arc<[f64]>,
        column: Vec<f64>,
        kind: Interpolation,
    ) -> Result<Vec<f64>, SignalError> {
        let [offset, gain, _, clock, _] = self.parameters().map(|p| p.start);
        let delay = self.lateness();
        let column = if (delay, clock) == (0.0, 0.0) {
            column
        } else {
            let signal = Signal::new(time.clone(), column, kind)?;
            let shown = |t: f64| t + (delay - clock * (t - self.since)) / (1.0 + clock);
            time.iter().map(|&t| signal.value(shown(t))).collect()
        };
        Ok(if (offset, gain) == (0.0, 1.0) {
            column
        } else {
            column.iter().map(|x| (x - offset) / gain).collect()
        })
    }
}

/// Parts of the time of a mean, each as it is in its middle.
const MEAN_OF: usize = 32;

/// Which moments a sensor with a lag of first order shows: how far each is back, in time constants, and its part. Its
/// reading is the mean of the past with the weight `exp(-s)` at `s` time constants back. The rule of Gauss and Laguerre with
/// four nodes is exact for polynomials of degree 7, and good to 5e-5 of a vibration whose radian is two time constants (NIST Digital Library of Mathematical Functions, table 3.5.6). The mean moment stands in the middle and has no part.
pub const LAG_MOMENTS: [(f64, f64); 5] = [
    (0.322_547_689_619_392_3, 0.603_154_104_341_633_6),
    (1.745_761_101_158_346_6, 0.357_418_692_437_799_7),
    (1.0, 0.0),
    (4.536_620_296_921_128, 0.038_887_908_515_005_38),
    (9.395_070_912_301_133, 0.000_539_294_705_561_327_4),
];

impl Default for Sensor {
    fn default() -> Self {
        let fixed = SensorParameter::fixed;
        let [offset, gain, delay, clock, lag] = [0.0, 1.0, 0.0, 0.0, 0.0].map(fixed);
        Sensor { offset, gain, delay, clock, lag, since: 0.0, quantum: None, average: 0.0, follows: None }
    }
}
