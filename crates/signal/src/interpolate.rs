//! A sampled signal as a function of continuous time, with its exact slope.

use std::fmt;
use std::sync::Arc;

mod finer;
#[cfg(test)]
mod tests;

/// No hint: search the whole grid.
const NO_HINT: usize = usize::MAX;

/// How a [`Signal`] is interpolated between its samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// Zero-order hold: the last sample, as a digital controller puts it out.
    Hold,
    /// Straight lines between samples.
    Linear,
    /// A cubic spline with continuous second derivative and not-a-knot ends.
    Cubic,
}

/// Why samples are not a signal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SignalError {
    /// Fewer samples than needed.
    TooShort {
        /// How many there are.
        samples: usize,
        /// How many are needed.
        needed: usize,
    },
    /// The time column and the value column have different lengths.
    LengthMismatch {
        /// Length of the time column.
        times: usize,
        /// Length of the value column.
        values: usize,
    },
    /// A time or a value is NaN or infinite.
    NotFinite {
        /// Index of the sample.
        index: usize,
    },
    /// A time is not later than the one before it.
    NotIncreasing {
        /// Index of the later sample.
        index: usize,
    },
}

impl fmt::Display for SignalError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::TooShort { samples, needed } => {
                write!(f, "{samples} samples, but at least {needed} are needed")
            }
            Self::LengthMismatch { times, values } => write!(f, "{times} times but {values} values"),
            Self::NotFinite { index } => write!(f, "sample {index} is not a finite number"),
            Self::NotIncreasing { index } => {
                write!(f, "the time of sample {index} is not later than the one before it")
            }
        }
    }
}

impl std::error::Error for SignalError {}

/// Checks that `time` increases strictly and that all numbers of the two equally long columns are finite.
pub(crate) fn check_samples(time: &[f64], values: &[f64], needed: usize) -> Result<(), SignalError> {
    if time.len() != values.len() {
        return Err(SignalError::LengthMismatch { times: time.len(), values: values.len() });
    }
    if time.len() < needed {
        return Err(SignalError::TooShort { samples: time.len(), needed });
    }
    if let Some(index) = time.iter().zip(values).position(|(t, v)| !(t.is_finite() && v.is_finite())) {
        return Err(SignalError::NotFinite { index });
    }
    match time.windows(2).position(|pair| pair[1] <= pair[0]) {
        Some(before) => Err(SignalError::NotIncreasing { index: before + 1 }),
        None => Ok(()),
    }
}

/// Samples on a strictly increasing, possibly non-uniform time grid, read as a function of time.
///
/// Outside the grid `Hold` stays constant; `Linear` and `Cubic` continue in a straight line. Several signals
/// can share one grid. Values are in any unit, slopes in that unit per unit of time.
///
/// ```
/// use std::sync::Arc;
/// use phisindy_signal::{Interpolation, Signal};
///
/// let base = Signal::new(Arc::from([0.0, 1.0, 3.0]), vec![0.0, 2.0, 0.0], Interpolation::Linear)?;
/// assert_eq!((base.value(2.0), base.slope(2.0)), (1.0, -1.0));
/// # Ok::<(), phisindy_signal::SignalError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Signal {
    time: Arc<[f64]>,
    values: Vec<f64>,
    /// Slopes at the samples for `Cubic` (the spline in Hermite form), empty otherwise.
    slopes: Vec<f64>,
    kind: Interpolation,
    /// What it was before its first sample, if that is known.
    before: Option<Arc<Signal>>,
}

impl Signal {
    /// A signal with `values[i]` at `time[i]`. One sample is a constant.
    ///
    /// For `Cubic` this solves one tridiagonal system. On smooth signals the error of the slopes is h^4/180
    /// of the fifth derivative, a sixth of that of five-point differences. The error of the value is then
    /// that of cubic Hermite interpolation with exact slopes: 2.5e-5 of the amplitude at 20 samples per
    /// period.
    ///
    /// # Errors
    /// No sample, different lengths, a number that is not finite, or a time grid that does not increase.
    pub fn new(time: Arc<[f64]>, values: Vec<f64>, kind: Interpolation) -> Result<Self, SignalError> {
        check_samples(&time, &values, 1)?;
        let slopes = match kind {
            Interpolation::Cubic => spline_slopes(&time, &values),
            Interpolation::Hold | Interpolation::Linear => Vec::new(),
        };
        Ok(Self { time, values, slopes, kind, before: None })
    }

