//! Start values of the constants, from a regression on smoothed derivatives.

mod least_squares;
mod motion;
mod tester;
mod weak_form;

use least_squares::least_squares;
pub use motion::Motion;
use phisindy_signal::{automatic, standard_deviation};
pub use tester::Drive;
pub(crate) use tester::loses;
use weak_form::{CLEAR, Forced, forced};

/// Most rows of the regression: more do not improve a start value.
const MOST: usize = 20_000;

/// Coefficients of the acceleration `-stiffness*(x - u) - damping*(v - du) - friction*sgn(v) + input_gain*F`.
#[derive(Clone, Copy, Debug)]
pub struct Estimate {
    /// Per unit mass; `None` if the motion shows no spring.
    pub stiffness: Option<f64>,
    /// Per unit mass.
    pub damping: f64,
    /// Inverse mass, or acceleration per unit of the drive; `None` without an input.
    pub input_gain: Option<f64>,
    /// Displacement at which the spring is at rest, as the sensor reads it.
    pub rest: f64,
}

impl Motion {
    /// Estimates the coefficients by least squares.
    pub(crate) fn estimate(&self) -> Estimate {
        let n = self.time.len().min(MOST);
        let natural = self.frequency.map_or(1.0, |f| (std::f64::consts::TAU * f).powi(2));
        let mean = self.displacement[..n].iter().sum::<f64>() / n.max(1) as f64;
        let middle = if self.is_pendulum { *self.displacement.last().unwrap_or(&mean) } else { mean };
        let poor = Estimate {
            stiffness: Some(natural),
            damping: 0.1 * natural.sqrt(),
            input_gain: None,
            rest: middle,
        };
        let Ok(velocity) = automatic(&self.time[..n], &self.displacement[..n]) else { return poor };
        let Ok(rate) = automatic(&self.time[..n], &velocity.derivative) else { return poor };
        let (x, v) = (&velocity.values, &velocity.derivative);
        let du = self.base.as_ref().and_then(|u| automatic(&self.time[..n], &u[..n]).ok());
        let mut speeds: Vec<f64> = v.iter().map(|v| v.abs()).collect();
        speeds.sort_by(f64::total_cmp);
        let fast = speeds[n * 95 / 100];
        // The equation does not hold in sticking phases, and derivatives are inaccurate at turning points and
        // at the ends.
        let rows: Vec<usize> = (n / 100..n - n / 100).filter(|&k| v[k].abs() > 0.1 * fast).collect();
        let column = |f: &dyn Fn(usize) -> f64| rows.iter().map(|&k| f(k)).collect::<Vec<f64>>();
        let spring = column(&|k| match (&self.base, self.is_pendulum) {
            (Some(u), _) => -(x[k] - u[k]),
            (None, true) => -(x[k] - middle).sin(),
            (None, false) => -x[k],
        });
        let damper = column(&|k| -(v[k] - du.as_ref().map_or(0.0, |d| d.derivative[k])));
        let friction = column(&|k| -v[k].signum());
        let one = column(&|_| 1.0);
        let force = self.force.as_ref().map(|f| column(&|k| f[k]));
        let measured = self.acceleration.as_ref();
        let target = column(&|k| measured.map_or(rate.derivative[k], |a| a[k]));
        let turns = rows.windows(2).any(|w| v[w[0]] * v[w[1]] < 0.0);
        if self.force.is_none() && self.base.is_none() && !self.is_pendulum && !turns {
            return coasting(damper, one, spring, &target, mean);
        }
        // The weak form integrates a displacement; here that is an integral already.
        let driven = if measured.is_some() { None } else { forced(self, n) };
        if let Some(Forced { stiffness: None, damping, gain }) = driven
            && !self.is_pendulum
        {
            return Estimate { stiffness: None, damping, input_gain: Some(gain), rest: mean };
        }
        let mut columns = vec![damper, friction, one];
        columns.extend(force);
        columns.push(spring);
        let Some((c, _)) = least_squares(&columns, &target) else { return poor };
        let k = c[c.len() - 1];
        if k <= 0.0 {
            return match driven.filter(|_| !self.is_pendulum) {
                Some(Forced { stiffness, damping, gain }) => {
                    Estimate { stiffness, damping, input_gain: Some(gain), rest: mean }
                }
                None => poor,
            };
        }
        let rest = if self.is_pendulum || self.base.is_some() { middle } else { c[2] / k };
        let near = (rest - mean).abs() < 10.0 * standard_deviation(x);
        let rest = if self.base.is_some() || !near { mean } else { rest };
        let plain = Forced { stiffness: Some(k), damping: c[0], gain: c[3] };
        // Gravity on a large angle is no linear spring.
        let own = driven.filter(|_| !self.is_pendulum).unwrap_or(plain);
        let input_gain = self.force.as_ref().map(|_| own.gain).filter(|b| b.is_finite());
        Estimate { stiffness: own.stiffness, damping: own.damping, input_gain, rest }
    }

