//! The noise of a column, estimated from residuals: `variance = additive^2 + (relative * prediction)^2`.
//!
//! One form serves relative noise (eq. (34)), additive noise and sensor noise; the data tell which it is.
//! Where a state is zero relative noise vanishes and the likelihood is unbounded, so the additive part has a
//! floor.

use crate::decisions::{MIXED_NOISE, NOISE_GAIN, NOISE_ITERATIONS, NOISE_RANK};
use crate::result::identified::NoiseModel;
use phisindy_phys::Record;
use phisindy_signal::standard_deviation;

/// Variance of one column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ColumnNoise {
    /// Standard deviation of the part that does not depend on the signal.
    pub(crate) additive: f64,
    /// Fraction of the signal.
    pub(crate) relative: f64,
}

impl ColumnNoise {
    pub(crate) fn variance(&self, prediction: f64) -> f64 {
        self.additive * self.additive + (self.relative * prediction) * (self.relative * prediction)
    }

    /// Maximum likelihood for Gaussian residuals, by Fisher scoring on the two variances: squared residuals
    /// are regressed on 1 and prediction^2 with weights 1/variance^2. The part that does not depend on the
    /// signal is at least `floor`, see [`least_noise`].
    pub(crate) fn estimate(residuals: &[f64], predictions: &[f64], floor: f64) -> ColumnNoise {
        let n = residuals.len().max(1) as f64;
        let mean = residuals.iter().map(|r| r * r).sum::<f64>() / n;
        let floor = floor.powi(2).max(f64::MIN_POSITIVE);
        let size = predictions.iter().map(|p| p * p).sum::<f64>() / n;
        let alone = ColumnNoise { additive: mean.max(floor).sqrt(), relative: 0.0 };
        if size <= 0.0 || mean <= 0.0 {
            return alone;
        }
        let likelihood = |a: f64, b: f64| -> f64 {
            residuals
                .iter()
                .zip(predictions)
                .map(|(r, p)| {
                    let v = a + b * p * p;
                    v.ln() + r * r / v
                })
                .sum()
        };
        let mut best = (alone.additive.powi(2), 0.0);
        let mut best_value = likelihood(best.0, best.1);
        // From both ends: all additive, all relative.
        for start in [(0.5 * mean, 0.5 * mean / size), (floor, mean / size)] {
            let (mut a, mut b) = (start.0.max(floor), start.1);
            for _ in 0..NOISE_ITERATIONS {
                let (mut s11, mut s12, mut s22, mut r1, mut r2) = (0.0, 0.0, 0.0, 0.0, 0.0);
                for (r, p) in residuals.iter().zip(predictions) {
                    let q = p * p;
                    let w = 1.0 / (a + b * q).powi(2);
                    (s11, s12, s22) = (s11 + w, s12 + w * q, s22 + w * q * q);
                    (r1, r2) = (r1 + w * r * r, r2 + w * q * r * r);
                }
                let det = s11 * s22 - s12 * s12;
                let (mut next_a, mut next_b) = if det > NOISE_RANK * s11 * s22 {
                    ((s22 * r1 - s12 * r2) / det, (s11 * r2 - s12 * r1) / det)
                } else {
                    (r1 / s11, 0.0)
                };
                if next_b < 0.0 {
                    (next_a, next_b) = (r1 / s11, 0.0);
                }
                if next_a < floor {
                    (next_a, next_b) = (floor, ((r2 - floor * s12) / s22).max(0.0));
                }
                let moved = (next_a - a).abs() > NOISE_GAIN * a || (next_b - b).abs() > NOISE_GAIN * b;
                (a, b) = (next_a, next_b);
                if !moved {
                    break;
                }
            }
            let value = likelihood(a, b);
            // The second part must earn its place: BIC of one more parameter.
            let price = if best.1 == 0.0 && b > 0.0 { n.ln() } else { 0.0 };
            if value + price < best_value {
                (best, best_value) = ((a, b), value);
            }
        }
        ColumnNoise { additive: best.0.sqrt(), relative: best.1.sqrt() }
    }

    /// Its form, for a column with this standard deviation.
    pub(crate) fn kind(&self, deviation: f64) -> NoiseModel {
        let part = self.relative * deviation;
        if part < MIXED_NOISE * self.additive {
            NoiseModel::Additive
        } else if self.additive < MIXED_NOISE * part {
            NoiseModel::Relative
        } else {
            NoiseModel::Mixed
        }
    }
}

