//! Sensors: how a column differs from the quantity that it measures.

use phisindy_signal::{Interpolation, Signal, SignalError};
use std::sync::Arc;

/// A sensor parameter: held, or found in the fit.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorParameter {
    /// The value, or where the search starts (SI).
    pub start: f64,
    /// Bounds of the search; `None` for a value that is held.
    pub within: Option<(f64, f64)>,
    /// Belief beforehand.
    pub sigma: Option<f64>,
    /// The parameter of the system that it is (index into [`crate::System::parameters`]): one value wherever it is named.
    pub shared: Option<usize>,
}

impl SensorParameter {
    /// A value that is known.
    pub fn held(value: f64) -> SensorParameter {
        SensorParameter { start: value, within: None, sigma: None, shared: None }
    }
}

/// What a column says: `gain * quantity(t - delay) + offset`.
///
/// ```
/// use phisindy_phys::{Sensor, SensorParameter};
/// use phisindy_signal::Interpolation;
/// // A laser whose zero is off by 2 mm.
/// let laser = Sensor { offset: SensorParameter::held(2e-3), ..Sensor::default() };
/// let place = laser.undone(&[0.0, 0.1].into(), vec![2e-3, 5e-3], Interpolation::Linear).unwrap();
/// assert!((place[1] - 3e-3).abs() < 1e-15);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Sensor {
    /// Zero error.
    pub offset: SensorParameter,
    /// Scale error.
    pub gain: SensorParameter,
    /// Lateness in seconds.
    pub delay: SensorParameter,
    /// For an input that is derived from another one: that input, whose sensor it is.
    pub follows: Option<usize>,
}

impl Sensor {
    /// What the column says at the sample times, from the quantity there, as far as the sensor is known: what is to be found of it is taken for
    /// perfect. Beyond the ends a late column goes on as its interpolation does.
    ///
    /// # Errors
    /// The quantity is no signal.
    pub fn done(
        &self,
        time: &Arc<[f64]>,
        values: Vec<f64>,
        kind: Interpolation,
    ) -> Result<Vec<f64>, SignalError> {
        let known = |p: &SensorParameter, perfect: f64| if p.within.is_none() { p.start } else { perfect };
        let (offset, gain, delay) =
            (known(&self.offset, 0.0), known(&self.gain, 1.0), known(&self.delay, 0.0));
        let late = if delay == 0.0 {
            values
        } else {
            let signal = Signal::new(time.clone(), values, kind)?;
            time.iter().map(|t| signal.value(t - delay)).collect()
        };
        Ok(if (offset, gain) == (0.0, 1.0) { late } else { late.iter().map(|x| gain * x + offset).collect() })
    }

    /// The quantity at the sample times, from what the column says of it, each parameter at its start. Beyond the ends a late column goes on as
    /// its interpolation does.
    ///
    /// # Errors
    /// The column is no signal.
    pub fn undone(
        &self,
        time: &Arc<[f64]>,
        column: Vec<f64>,
        kind: Interpolation,
    ) -> Result<Vec<f64>, SignalError> {
        let (offset, gain, delay) = (self.offset.start, self.gain.start, self.delay.start);
        let column = if delay == 0.0 {
            column
        } else {
            let signal = Signal::new(time.clone(), column, kind)?;
            time.iter().map(|t| signal.value(t + delay)).collect()
        };
        Ok(if (offset, gain) == (0.0, 1.0) {
            column
        } else {
            column.iter().map(|x| (x - offset) / gain).collect()
        })
    }
}

impl Default for Sensor {
    fn default() -> Self {
        let held = SensorParameter::held;
        Sensor { offset: held(0.0), gain: held(1.0), delay: held(0.0), follows: None }
    }
}