    /// The inertia that the size of force and acceleration suggest, where no regression tells it.
    pub(crate) fn plausible_inertia(&self) -> Option<f64> {
        let n = self.time.len().min(MOST);
        let size = standard_deviation(&self.force.as_ref()?[..n]);
        let speed = automatic(&self.time[..n], &self.displacement[..n]).ok()?;
        let rate = automatic(&self.time[..n], &speed.derivative).ok()?;
        let inertia = size / standard_deviation(&rate.derivative);
        (inertia.is_finite() && inertia > 0.0).then_some(inertia)
    }
}

/// The estimate for a free motion that never turns: it slides to its end, unless a spring, overdamped,
/// explains far more. (Friction is a constant force then.)
fn coasting(damper: Vec<f64>, one: Vec<f64>, spring: Vec<f64>, target: &[f64], mean: f64) -> Estimate {
    let without = least_squares(&[damper.clone(), one.clone()], target);
    let with = least_squares(&[damper, one, spring], target);
    let slides = Estimate { stiffness: None, damping: 0.0, input_gain: None, rest: mean };
    match (without, with) {
        (Some((_, plain)), Some((c, error))) if c[2] > 0.0 && error < CLEAR * plain => {
            Estimate { stiffness: Some(c[2]), damping: c[0], rest: c[1] / c[2], ..slides }
        }
        (Some((c, _)), _) => Estimate { damping: c[0], ..slides },
        (None, _) => slides,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_damped_swing_gives_its_constants() {
        let time: Vec<f64> = (0..2000).map(|k| 0.005 * f64::from(k)).collect();
        let displacement = time.iter().map(|t| 0.3 + 0.01 * (-0.2 * t).exp() * (7.0 * t).cos()).collect();
        let motion = Motion { time, displacement, frequency: Some(1.1), ..Motion::default() };
        let e = motion.estimate();
        assert!((e.stiffness.expect("a spring") - 49.04).abs() < 1.0, "{e:?}");
        assert!((e.damping - 0.4).abs() < 0.1 && (e.rest - 0.3).abs() < 1e-3, "{e:?}");
    }

    #[test]
    fn a_body_that_slides_to_its_end_has_no_spring() {
        let time: Vec<f64> = (0..2000).map(|k| 0.001 * f64::from(k)).collect();
        let sliding = |x: &dyn Fn(f64) -> f64| {
            let displacement = time.iter().map(|t| x(*t)).collect();
            Motion { time: time.clone(), displacement, frequency: Some(0.5), ..Motion::default() }.estimate()
        };
        let dry = sliding(&|t| 3.0 * t - 0.7 * t * t);
        let viscous = sliding(&|t| 2.0 * (1.0 - (-1.5 * t).exp()));
        assert!(dry.stiffness.is_none() && viscous.stiffness.is_none(), "{dry:?} {viscous:?}");
        assert!((viscous.damping - 1.5).abs() < 0.1, "{viscous:?}");
    }

    #[test]
    fn dependent_columns_are_refused() {
        let x: Vec<f64> = (0..50).map(f64::from).collect();
        assert!(least_squares(&[x.clone(), x.clone()], &x).is_none());
        let (c, left) = least_squares(&[x.clone(), vec![1.0; 50]], &x).expect("independent");
        assert!((c[0] - 1.0).abs() < 1e-9 && left < 1e-12);
    }
}