    /// The same signal, known before its first sample too: at these times, all of them earlier.
    ///
    /// # Errors
    /// As [`Signal::new`].
    ///
    /// ```
    /// use std::sync::Arc;
    /// use phisindy_signal::{Interpolation, Signal};
    ///
    /// let window = Signal::new(Arc::from([2.0, 3.0]), vec![4.0, 9.0], Interpolation::Linear)?;
    /// let known = window.clone().preceded(&[0.0, 1.0], &[0.0, 1.0])?;
    /// assert_eq!((window.value(1.0), known.value(1.0), known.value(1.5), known.value(2.5)), (-1.0, 1.0, 2.5, 6.5));
    /// assert_eq!(known.values(), [4.0, 9.0]);
    /// # Ok::<(), phisindy_signal::SignalError>(())
    /// ```
    pub fn preceded(self, time: &[f64], values: &[f64]) -> Result<Self, SignalError> {
        if time.is_empty() {
            return Ok(self);
        }
        // Up to the first sample, so that nothing jumps there.
        let time = time.iter().chain(&self.time[..1]).copied().collect();
        let values = values.iter().chain(&self.values[..1]).copied().collect();
        let before = Signal::new(time, values, self.kind)?;
        Ok(Self { before: Some(Arc::new(before)), ..self })
    }

    /// The signal by another clock: what was at `t` is at `pace * t + shift`.
    ///
    /// ```
    /// use std::sync::Arc;
    /// use phisindy_signal::{Interpolation, Signal};
    ///
    /// let ramp = Signal::new(Arc::from([0.0, 1.0, 2.0, 3.0]), vec![0.0, 1.0, 2.0, 3.0], Interpolation::Cubic)?;
    /// let slower = ramp.retimed(2.0, 1.0);
    /// assert_eq!((slower.value(4.0), slower.slope(4.0)), (1.5, 0.5));
    /// # Ok::<(), phisindy_signal::SignalError>(())
    /// ```
    pub fn retimed(&self, pace: f64, shift: f64) -> Signal {
        Signal {
            time: self.time.iter().map(|t| pace * t + shift).collect(),
            slopes: self.slopes.iter().map(|s| s / pace).collect(),
            before: self.before.as_ref().map(|before| Arc::new(before.retimed(pace, shift))),
            values: self.values.clone(),
            kind: self.kind,
        }
    }

    /// The signal in another unit: `offset + gain * value`.
    pub fn rescaled(&self, offset: f64, gain: f64) -> Signal {
        Signal {
            time: self.time.clone(),
            values: self.values.iter().map(|x| offset + gain * x).collect(),
            slopes: self.slopes.iter().map(|s| gain * s).collect(),
            kind: self.kind,
            before: self.before.as_ref().map(|before| Arc::new(before.rescaled(offset, gain))),
        }
    }

    /// The slope as a signal. What is held between samples has none there: it moves by steps, whose times are what a
    /// change of the clock moves.
    ///
    /// ```
    /// use std::sync::Arc;
    /// use phisindy_signal::{Interpolation, Signal};
    ///
    /// let ramp = Signal::new(Arc::from([2.0, 3.0, 5.0]), vec![2.0, 3.0, 4.0], Interpolation::Linear)?;
    /// let known = ramp.preceded(&[0.0, 1.0], &[0.0, 1.0])?.rescaled(1.0, 3.0);
    /// assert_eq!((known.rate().value(0.5), known.rate().value(3.5)), (3.0, 1.5));
    /// # Ok::<(), phisindy_signal::SignalError>(())
    /// ```
    pub fn rate(&self) -> Signal {
        let (values, kind) = match self.kind {
            Interpolation::Cubic => (spline_slopes(&self.time, &self.values), Interpolation::Cubic),
            Interpolation::Linear | Interpolation::Hold => {
                let mut hint = 0;
                let slope = |&t: &f64| self.value_and_slope(t, &mut hint).1;
                (self.time.iter().map(slope).collect(), Interpolation::Hold)
            }
        };
        let slopes = if kind == Interpolation::Cubic { spline_slopes(&self.time, &values) } else { vec![] };
        let before = self.before.as_ref().map(|before| Arc::new(before.rate()));
        Signal { time: self.time.clone(), slopes, values, kind, before }
    }

