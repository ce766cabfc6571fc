//! Noise of a sensor, white or not.

use crate::dice::Dice;
use crate::noise::{first_order, white};
use std::f64::consts::TAU;

/// A kind of noise with a standard deviation of one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum SensorNoise {
    White,
    /// A first-order process, of which this part stays from sample to sample.
    Ar(f64),
    /// Student's distribution with so many degrees of freedom.
    Student(usize),
    /// Steps of a converter, and nothing else.
    Quantum,
    /// A tone of this angle per sample, and white noise of half the size.
    Hum(f64),
}

/// The tone has this rms beside white noise of a half.
const TONE: f64 = 0.866_025_403_784_438_6;

impl SensorNoise {
    /// One of them: white in four of ten.
    pub(super) fn draw(dice: &mut Dice) -> SensorNoise {
        match dice.whole(0, 19) {
            0..=7 => SensorNoise::White,
            8..=10 => SensorNoise::Ar(dice.between(0.3, 0.9)),
            11..=13 => SensorNoise::Student(dice.whole(3, 5)),
            14..=16 => SensorNoise::Quantum,
            _ => SensorNoise::Hum(dice.between(0.9, 2.8)),
        }
    }

    /// Its name in tables.
    pub(super) fn name(self) -> &'static str {
        match self {
            SensorNoise::White => "white",
            SensorNoise::Ar(_) => "AR(1)",
            SensorNoise::Student(_) => "Student t",
            SensorNoise::Quantum => "quantum",
            SensorNoise::Hum(_) => "hum",
        }
    }

    /// A column as a sensor with noise of this standard deviation reads it.
    pub(super) fn read(self, exact: &[f64], deviation: f64, dice: &mut Dice) -> Vec<f64> {
        let white: Vec<f64> = white(dice).take(exact.len()).collect();
        let noise: Vec<f64> = match self {
            SensorNoise::White => white,
            SensorNoise::Ar(stays) => {
                let mut state = first_order(stays, (1.0 - stays * stays).sqrt(), white[0]);
                white.iter().map(|e| state(*e)).collect()
            }
            SensorNoise::Student(freedom) => {
                let squares: Vec<Vec<f64>> =
                    (0..freedom).map(|_| crate::noise::white(dice).take(exact.len()).collect()).collect();
                let n = freedom as f64;
                let of = |(i, e): (usize, &f64)| {
                    let chi = squares.iter().map(|s| s[i] * s[i]).sum::<f64>();
                    e * ((n - 2.0) / chi).sqrt()
                };
                white.iter().enumerate().map(of).collect()
            }
            SensorNoise::Quantum => {
                let step = deviation * 12f64.sqrt();
                return exact.iter().map(|x| (x / step).round() * step).collect();
            }
            SensorNoise::Hum(angle) => {
                let phase = dice.between(0.0, TAU);
                let tone = |i: usize| TONE * 2f64.sqrt() * (angle * i as f64 + phase).cos();
                white.iter().enumerate().map(|(i, e)| 0.5 * e + tone(i)).collect()
            }
        };
        exact.iter().zip(noise).map(|(x, e)| x + deviation * e).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use phisindy_signal::standard_deviation;

    /// The size is that asked for, of every kind; the colour of AR(1) is its own.
    #[test]
    fn every_noise_has_its_size() {
        let exact: Vec<f64> = (0..20_000).map(|i| (0.013 * f64::from(i)).sin()).collect();
        let kinds = [0.0, 0.8].map(SensorNoise::Ar);
        let others =
            [SensorNoise::White, SensorNoise::Student(5), SensorNoise::Quantum, SensorNoise::Hum(1.3)];
        for kind in kinds.into_iter().chain(others) {
            let mut dice = Dice::new(3, kind.name());
            let noise: Vec<f64> =
                kind.read(&exact, 0.05, &mut dice).iter().zip(&exact).map(|(y, x)| y - x).collect();
            let size = standard_deviation(&noise);
            assert!((size / 0.05 - 1.0).abs() < 0.1, "{kind:?}: {size}");
            if let SensorNoise::Ar(stays) = kind {
                let product: f64 = noise.windows(2).map(|p| p[0] * p[1]).sum();
                let square: f64 = noise.iter().map(|e| e * e).sum();
                assert!((product / square - stays).abs() < 0.03, "{kind:?}: {}", product / square);
            }
        }
    }
}
