//! None of these: the final model beside a force of the motion that has no form.
//!
//! The force is a Gaussian process about the laws that were found: bumps over the velocity of a place, over its
//! displacement and velocity, and a jump at rest, each with a coefficient `N(0, s^2)`. Along the linear responses
//! `Phi`, with free constants and start states projected out, its evidence against the laws alone is
//!
//! `ln Z_0/Z = -n/2 ln(1 - y' Phi (Phi' Phi + s^-2)^-1 Phi' y / y'y) - 1/2 ln det(1 + s^2 Phi' Phi)`
//!
//! (C. E. Rasmussen and C. K. I. Williams, Gaussian Processes for Machine Learning, 2006, eq. 2.30, with the size of the
//! noise unknown: A. Zellner, An Introduction to Bayesian Inference in Econometrics, 1971, ch. 3), averaged over sizes `s`
//! between the least that makes another force of that of the laws, or that the records can see, and the whole force on the
//! body, each as likely beforehand. So a law that is right pays the process nothing, and one that is only near to what is
//! there loses to it. Noise of a colour counts with the part of its samples that is independent.

use crate::decisions::{NONE_BUMPS, NONE_SIZES, SAME_FORCE};
use crate::evaluate::along_run;
use crate::hum::waves_of_tones;
use crate::input_interpolation::redrawn_runs;
use crate::model::Fitted;
use crate::place::{Place, Site};
use crate::screen::{Kinematics, PartialRegression, Target, dot};
use faer::{Mat, Side};
use phisindy_expr::{Id, Tape};
use phisindy_phys::spec::Role;

/// The probability that the missing force is none of the laws of a model; `None` where it has no force, or the
/// records show none, or only the error of the simulation is left. What another drawing of the inputs between their samples does to the runs is no force, nor is hum.
pub(crate) fn probability(last: &Fitted, noise: &[Vec<f64>]) -> Option<f64> {
    if last.score.is_exact() {
        return None;
    }
    let mut places: Vec<&Place> = vec![];
    for place in last.model.effects.iter().map(|a| &a.effect.place) {
        if matches!(place.site, Site::Force { .. }) && !places.iter().any(|known| known.at == place.at) {
            places.push(place);
        }
    }
    let noise = last.noise(noise);
    // The residuals themselves: a run that is summed up anew from its samples errs where it stops.
    let target = Target::OfFit(&last.cal);
    let mut regression = PartialRegression::new(&last.model, &last.cal, Some(&last.cal), &noise, target)?;
    if let Some(changes) = redrawn_runs(last) {
        regression.set_aside(&changes);
    }
    waves_of_tones(last).iter().for_each(|wave| regression.set_aside(wave));
    let odds: Vec<f64> = places.into_iter().flat_map(|place| at(last, &regression, place)).collect();
    let mean = odds.iter().sum::<f64>() / odds.len() as f64;
    (!odds.is_empty() && !mean.is_nan()).then(|| if mean.is_finite() { mean / (1.0 + mean) } else { 1.0 })
}

/// `Z_0/Z` of the kernels at a place.
fn at(last: &Fitted, regression: &PartialRegression, place: &Place) -> Vec<f64> {
    let system = &last.model.system;
    let places = last.model.places();
    let place = places.iter().find(|p| p.at == place.at).unwrap_or(place);
    let Some(kinematics) = regression.kinematics(system, place) else { return vec![] };
    let Some(whole) = whole_force(last, &kinematics, place) else { return vec![] };
    let matters = SAME_FORCE * force_of_laws(last, place).unwrap_or(0.0);
    let over_speed = speeds(&kinematics);
    let over_both = if kinematics.has_displacement() { both(&kinematics) } else { vec![] };
    let kernels = [over_speed, over_both].into_iter().filter(|bumps| !bumps.is_empty());
    let independent = last.score.independent();
    kernels.filter_map(|bumps| odds(regression, &kinematics, &bumps, [matters, whole], independent)).collect()
}

/// A force at each sample, by record.
type Force = Vec<Vec<f64>>;

/// Bumps over a range, so wide that neighbours meet half-way up.
fn bumps(values: &[Vec<f64>]) -> Vec<Force> {
    let all = || values.iter().flatten().copied();
    let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
    let step = (high - low) / (NONE_BUMPS - 1) as f64;
    if step.is_nan() || step <= 0.0 {
        return vec![];
    }
    let bump = |k: usize| {
        let centre = low + step * k as f64;
        values.iter().map(|of| of.iter().map(|v| (-((v - centre) / step).powi(2)).exp()).collect()).collect()
    };
    (0..NONE_BUMPS).map(bump).collect()
}

/// Bumps over the velocity, and its sign.
fn speeds(at: &Kinematics) -> Vec<Force> {
    let sign = |v: &f64| if *v == 0.0 { 0.0 } else { v.signum() };
    let signs = at.velocity.iter().map(|of| of.iter().map(sign).collect()).collect();
    bumps(&at.velocity).into_iter().chain([signs]).collect()
}

/// Bumps over displacement and velocity.
fn both(at: &Kinematics) -> Vec<Force> {
    let (places, speeds) = (bumps(&at.displacement), bumps(&at.velocity));
    let product = |a: &Force, b: &Force| -> Force {
        a.iter().zip(b).map(|(a, b)| a.iter().zip(b).map(|(a, b)| a * b).collect()).collect()
    };
    places.iter().flat_map(|a| speeds.iter().map(move |b| product(a, b))).collect()
}

