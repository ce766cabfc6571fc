//! A body on a spring with Coulomb friction, released: its motion is known in closed form.

use crate::dice::{Dice, rounded};
use std::f64::consts::PI;

/// Of a unit of mass, in SI.
#[derive(Clone, Debug)]
pub(super) struct Rig {
    /// Angular frequency, rad/s.
    pub(super) frequency: f64,
    /// Where it is released, m.
    pub(super) size: f64,
    /// Friction per mass, m/s^2.
    pub(super) friction: f64,
    /// Seconds between samples.
    pub(super) step: f64,
    pub(super) samples: usize,
}

impl Rig {
    /// From bristles to bridges.
    pub(super) fn draw(dice: &mut Dice) -> Rig {
        let (frequency, size) = (dice.log(1e-2, 1e4), dice.log(1e-6, 1e3) * dice.sign());
        // It swings four to twelve times until it sticks.
        let friction = rounded(dice.between(0.04, 0.12) * size.abs() * frequency * frequency);
        let (samples, periods) = (dice.whole(120, 500), dice.between(2.0, 7.0));
        let step = rounded(2.0 * PI * periods / (frequency * samples as f64));
        Rig { frequency, size, friction, step, samples }
    }

    /// Displacement and velocity.
    pub(super) fn at(&self, t: f64) -> (f64, f64) {
        let (w, size) = (self.frequency, self.size.abs());
        let shift = self.friction / (w * w);
        let left = |swing: f64| size - 2.0 * shift * swing;
        let side = |swing: f64| if swing % 2.0 == 0.0 { self.size.signum() } else { -self.size.signum() };
        let swing = (t * w / PI).floor();
        // It stays at the first turn at which friction holds the spring.
        let last = ((size - shift) / (2.0 * shift)).ceil().max(0.0);
        if swing >= last {
            return (side(last) * left(last), 0.0);
        }
        let swung = (left(swing) - shift) * self.size.signum();
        (side(swing) * shift + swung * (w * t).cos(), -swung * w * (w * t).sin())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Newton's law by differences, and the stop, where the spring is weaker than friction.
    #[test]
    fn the_motion_obeys_newton() {
        let rig = Rig { frequency: 2.0, size: -1.5, friction: 0.5, step: 0.01, samples: 900 };
        let h = 1e-4;
        for k in 0..900 {
            let t = 0.01 * f64::from(k) + 0.003;
            let ((x, v), (before, _), (after, _)) = (rig.at(t), rig.at(t - h), rig.at(t + h));
            assert!((v - (after - before) / (2.0 * h)).abs() < 1e-5, "{t}");
            let rate = (after - 2.0 * x + before) / (h * h);
            // A turn between the samples is a jump of the rate.
            let turns = (t - h < k as f64) && ((t * 2.0 / PI).fract() * PI / 2.0).min(1.0) < 2.0 * h;
            if v != 0.0 && !turns {
                assert!((rate + 4.0 * x + 0.5 * v.signum()).abs() < 1e-5, "{t}: {rate}");
            }
        }
        let (x, v) = rig.at(100.0);
        assert!(v == 0.0 && (4.0 * x).abs() <= 0.5);
    }
}
