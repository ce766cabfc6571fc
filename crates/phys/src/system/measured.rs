//! The samples of an input, in the window of its record and before it.

use crate::system::sensor::Sensor;
use crate::system::table::{Samples, Table};
use crate::text::diagnostic::Diagnostic;
use phisindy_signal::{Differentiator, Interpolation, Signal, SignalError, Smoothing, differentiate};
use std::sync::Arc;

/// An input as it was sampled (SI).
pub(crate) struct Measured {
    /// Those of the record, or its own.
    time: Arc<[f64]>,
    pub(crate) values: Vec<f64>,
    /// What drove the rig before the window: a sensor that is late shows it there.
    before: Samples,
}

impl Measured {
    /// The column at this place of a table, whose rows have these times.
    pub(crate) fn of(table: &Table, place: usize, rows: &Arc<[f64]>) -> Measured {
        if let Some(Some(own)) = table.own.get(place) {
            return Measured::of_own(own, rows);
        }
        let values = table.before.1.get(place).cloned().unwrap_or_default();
        let before = Samples { time: table.before.0.clone(), values };
        Measured { time: rows.clone(), values: table.columns[place].clone(), before }
    }

    /// Samples with times of their own: what stands before the rows was before, but for the last one of these.
    fn of_own(own: &Samples, rows: &[f64]) -> Measured {
        let first = rows.first().map_or(0, |start| own.time.partition_point(|t| t <= start));
        let (first, mut before) = (first.saturating_sub(1), own.clone());
        let values = before.values.split_off(first);
        let time = before.time.split_off(first);
        Measured { time: time.into(), values, before }
    }

    /// What the sensor saw, when it was, each of its parameters at its start. The samples stay as they are: read anew at
    /// the times of the rows, a held input would move by whole samples.
    pub(crate) fn corrected(self, sensor: &Sensor) -> Measured {
        let Measured { time, values, before } = self;
        let value = |x: f64| (x - sensor.offset.start) / sensor.gain.start;
        let seen = |values: Vec<f64>| values.into_iter().map(value).collect();
        let late = (sensor.lateness(), sensor.clock.start) != (0.0, 0.0);
        let when = |times: &[f64]| times.iter().map(|&t| sensor.shown(t)).collect::<Vec<f64>>();
        let (time, lead) = if late { (when(&time).into(), when(&before.time)) } else { (time, before.time) };
        Measured { time, values: seen(values), before: Samples { time: lead, values: seen(before.values) } }
    }

    /// The samples smoothed, their derivative, and how they were smoothed.
    ///
    /// # Errors
    /// They have no derivative.
    pub(crate) fn differentiated(
        &self,
        how: Differentiator,
    ) -> Result<(Measured, Measured, Smoothing), Diagnostic> {
        let of = |time: &[f64], values: &[f64]| {
            differentiate(time, values, how)
                .map_err(|e: SignalError| Diagnostic::error(format!("cannot differentiate: {e}")))
        };
        let own = of(&self.time, &self.values)?;
        let (mut smooth, mut slope) = (Samples::default(), Samples::default());
        let lead = self.before.time.len();
        if lead > 0 {
            let time: Vec<f64> = self.before.time.iter().chain(self.time.iter()).copied().collect();
            let all: Vec<f64> = self.before.values.iter().chain(&self.values).copied().collect();
            let d = of(&time, &all)?;
            let lead =
                |values: &[f64]| Samples { time: time[..lead].to_vec(), values: values[..lead].to_vec() };
            (smooth, slope) = (lead(&d.values), lead(&d.derivative));
        }
        let with = |values, before| Measured { time: self.time.clone(), values, before };
        Ok((with(own.values, smooth), with(own.derivative, slope), own.smoothing))
    }

    /// As a function of time.
    ///
    /// # Errors
    /// The samples are no signal.
    pub(crate) fn signal(self, kind: Interpolation) -> Result<Signal, SignalError> {
        Signal::new(self.time, self.values, kind)?.preceded(&self.before.time, &self.before.values)
    }
}