/// The root mean square of the force on the body of a place: the rate of its speed times its inertia.
fn whole_force(last: &Fitted, at: &Kinematics, place: &Place) -> Option<f64> {
    let Site::Force { acts, .. } = &place.site else { return None };
    let &(state, _) = acts.first()?;
    let fitted = last.model.records.iter().zip(&last.cal.records).filter(|(r, _)| r.role == Role::Fit);
    let mut forces = vec![];
    for ((_, of), unit) in fitted.zip(at.units()) {
        let run = of.run.as_ref()?;
        let rates = (0..run.samples()).map(|i| run.rates[i * run.n + state]);
        forces.extend(rates.zip(unit).map(|(rate, unit)| rate / unit));
    }
    Some(root_mean_square(&forces)).filter(|rms| rms.is_finite() && *rms > 0.0)
}

/// The root mean square of the force of the laws at a place.
fn force_of_laws(last: &Fitted, place: &Place) -> Option<f64> {
    let system = &last.model.system;
    let here = last.model.effects.iter().filter(|a| a.effect.place.is(place));
    let mut graph = system.graph.clone();
    let forces: Vec<Id> = here.filter_map(|a| a.force).collect();
    let force = forces.into_iter().reduce(|a, b| graph.add(a, b))?;
    let tape = Tape::compile(&graph, &system.arguments(), &[force]).ok()?;
    let mut all = vec![];
    for (r, (record, of)) in last.model.records.iter().zip(&last.cal.records).enumerate() {
        let Some(run) = of.run.as_ref().filter(|_| record.role == Role::Fit) else { continue };
        let model = (system, last.cal.parameters.as_slice());
        let forces = along_run(&tape, model, (r, record), run, 1).map(|[force]| force);
        all.extend(forces.filter(|force| force.is_finite()));
    }
    Some(root_mean_square(&all))
}

fn root_mean_square(values: &[f64]) -> f64 {
    (dot(values, values) / values.len().max(1) as f64).sqrt()
}

/// `Z_0/Z`, averaged over the sizes of the force from one that matters, and that the records can see, to a whole one, with
/// this part of the samples independent.
fn odds(
    regression: &PartialRegression,
    at: &Kinematics,
    bumps: &[Force],
    [matters, whole]: [f64; 2],
    independent: f64,
) -> Option<f64> {
    let responses: Vec<Vec<f64>> =
        bumps.iter().filter_map(|force| Some(regression.response(at, force, at.rested())?.rows)).collect();
    let (m, y) = (responses.len(), regression.target());
    let gram = Mat::from_fn(m, m, |i, j| dot(&responses[i], &responses[j]));
    // Nothing of the force is seen, or more than numbers can hold.
    if m == 0 || gram.col_iter().any(|c| c.iter().any(|v| !v.is_finite())) {
        return None;
    }
    let eigen = gram.self_adjoint_eigen(Side::Lower).ok()?;
    let seen: Vec<f64> = responses.iter().map(|r| dot(r, y)).collect();
    // Along each direction: what the records see of it, and what they say.
    let directions: Vec<(f64, f64)> = (0..m)
        .map(|k| (eigen.S()[k].max(0.0), (0..m).map(|i| eigen.U()[(i, k)] * seen[i]).sum::<f64>()))
        .collect();
    let most = directions.iter().map(|d| d.0).fold(0.0, f64::max);
    if most <= 0.0 {
        return None;
    }
    let least = most.sqrt().recip().max(matters).min(whole);
    let (power, samples) = (dot(y, y), independent * y.len() as f64);
    let evidence = |s: f64| {
        let s2 = independent * s * s;
        let told: f64 = directions.iter().map(|(seen, said)| s2 * said * said / (1.0 + s2 * seen)).sum();
        let price: f64 = directions.iter().map(|(seen, _)| (s2 * seen).ln_1p()).sum();
        -0.5 * (samples * (-told / power).max(-1.0).ln_1p() + price)
    };
    let size = |k: usize| least * (whole / least).powf(k as f64 / (NONE_SIZES - 1) as f64);
    Some((0..NONE_SIZES).map(|k| evidence(size(k)).exp()).sum::<f64>() / NONE_SIZES as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_models::{effect, fitted, model};

    const COULOMB: &str = include_str!("../../phys/laws/coulomb.ron");
    const VISCOUS: &str = include_str!("../../phys/laws/viscous.ron");

    /// The law that is there leaves nothing for another force that matters, however small the noise is and whatever
    /// the responses miss at its stops; one that is only like it does.
    #[test]
    fn a_law_in_the_place_of_another_one_loses_to_none_of_these() {
        for size in ["0.02", "0.001"] {
            laws_against_none(size);
        }
    }

    fn laws_against_none(size: &str) {
        let (base, noise) = model(
            &r#"(states: { "x": "m", "v": "m/s" }, constants: { "k": (1.0, "N/m"), "m": (1.0, "kg"), "c": (0.1, "N*s/m"), "F0": (1.0, "N"), "W": (0.7, "rad/s") },
            known: { "x": "v", "v": "(-k*x - c*v + F0*cos(W*t))/m" },
            inertia: { "v": "m" }, unknown: {}, data: [ Synthetic(truth: { "v": "-0.2*sgn(v)" }, start: { "x": 1.0, "v": 0.0 }, duration: 40.0, step: 0.05, noise: Additive(SIZE), seed: 1) ])"#
                .replace("SIZE", size),
        );
        let of = |id: &str, law: &str| {
            let law = effect(&base, id, law, "v", &[0.2]);
            probability(&fitted(base.with(&law).expect("a model"), &noise), &noise).expect("a probability")
        };
        let (right, wrong) = (of("coulomb", COULOMB), of("viscous", VISCOUS));
        assert!(right < 0.01 && wrong > 0.99, "{size}: {right} {wrong}");
        assert!(probability(&fitted(base, &noise), &noise).is_none());
    }
}
