//! Whether a force and a motion are those of a friction tester, whose drive prescribes the motion and whose
//! force cell shows what resists, or those of a body that the force drives.
//!
//! A driven body fulfils `F = m a + c v + k x + Fc sgn(v)`. Where the force jumps with the direction of the
//! motion, the acceleration of a body would jump as well, unless the force is what prescribed motion meets.

use super::least_squares::least_squares;
use super::motion::Motion;
use super::weak_form::weak;

/// Friction is seen in the force if its sign takes this part of the force (mean squares) beyond spring and
/// damper, or if inertia, spring and damper together leave it: friction that slips late has no sharp sign.
const DRY: f64 = 0.05;
/// A force of which spring, damper and friction leave more than this part (mean squares) is not what resists
/// a motion.
const EXPLAINED: f64 = 0.5;
/// A body is driven if its inertia takes this part of what spring, damper and friction leave of the force
/// (mean squares): of a tester it takes what it has in common with the shape of the friction, of a body all
/// but the noise.
const INERT: f64 = 0.5;

/// A damper and dry friction are one force where their columns have this cosine: 0.90 (the root of 8 over pi)
/// for a sine, 1 for a triangle, which has two speeds.
const ALIKE: f64 = 0.97;

/// What force and motion say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drive {
    /// The force drives a body.
    Body,
    /// The motion is prescribed, and the force is what resists it.
    Tester {
        /// Of the elastic part, in N/m; 0 if there is none.
        stiffness: f64,
        /// Of the viscous part, in N s/m; 0 if it would drive the motion, none if the motion does not tell it
        /// from dry friction.
        damping: Option<f64>,
        /// Mean of the force, in N.
        mean: f64,
    },
    /// The columns do not tell.
    Open,
}

impl Motion {
    /// The tester that the user says this is: what the data do not tell begins as nothing.
    pub(crate) fn tester(&self) -> Drive {
        match self.drive() {
            tester @ Drive::Tester { .. } => tester,
            _ => {
                let force = self.force.as_deref().unwrap_or_default();
                let columns = [vec![1.0; force.len()], self.displacement.clone()];
                let mean = force.iter().sum::<f64>() / force.len().max(1) as f64;
                let line = least_squares(&columns, force).map_or([mean, 0.0], |(c, _)| [c[0], c[1]]);
                Drive::Tester { stiffness: line[1].max(0.0), damping: Some(0.0), mean: line[0] }
            }
        }
    }

    /// Whether the force drives the motion, from the integrals of the equation over short stretches.
    pub(crate) fn drive(&self) -> Drive {
        let told = || {
            let n = self.time.len().min(super::MOST);
            let (columns, acceleration) = weak(self, n)?;
            let [damper, friction, one, force, spring] = columns.as_slice() else { return None };
            let mut resisting = vec![one.clone(), spring.clone()];
            // A motion of two speeds does not tell a damper from dry friction; what is alike stands once.
            let viscous = cosine(damper, friction) < ALIKE;
            if viscous {
                resisting.push(damper.clone());
            }
            let dry = [std::slice::from_ref(friction), &resisting[..]].concat();
            let acceleration = std::slice::from_ref(&acceleration);
            let inert = [acceleration, &dry[..]].concat();
            let (_, whole) = least_squares(std::slice::from_ref(one), force)?;
            let (_, smooth) = least_squares(&resisting, force)?;
            let (parts, rough) = least_squares(&dry, force)?;
            // With an acceleration that is in proportion to the displacement the inertia takes nothing.
            let (inertia, left) = least_squares(&inert, force).map_or((0.0, rough), |(c, left)| (c[0], left));
            let linear = [acceleration, &resisting[..]].concat();
            let bent = least_squares(&linear, force).map_or(smooth, |(_, left)| left);
            // What resists takes power, and the column of the damper has the sign of its force on a body.
            let resists = cosine(damper, force) < 0.0 && rough < EXPLAINED * whole;
            let is_dry = (smooth - rough).max(bent) > DRY * whole;
            let is_body = inertia > 0.0 && rough - left > INERT * rough;
            Some(match (is_body, resists && is_dry) {
                (true, _) => Drive::Body,
                (false, true) => Drive::Tester {
                    stiffness: (-parts[2]).max(0.0),
                    damping: viscous.then(|| (-parts[3]).max(0.0)),
                    mean: parts[1],
                },
                (false, false) => Drive::Open,
            })
        };
        told().unwrap_or(Drive::Open)
    }
}

/// Whether a force over the way of a column is lost on it: the work of whole cycles has one sign, that of a spring none.
pub(crate) fn loses(way: &[f64], force: &[f64]) -> bool {
    let works = way.windows(2).zip(force.windows(2)).map(|(x, f)| 0.5 * (f[0] + f[1]) * (x[1] - x[0]));
    let (net, all) =
        works.filter(|w| w.is_finite()).fold((0.0, 0.0), |(net, all), w| (net + w, all + w.abs()));
    f64::abs(net) > DRY * all
}

/// The cosine between two columns.
fn cosine(a: &[f64], b: &[f64]) -> f64 {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    dot(a, b) / (dot(a, a) * dot(b, b)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn motion(force: impl Fn(f64, f64, f64) -> f64, omega: &[f64]) -> Motion {
        let time: Vec<f64> = (0..4000).map(|k| 0.005 * f64::from(k)).collect();
        let x = |t: f64| omega.iter().map(|w| 5e-3 * (w * t).sin()).sum::<f64>();
        let v = |t: f64| omega.iter().map(|w| 5e-3 * w * (w * t).cos()).sum::<f64>();
        let a = |t: f64| omega.iter().map(|w| -5e-3 * w * w * (w * t).sin()).sum::<f64>();
        let displacement: Vec<f64> = time.iter().map(|t| x(*t)).collect();
        let force = Some(time.iter().map(|t| force(x(*t), v(*t), a(*t))).collect());
        let frequency = phisindy_signal::strongest_line(&time, &displacement).map(|l| l.frequency);
        Motion { time, displacement, force, frequency, ..Motion::default() }
    }

    #[test]
    fn friction_without_inertia_is_a_tester() {
        for omega in [&[4.0][..], &[3.0, 7.3]] {
            let stribeck = |x: f64, v: f64, _: f64| {
                800.0 * x + (30.0 + 20.0 * (-(v / 5e-3).powi(2)).exp()) * v.signum() + 3.0
            };
            let Drive::Tester { stiffness, mean, .. } = motion(stribeck, omega).drive() else {
                panic!("{omega:?}: {:?}", motion(stribeck, omega).drive())
            };
            assert!((stiffness / 800.0 - 1.0).abs() < 0.2 && (mean - 3.0).abs() < 1.0, "{stiffness} {mean}");
        }
    }

    #[test]
    fn inertia_is_a_body_and_one_tone_without_friction_tells_nothing() {
        let body = |x: f64, v: f64, a: f64| 2.0 * a + 800.0 * x + 3.0 * v + 0.3 * v.signum();
        assert_eq!(motion(body, &[3.0, 17.0, 31.0]).drive(), Drive::Body);
        assert_eq!(motion(|x, v, _| 800.0 * x + 3.0 * v, &[4.0]).drive(), Drive::Open);
    }
}
