//! The equation of a driven motion in weak form: whether the data show a restoring force, and what the
//! inertia is.
//!
//! The equation is multiplied by a test function that vanishes with its slope at both ends of a stretch, and
//! integrated by parts, so that nothing is differentiated: the jumps of a relay stay where they are, while
//! they would be smeared in a second derivative.

use super::least_squares::least_squares;
use super::motion::Motion;
use phisindy_signal::moves_by_jumps;

/// A stretch is this part of the strongest period: over longer ones `-w^2 x` stands for any acceleration.
const STRETCH: f64 = 0.25;
/// Fewest steps of a stretch.
const MIN_STRETCH: usize = 12;
/// A model without a spring that leaves more than this part of the acceleration (mean squares) lacks
/// something.
const UNEXPLAINED: f64 = 0.5;
/// A spring that lowers what is left to this part is seen even if the rest explains most.
pub(super) const CLEAR: f64 = 0.1;

/// What drives the motion beside friction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Forced {
    /// Per unit mass; none if the data show no spring.
    pub(super) stiffness: Option<f64>,
    /// Per unit mass.
    pub(super) damping: f64,
    /// Acceleration per unit of the force.
    pub(super) gain: f64,
}

/// The coefficients of a driven motion; none if the columns do not tell them.
pub(super) fn forced(motion: &Motion, n: usize) -> Option<Forced> {
    let (columns, target) = weak(motion, n)?;
    let (without, left) = least_squares(&columns[..4], &target)?;
    let plain = Forced { stiffness: None, damping: without[0], gain: without[3] };
    let Some((with, less)) = least_squares(&columns, &target) else { return Some(plain) };
    let mean = target.iter().sum::<f64>() / target.len() as f64;
    let whole: f64 = target.iter().map(|y| (y - mean).powi(2)).sum();
    // A spring that takes the place of the force is `-w^2 x`, which any swing of one frequency fulfils.
    let beside = with[3] / without[3] > 0.5;
    let lacking = left > UNEXPLAINED * whole || without[3] <= 0.0;
    let spring = with[4] > 0.0 && (lacking || (less < CLEAR * left && beside));
    Some(if spring { Forced { stiffness: Some(with[4]), damping: with[0], gain: with[3] } } else { plain })
}

/// The integrals of damper, friction, constant, force and spring over each stretch, and those of the
/// acceleration.
pub(super) fn weak(motion: &Motion, n: usize) -> Option<(Vec<Vec<f64>>, Vec<f64>)> {
    let force = motion.force.as_ref()?;
    let (time, x) = (&motion.time[..n], &motion.displacement[..n]);
    let step = (time.last()? - time.first()?) / (n.max(2) - 1) as f64;
    let length = ((STRETCH / motion.frequency? / step) as usize).max(MIN_STRETCH);
    let held = moves_by_jumps(&force[..n]);
    let reach = (length / 10).max(1);
    let sign = |k: usize| (x[(k + reach).min(n - 1)] - x[k.saturating_sub(reach)]).signum();
    let (mut columns, mut target) = (vec![vec![]; 5], vec![]);
    for from in (0..n.saturating_sub(length + 1)).step_by((length / 4).max(1)) {
        let at = from..from + length;
        let span = time[at.end] - time[from];
        let middle = x[at.clone()].iter().sum::<f64>() / length as f64;
        let mut sums = [0.0; 6];
        for k in at {
            // Trapezoids of the test function (q(1-q))^3 and its two derivatives.
            let width = 0.5 * (time[k + 1] - time[k]);
            for (j, other) in [(k, k + 1), (k + 1, k)] {
                let q = (time[j] - time[from]) / span;
                let (p, slope) = (q * (1.0 - q), 1.0 - 2.0 * q);
                let test = width * p.powi(3);
                let first = width * 3.0 * p * p * slope / span;
                let second = width * 6.0 * p * (slope * slope - p) / (span * span);
                let drive = force[if held { j.min(other) } else { j }];
                let parts = [
                    first * (x[j] - middle),
                    -test * sign(j),
                    test,
                    test * drive,
                    -test * x[j],
                    second * (x[j] - middle),
                ];
                sums.iter_mut().zip(parts).for_each(|(sum, part)| *sum += part);
            }
        }
        columns.iter_mut().zip(sums).for_each(|(column, sum)| column.push(sum));
        target.push(sums[5]);
    }
    Some((columns, target))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 3000 samples of 2 kg with dry friction of 1 N and a spring, driven by `force` of time and place.
    fn driven(stiffness: f64, force: impl Fn(f64, f64) -> f64) -> Motion {
        let (mut x, mut v, h) = (0.01_f64, 0.0_f64, 1e-4);
        let (mut time, mut displacement, mut forces) = (vec![], vec![], vec![]);
        for k in 0..3000 {
            let t = 0.005 * f64::from(k);
            let f = force(t, x);
            time.push(t);
            displacement.push(x);
            forces.push(f);
            for _ in 0..50 {
                v += h * (f - stiffness * x - 3.0 * v - (v / 1e-3).tanh()) / 2.0;
                x += h * v;
            }
        }
        let frequency = phisindy_signal::strongest_line(&time, &displacement).map(|l| l.frequency);
        Motion { time, displacement, force: Some(forces), frequency, ..Motion::default() }
    }

    #[test]
    fn a_cart_on_a_relay_has_no_spring() {
        let cart = driven(0.0, |_, x| if x > 0.0 { -13.0 } else { 13.0 });
        let told = forced(&cart, 3000).expect("columns");
        assert!(told.stiffness.is_none() && (1.0 / told.gain - 2.0).abs() < 0.3, "{told:?}");
        let pulses = driven(0.0, |t, x| 8.0 * (1.1 * t).sin().signum() * (0.37 * t).cos().abs() - 4.0 * x);
        let told = forced(&pulses, 3000).expect("columns");
        assert!((1.0 / told.gain - 2.0).abs() < 0.3, "{told:?}");
    }

    #[test]
    fn a_spring_is_seen() {
        for drive in [
            |t: f64, _: f64| 20.0 * (2.0 * t + 0.6 * t * t).sin(),
            |t: f64, _: f64| 20.0 * (7.0 * t).sin() + 30.0 * (23.0 * t).sin(),
        ] {
            let told = forced(&driven(400.0, drive), 3000).expect("columns");
            let stiffness = told.stiffness.expect("a spring");
            assert!((stiffness - 200.0).abs() < 20.0 && (1.0 / told.gain - 2.0).abs() < 0.3, "{told:?}");
        }
    }
}
