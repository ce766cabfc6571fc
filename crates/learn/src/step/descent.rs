//! First-order optimisers of the step method.

use crate::decisions::{RADAM_BETA1, RADAM_BETA2, RADAM_EPSILON};

/// How coefficients follow the gradient.
#[derive(Clone, Debug)]
pub(crate) enum Descent {
    /// `p -= rate * g`
    Sgd,
    /// Rectified Adam (Liu et al., On the Variance of the Adaptive Learning Rate and Beyond, ICLR 2020,
    /// algorithm 2).
    RAdam { step: i32, mean: Vec<f64>, square: Vec<f64> },
}

impl Descent {
    pub(crate) fn radam(parameters: usize) -> Descent {
        Descent::RAdam { step: 0, mean: vec![0.0; parameters], square: vec![0.0; parameters] }
    }

    /// One update in place.
    pub(crate) fn update(&mut self, parameters: &mut [f64], gradient: &[f64], rate: f64) {
        match self {
            Descent::Sgd => parameters.iter_mut().zip(gradient).for_each(|(p, g)| *p -= rate * g),
            Descent::RAdam { step, mean, square } => {
                *step += 1;
                let (b1, b2) = (RADAM_BETA1.powi(*step), RADAM_BETA2.powi(*step));
                let longest = 2.0 / (1.0 - RADAM_BETA2) - 1.0;
                let length = longest - 2.0 * f64::from(*step) * b2 / (1.0 - b2);
                // The variance is tractable only once enough gradients were seen.
                let rectified = (length > 5.0).then(|| {
                    ((length - 4.0) * (length - 2.0) * longest / ((longest - 4.0) * (longest - 2.0) * length))
                        .sqrt()
                });
                for (k, g) in gradient.iter().enumerate() {
                    mean[k] = RADAM_BETA1 * mean[k] + (1.0 - RADAM_BETA1) * g;
                    square[k] = RADAM_BETA2 * square[k] + (1.0 - RADAM_BETA2) * g * g;
                    let m = mean[k] / (1.0 - b1);
                    parameters[k] -= match rectified {
                        Some(r) => rate * r * m * (1.0 - b2).sqrt() / (square[k].sqrt() + RADAM_EPSILON),
                        None => rate * m,
                    };
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// The first updates by hand: five steps of plain momentum (length <= 5), then the rectified ones.
    #[test]
    fn radam_follows_its_definition() {
        let mut descent = Descent::radam(1);
        let mut p = [1.0];
        let (mut m, mut v, mut expected) = (0.0, 0.0, 1.0_f64);
        for t in 1..=20 {
            let g = 2.0 * p[0];
            descent.update(&mut p, &[g], 0.1);
            let g = 2.0 * expected;
            m = 0.9 * m + 0.1 * g;
            v = 0.999 * v + 0.001 * g * g;
            let b2 = 0.999_f64.powi(t);
            let rho = 1999.0 - 2.0 * f64::from(t) * b2 / (1.0 - b2);
            let hat = m / (1.0 - 0.9_f64.powi(t));
            expected -= 0.1
                * if rho > 5.0 {
                    let r = ((rho - 4.0) * (rho - 2.0) * 1999.0 / (1995.0 * 1997.0 * rho)).sqrt();
                    hat * r / ((v / (1.0 - b2)).sqrt() + 1e-8 / (1.0 - b2).sqrt())
                } else {
                    hat
                };
            assert_relative_eq!(p[0], expected, max_relative = 1e-12);
        }
    }

    /// Down the square of a number each step takes the same part of it.
    #[test]
    fn sgd_goes_down_the_slope() {
        let (mut p, mut descent) = ([3.0, -1.0], Descent::Sgd);
        for _ in 0..10 {
            let gradient = p.map(|p| 2.0 * p);
            descent.update(&mut p, &gradient, 0.1);
        }
        assert_relative_eq!(p[0], 3.0 * 0.8_f64.powi(10), max_relative = 1e-14);
        assert_relative_eq!(p[1], -(0.8_f64.powi(10)), max_relative = 1e-14);
    }
}
