//! Sums of sines with random phases: a random shape with exact value and slope.

use std::f64::consts::TAU;
use std::fmt;

use rand::RngExt;

use crate::decisions::MOST_SINES;
use crate::noise::Streams;

#[cfg(test)]
mod tests;

/// Why an excitation cannot be built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ExcitationError {
    /// A parameter is not a positive finite number.
    NotPositive {
        /// Its name.
        parameter: &'static str,
        /// Its value.
        value: f64,
    },
    /// The upper frequency lies below the lower one.
    EmptyBand {
        /// The lower end.
        low: f64,
        /// The upper end.
        high: f64,
    },
    /// The band and the step give no sine, or more than a hundred thousand.
    Count(f64),
}

impl fmt::Display for ExcitationError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotPositive { parameter, value } => {
                write!(f, "{parameter} must be a positive number, not {value}")
            }
            Self::EmptyBand { low, high } => write!(f, "the band from {low} to {high} is empty"),
            Self::Count(count) => write!(f, "{count} sines asked for; 1 to {MOST_SINES} are possible"),
        }
    }
}

impl std::error::Error for ExcitationError {}

/// `sum of amplitude * cos(omega t + phase)`: a function of time whose only random part is the phases.
///
/// The three lists have the same length, which `new`, `jonswap` and `band` guarantee.
///
/// ```
/// use phisindy_sim::Multisine;
/// let force = Multisine::jonswap(10.0, 0.5, 3.3, 0.1, 50.0, 0.1, 42)?;
/// assert_eq!(force.omegas().len(), 500);
/// assert_eq!(force.values_on_grid(0.0, 0.01, 3).len(), 3);
/// # Ok::<(), phisindy_sim::ExcitationError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Multisine {
    amplitudes: Vec<f64>,
    omegas: Vec<f64>,
    phases: Vec<f64>,
}

impl Multisine {
    /// A sum of given `(amplitude, omega in rad/s, phase in rad)`.
    pub fn new(terms: impl IntoIterator<Item = (f64, f64, f64)>) -> Self {
        let (mut amplitudes, mut omegas, mut phases) = (Vec::new(), Vec::new(), Vec::new());
        for (amplitude, omega, phase) in terms {
            amplitudes.push(amplitude);
            omegas.push(omega);
            phases.push(phase);
        }
        Self { amplitudes, omegas, phases }
    }

    /// Amplitudes `sqrt(2 S d_omega)` from the JONSWAP spectrum, eq. (49) of the paper (Hasselmann et al.
    /// 1973):
    ///
    /// `S = 320 (hs/tp^2)^2 / w^5 * exp(-1.25 (wp/w)^4) * gamma^exp(-(w-wp)^2 / (2 s^2 wp^2))`, `wp = 2
    /// pi/tp`, `s` = 0.07 below `wp` and 0.09 from it on; phases uniform, from the seed.
    ///
    /// `hs` (significant height) in the unit of the excitation, `tp` (peak period) in s, the grid `omega_min,
    /// omega_min + d_omega, ... omega_max` in rad/s. For `gamma` = 3.3 the standard deviation is about
    /// `hs/4`.
    ///
    /// # Errors
    /// A parameter that is not positive and finite, an empty band, or more than a hundred thousand sines.
    pub fn jonswap(
        hs: f64,
        tp: f64,
        gamma: f64,
        omega_min: f64,
        omega_max: f64,
        d_omega: f64,
        seed: u64,
    ) -> Result<Self, ExcitationError> {
        positive("the significant height", hs)?;
        positive("the peak period", tp)?;
        positive("gamma", gamma)?;
        positive("the frequency step", d_omega)?;
        ordered("the lowest frequency", omega_min, "the highest frequency", omega_max)?;
        // The last frequency belongs to the grid although 0.1 + 499 * 0.1 may miss 50 by a rounding.
        let count = ((omega_max - omega_min) / d_omega + 1e-6).floor() + 1.0;
        let omegas = (0..counted(count)?).map(|i| omega_min + i as f64 * d_omega);
        Ok(Self::random_phases(
            omegas.map(|w| ((2.0 * jonswap_density(hs, tp, gamma, w) * d_omega).sqrt(), w)),
            seed,
        ))
    }

    /// `count` sines of equal amplitude, evenly spaced from `f_lo_hz` to `f_hi_hz` (both included; a single
    /// one sits in the middle), with standard deviation `rms` over a common period and random phases from the
    /// seed.
    ///
    /// # Errors
    /// A parameter that is not positive and finite, an empty band, no sine or more than a hundred thousand.
    pub fn band(
        rms: f64,
        f_lo_hz: f64,
        f_hi_hz: f64,
        count: usize,
        seed: u64,
    ) -> Result<Self, ExcitationError> {
        positive("the rms", rms)?;
        ordered("the lowest frequency", f_lo_hz, "the highest frequency", f_hi_hz)?;
        let count = counted(count as f64)?;
        let amplitude = rms * (2.0 / count as f64).sqrt();
        let omegas = (0..count).map(|i| {
            let share = if count == 1 { 0.5 } else { i as f64 / (count - 1) as f64 };
            TAU * (f_lo_hz + share * (f_hi_hz - f_lo_hz))
        });
        Ok(Self::random_phases(omegas.map(|w| (amplitude, w)), seed))
    }