    /// The times of all samples, of those before its first one too.
    pub fn knots(&self) -> impl Iterator<Item = f64> {
        self.before.iter().flat_map(|before| before.time.iter()).chain(self.time.iter()).copied()
    }

    /// The time grid.
    pub fn time(&self) -> &Arc<[f64]> {
        &self.time
    }

    /// The samples.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// How the signal is interpolated.
    pub fn kind(&self) -> Interpolation {
        self.kind
    }

    /// The value at time `t`.
    pub fn value(&self, t: f64) -> f64 {
        let mut hint = NO_HINT;
        self.value_and_slope(t, &mut hint).0
    }

    /// The time derivative of [`value`](Self::value) at `t`; at a sample where it jumps, the one to the
    /// right.
    pub fn slope(&self, t: f64) -> f64 {
        let mut hint = NO_HINT;
        self.value_and_slope(t, &mut hint).1
    }

    /// The time derivative of [`slope`](Self::slope) at `t`, apart from jumps of the slope. The search starts at `hint`,
    /// as in [`value_and_slope`](Self::value_and_slope).
    ///
    /// ```
    /// # use std::sync::Arc;
    /// # use phisindy_signal::{Interpolation, Signal};
    /// let square = Signal::new(Arc::from([0.0, 1.0, 3.0, 4.0]), vec![0.0, 1.0, 9.0, 16.0], Interpolation::Cubic)?;
    /// assert!((square.bend(2.5, &mut 0) - 2.0).abs() < 1e-12 && square.bend(5.0, &mut 0) == 0.0);
    /// # Ok::<(), phisindy_signal::SignalError>(())
    /// ```
    pub fn bend(&self, t: f64, hint: &mut usize) -> f64 {
        let (i, last) = (self.interval(t, *hint), self.time.len() - 1);
        *hint = i;
        if let Some(before) = self.before.as_ref().filter(|_| t < self.time[0]) {
            return before.bend(t, &mut NO_HINT.clone());
        }
        if self.kind != Interpolation::Cubic || last == 0 || !(self.time[0]..=self.time[last]).contains(&t) {
            return 0.0;
        }
        let h = self.time[i + 1] - self.time[i];
        let chord = (self.values[i + 1] - self.values[i]) / h;
        let (s0, s1) = (self.slopes[i], self.slopes[i + 1]);
        let twist = s0 + s1 - 2.0 * chord;
        (2.0 * (chord - s0) + (6.0 * (t - self.time[i]) / h - 2.0) * twist) / h
    }