/// As [`least_noise`], of a column of a record; 0 without one.
pub(crate) fn least_noise_of(record: &Record, column: usize, part: f64) -> f64 {
    record.own_column(column).map_or(0.0, |(_, values)| least_noise(&values, record.rounding(column), part))
}

/// The least noise of a column: this part of its motion, and the rounding of its last digit (`step/sqrt(12)`,
/// which a sensor at rest does not show).
pub(crate) fn least_noise(column: &[f64], rounding: f64, part: f64) -> f64 {
    (part * standard_deviation(column)).max(rounding)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decisions::NOISE_FLOOR;

    /// A deterministic stand-in for normal numbers: the quantiles in a scrambled order.
    fn normal(n: usize) -> Vec<f64> {
        let erf_inv = |x: f64| {
            // Giles (2012), single precision is enough here.
            let w = -((1.0 - x) * (1.0 + x)).ln();
            let p = if w < 5.0 {
                let w = w - 2.5;
                [
                    2.81022636e-08,
                    3.43273939e-07,
                    -3.5233877e-06,
                    -4.39150654e-06,
                    0.00021858087,
                    -0.00125372503,
                    -0.00417768164,
                    0.246640727,
                    1.50140941,
                ]
                .iter()
                .fold(0.0, |s, c| s * w + c)
            } else {
                let w = w.sqrt() - 3.0;
                [
                    -0.000200214257,
                    0.000100950558,
                    0.00134934322,
                    -0.00367342844,
                    0.00573950773,
                    -0.0076224613,
                    0.00943887047,
                    1.00167406,
                    2.83297682,
                ]
                .iter()
                .fold(0.0, |s, c| s * w + c)
            };
            p * x
        };
        (0..n)
            .map(|k| (k * 7919) % n)
            .map(|k| std::f64::consts::SQRT_2 * erf_inv(2.0 * (k as f64 + 0.5) / n as f64 - 1.0))
            .collect()
    }

    #[test]
    fn tells_additive_from_relative() {
        let n = 4001;
        let signal: Vec<f64> = (0..n).map(|k| (k as f64 * 0.01).sin()).collect();
        let noise = normal(n);
        let additive: Vec<f64> = noise.iter().map(|e| 0.05 * e).collect();
        let found = ColumnNoise::estimate(&additive, &signal, 7e-4);
        assert!(
            (found.additive - 0.05).abs() < 0.002 && found.kind(0.7) == NoiseModel::Additive,
            "{found:?}"
        );
        let relative: Vec<f64> = noise.iter().zip(&signal).map(|(e, s)| 0.1 * e * s).collect();
        let found = ColumnNoise::estimate(&relative, &signal, 7e-4);
        assert!((found.relative - 0.1).abs() < 0.005 && found.kind(0.7) == NoiseModel::Relative, "{found:?}");
    }

    #[test]
    fn a_mixture_is_told_and_nothing_near_it_is_likelier() {
        let n = 4001;
        let signal: Vec<f64> = (0..n).map(|k| 1.5 * (k as f64 * 0.01).sin()).collect();
        let truth = ColumnNoise { additive: 0.05, relative: 0.1 };
        let residuals: Vec<f64> =
            normal(n).iter().zip(&signal).map(|(e, s)| e * truth.variance(*s).sqrt()).collect();
        let found = ColumnNoise::estimate(&residuals, &signal, 1.06e-3);
        assert_eq!(found.kind(1.06), NoiseModel::Mixed);
        // Its standard errors are some 2 and 3 % of it.
        assert!((found.additive / 0.05 - 1.0).abs() < 0.06, "{found:?}");
        assert!((found.relative / 0.1 - 1.0).abs() < 0.09, "{found:?}");
        let unlikely = |noise: ColumnNoise| -> f64 {
            let of = |(r, p): (&f64, &f64)| noise.variance(*p).ln() + r * r / noise.variance(*p);
            residuals.iter().zip(&signal).map(of).sum()
        };
        for (a, b) in [(0.999, 1.0), (1.001, 1.0), (1.0, 0.999), (1.0, 1.001)] {
            let near = ColumnNoise { additive: a * found.additive, relative: b * found.relative };
            assert!(unlikely(near) > unlikely(found), "{near:?} is likelier than {found:?}");
        }
    }

    /// A model of an encoder that has come to rest leaves nothing there, and yet no value is known better than a
    /// count.
    #[test]
    fn the_noise_of_an_encoder_is_at_least_that_of_its_step() {
        let count = |i: u32| (38.0 * (-0.0025 * f64::from(i)).exp() * (0.05 * f64::from(i)).cos()).round();
        let column: Vec<f64> = (0..2000).map(count).collect();
        let least = least_noise(&column, phisindy_signal::rounding_error(&column), NOISE_FLOOR);
        assert!((least - 12f64.sqrt().recip()).abs() < 1e-12, "{least}");
        let found = ColumnNoise::estimate(&[0.0; 2000], &column, least);
        assert_eq!(found, ColumnNoise { additive: least, relative: 0.0 });
    }

    #[test]
    fn a_residual_of_nothing_leaves_the_floor() {
        let signal = [1.0, -2.0, 0.5];
        let floor = ColumnNoise { additive: 0.002, relative: 0.0 };
        assert_eq!(ColumnNoise::estimate(&[0.0; 3], &signal, 0.002), floor);
        // A relative part has to earn its place: three samples of one size do not pay for it.
        let found = ColumnNoise::estimate(&[0.1, -0.1, 0.1], &signal, 0.002);
        assert!((found.additive - 0.1).abs() < 1e-15 && found.relative == 0.0, "{found:?}");
    }

    #[test]
    fn variances_add_and_the_larger_part_gives_the_name() {
        assert_eq!(ColumnNoise { additive: 3.0, relative: 0.5 }.variance(8.0), 25.0);
        let named = |relative, deviation| ColumnNoise { additive: 1.0, relative }.kind(deviation);
        assert_eq!([named(0.1, 2.0), named(0.1, 4.0)], [NoiseModel::Additive, NoiseModel::Mixed]);
        assert_eq!([named(1.0, 3.0), named(1.0, 4.0)], [NoiseModel::Mixed, NoiseModel::Relative]);
    }

    /// A relative part that makes the residuals likelier by less than its price (here by some 3 of ln n =
    /// 8.3) is left out, one that pays (by some 30) is not.
    #[test]
    fn a_relative_part_must_earn_its_place() {
        let n = 4001;
        let noise = normal(n);
        let signal: Vec<f64> = (0..n).map(|k| (k as f64 * 0.01).sin()).collect();
        let found = |part: f64| {
            let of = |(e, s): (&f64, &f64)| 0.05 * e * (1.0 + part * s * s).sqrt();
            let residuals: Vec<f64> = noise.iter().zip(&signal).map(of).collect();
            ColumnNoise::estimate(&residuals, &signal, 7e-4)
        };
        assert_eq!(found(0.11).relative, 0.0);
        assert!(found(0.4).relative > 0.02, "{:?}", found(0.4));
        // Where the signal has one size only, the two parts are the same thing.
        let flat: Vec<f64> = (0..n).map(|k| if k % 3 == 0 { 1.7 } else { -1.7 }).collect();
        let found = ColumnNoise::estimate(&noise, &flat, 1.7e-3);
        assert!(found.relative == 0.0 && (found.additive - 1.0).abs() < 2e-3, "{found:?}");
    }

    #[test]
    fn the_relative_part_knows_of_the_floor() {
        let n = 4001;
        let signal: Vec<f64> = (0..n).map(|k| (k as f64 * 0.01).sin()).collect();
        let residuals: Vec<f64> = normal(n).iter().zip(&signal).map(|(e, s)| 0.1 * e * s).collect();
        // A floor of 0.03 beside a noise that vanishes with the signal.
        let found = ColumnNoise::estimate(&residuals, &signal, 0.03);
        assert!((found.additive - 0.03).abs() < 1e-15, "{found:?}");
        let unlikely = |relative: f64| -> f64 {
            let noise = ColumnNoise { relative, ..found };
            let of = |(r, p): (&f64, &f64)| noise.variance(*p).ln() + r * r / noise.variance(*p);
            residuals.iter().zip(&signal).map(of).sum()
        };
        let [low, best, high] = [0.999, 1.0, 1.001].map(|part| unlikely(part * found.relative));
        assert!(low > best && high > best, "{found:?}: {low} {best} {high}");
    }
}