    fn random_phases(lines: impl Iterator<Item = (f64, f64)>, seed: u64) -> Self {
        let mut rng = Streams(seed).stream("multisine phases");
        Self::new(lines.map(|(amplitude, omega)| (amplitude, omega, TAU * rng.random::<f64>())))
    }

    /// Amplitudes, in the unit of the excitation.
    pub fn amplitudes(&self) -> &[f64] {
        &self.amplitudes
    }

    /// Angular frequencies, rad/s.
    pub fn omegas(&self) -> &[f64] {
        &self.omegas
    }

    /// Phases, rad.
    pub fn phases(&self) -> &[f64] {
        &self.phases
    }

    fn terms(&self) -> impl Iterator<Item = (f64, f64, f64)> {
        self.amplitudes.iter().zip(&self.omegas).zip(&self.phases).map(|((&a, &w), &p)| (a, w, p))
    }

    /// The value at time `t` (s).
    pub fn value(&self, t: f64) -> f64 {
        self.terms().map(|(a, w, p)| a * (w * t + p).cos()).sum()
    }

    /// The exact time derivative at `t` (s).
    pub fn slope(&self, t: f64) -> f64 {
        self.terms().map(|(a, w, p)| -a * w * (w * t + p).sin()).sum()
    }

    /// The values at `start + i * step`, i = 0 .. `count` - 1; agrees with [`value`](Self::value) to about
    /// 1e-13 of the sum of amplitudes and costs a few multiplications per sine instead of a cosine.
    pub fn values_on_grid(&self, start: f64, step: f64, count: usize) -> Vec<f64> {
        // The rotation accumulates rounding errors; a new cosine after each block keeps them near 1e-15.
        const FRESH: usize = 64;
        let mut values = vec![0.0; count];
        for (a, w, p) in self.terms() {
            let (sin_step, cos_step) = (w * step).sin_cos();
            for (block, chunk) in values.chunks_mut(FRESH).enumerate() {
                let t = start + (block * FRESH) as f64 * step;
                let (mut s, mut c) = (w * t + p).sin_cos();
                for value in chunk {
                    *value += a * c;
                    (s, c) = (s * cos_step + c * sin_step, c * cos_step - s * sin_step);
                }
            }
        }
        values
    }

    /// Largest absolute value on the grid `t0, t0 + step, ...` up to `t1` (included if the grid meets it), to
    /// the precision of [`values_on_grid`](Self::values_on_grid); 0 where that grid is empty or a number is
    /// not finite.
    pub fn max_abs(&self, t0: f64, t1: f64, step: f64) -> f64 {
        let steps = ((t1 - t0) / step + 1e-6).floor();
        if !(steps.is_finite() && steps >= 0.0 && step > 0.0) {
            return 0.0;
        }
        // In pieces: a tiny step costs time, not memory.
        const PIECE: u64 = 65_536;
        let count = steps as u64 + 1;
        let piece = |first: u64| {
            let length = PIECE.min(count - first) as usize;
            self.values_on_grid(t0 + first as f64 * step, step, length)
                .into_iter()
                .fold(0.0, |m: f64, v| m.max(v.abs()))
        };
        (0..count.div_ceil(PIECE)).map(|i| piece(i * PIECE)).fold(0.0, f64::max)
    }
}

/// Spectral density at `w` rad/s, unit of `hs` squared times seconds.
fn jonswap_density(hs: f64, tp: f64, gamma: f64, w: f64) -> f64 {
    let peak = TAU / tp;
    let width = if w < peak { 0.07 } else { 0.09 };
    let enhancement = (-((w - peak) / (width * peak)).powi(2) / 2.0).exp();
    320.0 * (hs / (tp * tp)).powi(2) / w.powi(5)
        * (-1.25 * (peak / w).powi(4)).exp()
        * gamma.powf(enhancement)
}

fn positive(parameter: &'static str, value: f64) -> Result<(), ExcitationError> {
    let fine = value.is_finite() && value > 0.0;
    if fine { Ok(()) } else { Err(ExcitationError::NotPositive { parameter, value }) }
}

fn ordered(
    low_name: &'static str,
    low: f64,
    high_name: &'static str,
    high: f64,
) -> Result<(), ExcitationError> {
    positive(low_name, low)?;
    positive(high_name, high)?;
    if low <= high { Ok(()) } else { Err(ExcitationError::EmptyBand { low, high }) }
}

fn counted(count: f64) -> Result<usize, ExcitationError> {
    if (1.0..=MOST_SINES).contains(&count) { Ok(count as usize) } else { Err(ExcitationError::Count(count)) }
}
