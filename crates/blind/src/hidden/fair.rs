//! Conditions of a fair test.

use super::effect::{Action, Effect};
use super::motion::{Experiment, Motion, motion};
use super::rig::{Drive, Rig};
use super::rivals::{Seen, largest, place_motion};
use phisindy_signal::standard_deviation;

/// A start with an error of this part of the noise must predict the record to `STEADY` of the noise, or the
/// gap cannot end below 1.05.
const START_ERROR: f64 = 0.1;
const STEADY: f64 = 0.25;

/// Whether the rig can have these effects at all, and a sensor that could show them.
pub(super) fn possible(seen: &Seen<'_>) -> Result<(), &'static str> {
    for effect in seen.effects {
        if let Action::Sensor { column: Some(column), .. } = effect.action
            && !seen.columns.iter().any(|(k, _, _)| *k == column)
        {
            return Err("the column is not measured");
        }
        // A motion without a drive has no reference of time: a delay gives the same motion with another
        // start.
        if effect.law == "sensor-delay" && effect.at == "motion" && seen.rig.drive == Drive::Free {
            return Err("a late clock of a released motion is no other motion");
        }
        let Action::Force { place, .. } = &effect.action else { continue };
        let (x, v) = place_motion(seen, place);
        let p = |name: &str| effect.parameter(name).unwrap_or(0.0);
        let level: &dyn Fn(f64, f64) -> f64 = match effect.law.as_str() {
            "dieterich-ruina" => &|_, s| {
                p("F") + p("a") * ((s + 1e-6) / 0.003).ln() + p("b") * (0.022 + 0.003 / (s + 1e-6)).ln()
            },
            "position-dependent-friction" => &|x, _| p("F0") + p("F1") * x + p("F2") * x * x,
            _ => continue,
        };
        let (x, v, least) = (1.3 * largest(&x), 1.5 * largest(&v), 0.1 * p("F").max(p("F0")));
        let positions = (-20..=20).all(|k| level(x * f64::from(k) / 20.0, v) > least);
        if !positions || (0..60).any(|k| level(x, v * 0.75f64.powi(k)) <= least) {
            return Err("friction pushes");
        }
    }
    Ok(())
}

/// The range that each law needs to be visible: the motion must enter and leave it.
pub(super) fn visible(seen: &Seen<'_>) -> Result<(), &'static str> {
    possible(seen)?;
    for effect in seen.effects {
        let Action::Force { place, force, .. } = &effect.action else { continue };
        let (x, v) = place_motion(seen, place);
        let n = x.len() as f64;
        let share = |f: &dyn Fn(usize) -> bool| (0..x.len()).filter(|&i| f(i)).count() as f64 / n;
        let p = |name: &str| effect.parameter(name).unwrap_or(0.0);
        let far = |w: f64, from: f64| (w - from).abs() * seen.experiment.times[x.len() - 1] > 9.0;
        let lines = || seen.experiment.lines.iter().map(|l| l.frequency);
        let fair = match effect.law.as_str() {
            "dead-zone" => (0.05..0.95).contains(&share(&|i| x[i].abs() > p("gap"))),
            "one-sided-stop" => {
                let side = if force.starts_with("(-") { -1.0 } else { 1.0 };
                (0.03..0.6).contains(&share(&|i| side * x[i] > p("gap")))
            }
            "stribeck" => {
                let moves = |i: usize| !seen.motion.stuck[i];
                share(&|i| moves(i) && v[i].abs() < p("vs")) > 0.03
                    && share(&|i| v[i].abs() > 2.0 * p("vs")) > 0.1
            }
            "presliding" => {
                let z = &seen.motion.states[2 * seen.rig.count()];
                let d = p("Fc") / p("kt");
                (0.04..0.9).contains(&share(&|i| z[i].abs() < 0.9 * d))
            }
            "harmonic-force" => lines().all(|w| far(p("w"), w)),
            "parametric-stiffness" => lines().all(|w| far(p("w"), w) && far(p("w"), 2.0 * w)),
            _ => true,
        };
        if !fair {
            return Err("its range is not visited");
        }
    }
    Ok(())
}

/// Whether a start with the accuracy of noisy data still predicts the record: no workflow can explain a
/// chaotic motion.
pub(super) fn steady(
    rig: &Rig,
    effects: &[Effect],
    experiments: &[Experiment],
    truth: &[Motion],
    before: f64,
    noise: f64,
) -> bool {
    experiments.iter().zip(truth).all(|(experiment, exact)| {
        let deviations: Vec<f64> = exact.readings.iter().map(|y| noise * standard_deviation(y)).collect();
        let mut off = experiment.clone();
        for (k, (x, s)) in off.start.iter_mut().zip(&deviations).enumerate() {
            *x += START_ERROR * s * if k % 2 == 0 { 1.0 } else { -1.0 };
        }
        let Ok(motion) = motion(rig, effects, &off, before) else { return false };
        motion.readings.iter().zip(&exact.readings).zip(&deviations).all(|((a, b), s)| {
            let rms = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / a.len() as f64;
            rms.sqrt() <= STEADY * s
        })
    })
}