    /// Value and slope at `t`. The search for the interval starts at `hint`, which is set to the interval
    /// found.
    ///
    /// Neighbouring times, forwards or backwards, need no search. Any number is a valid hint.
    pub fn value_and_slope(&self, t: f64, hint: &mut usize) -> (f64, f64) {
        let last = self.time.len() - 1;
        let i = self.interval(t, *hint);
        *hint = i;
        if t.is_nan() {
            return (f64::NAN, f64::NAN);
        }
        if let Some(before) = self.before.as_ref().filter(|_| t < self.time[0]) {
            let mut hint = NO_HINT;
            return before.value_and_slope(t, &mut hint);
        }
        if last == 0 {
            return (self.values[0], 0.0);
        }
        if self.kind == Interpolation::Hold {
            let held = if t >= self.time[last] { last } else { i };
            return (self.values[held], 0.0);
        }
        let (t0, t1) = (self.time[i], self.time[i + 1]);
        let (v0, v1) = (self.values[i], self.values[i + 1]);
        let h = t1 - t0;
        let chord = (v1 - v0) / h;
        if self.kind == Interpolation::Linear {
            // Measured from the nearer end, so that samples are returned exactly.
            let value = if t - t0 <= t1 - t { v0 + chord * (t - t0) } else { v1 + chord * (t - t1) };
            return (value, chord);
        }
        let (s0, s1) = (self.slopes[i], self.slopes[i + 1]);
        if t <= t0 && i == 0 {
            return (v0 + s0 * (t - t0), s0);
        }
        if t >= t1 && i + 1 == last {
            return (v1 + s1 * (t - t1), s1);
        }
        // Newton form of the Hermite cubic.
        let u = (t - t0) / h;
        let bend = chord - s0;
        let twist = s0 + s1 - 2.0 * chord;
        let value = v0 + (t - t0) * (s0 + u * (bend + (u - 1.0) * twist));
        let slope = s0 + u * (2.0 * bend + (3.0 * u - 2.0) * twist);
        (value, slope)
    }

    /// Index of the interval that holds `t`, clamped to the first and the last one.
    fn interval(&self, t: f64, hint: usize) -> usize {
        let last = self.time.len().saturating_sub(2);
        if hint <= last {
            let mut i = hint;
            for _ in 0..4 {
                if i > 0 && t < self.time[i] {
                    i -= 1;
                } else if i < last && t >= self.time[i + 1] {
                    i += 1;
                } else {
                    return i;
                }
            }
        }
        self.time.partition_point(|&start| start <= t).saturating_sub(1).min(last)
    }
}

/// Slopes at the knots of the cubic spline whose third derivative is continuous at the second and
/// last-but-one knot.
///
/// C. de Boor, A Practical Guide to Splines, chapter IV.
fn spline_slopes(time: &[f64], values: &[f64]) -> Vec<f64> {
    let n = time.len();
    let step: Vec<f64> = time.windows(2).map(|t| t[1] - t[0]).collect();
    let chord: Vec<f64> = values.windows(2).zip(&step).map(|(v, h)| (v[1] - v[0]) / h).collect();
    match n {
        0 => return Vec::new(),
        1 => return vec![0.0],
        2 => return vec![chord[0]; 2],
        3 => {
            // Not-a-knot on three points is their parabola.
            let curvature = (chord[1] - chord[0]) / (step[0] + step[1]);
            return vec![
                chord[0] - curvature * step[0],
                chord[0] + curvature * step[0],
                chord[1] + curvature * step[1],
            ];
        }
        _ => {}
    }
    // Rows (below, diagonal, above | right side), eliminated downwards while they are written.
    let mut above = vec![0.0; n];
    let mut slopes = vec![0.0; n];
    for i in 0..n {
        let (below, diagonal, upper, right) = if i == 0 {
            let two = step[0] + step[1];
            let right = ((step[0] + 2.0 * two) * step[1] * chord[0] + step[0] * step[0] * chord[1]) / two;
            (0.0, step[1], two, right)
        } else if i == n - 1 {
            let (h, before) = (step[n - 2], step[n - 3]);
            let two = h + before;
            let right = (h * h * chord[n - 3] + (2.0 * two + h) * before * chord[n - 2]) / two;
            (two, before, 0.0, right)
        } else {
            let (h0, h1) = (step[i - 1], step[i]);
            (h1, 2.0 * (h0 + h1), h0, 3.0 * (h1 * chord[i - 1] + h0 * chord[i]))
        };
        let (above_before, right_before) = if i == 0 { (0.0, 0.0) } else { (above[i - 1], slopes[i - 1]) };
        let pivot = diagonal - below * above_before;
        above[i] = upper / pivot;
        slopes[i] = (right - below * right_before) / pivot;
    }
    for i in (0..n - 1).rev() {
        slopes[i] -= above[i] * slopes[i + 1];
    }
    slopes
}
