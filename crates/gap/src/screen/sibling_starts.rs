//! Start values of a law from the fitted force of a sibling.

use super::gram::solve;
use super::seeded;
use crate::decisions::{JUST_SLIPS, NEARLY_BEST, SLOW};
use crate::evaluate::{evaluated, speed};
use crate::model::TrialModel;
use crate::motion::Motion;
use crate::place::{Effect, Site};

use super::regressors::Regressors;
use faer::Mat;
use phisindy_expr::Tape;
use phisindy_learn::Calibration;
use phisindy_phys::LawEntry;
use phisindy_phys::spec::Role;

/// Start values of a law from the fitted force of a sibling at the same place. Regresses that force on the
/// law's columns along the motion, for each value of the grid parameter, and keeps the starts that explain
/// nearly as much as the best. Empty where all are outside the law's bounds.
pub(crate) fn sibling_starts(
    model: &TrialModel,
    fitted: &Calibration,
    sibling: &Effect,
    entry: &LawEntry,
) -> Option<Vec<Effect>> {
    let system = &model.system;
    let r = model.records.iter().position(|r| r.role == Role::Fit)?;
    let mut motion = Motion::new(system, &model.records[r], &model.smooth[r], r, fitted);
    let start = entry.law.parameters.iter().map(|_| 0.0).collect();
    let wanted = Effect { entry: entry.clone(), start, mirror: false, ..sibling.clone() };
    let other = Regressors::new(&wanted, system)?;
    // The friction of a contact at rest equals its value just before it slips.
    let speeds: Vec<f64> = speed(system, &motion, &sibling.place)?;
    let top = speeds.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let (slow, n) = (SLOW * top, system.states.len());
    let Site::Force { acts, .. } = &sibling.place.site else { return None };
    let &(state, _) = acts.first()?;
    for (i, speed) in speeds.iter().enumerate().filter(|(_, speed)| speed.abs() <= slow) {
        motion.states[i * n + state] += JUST_SLIPS * top * speed.signum() - speed;
    }
    let force = force_of(sibling, model, &motion, |i| speeds[i].abs() <= slow)?;
    let samples = motion.samples();
    let columns_of = |regressors: &Regressors, grid: &[f64]| -> Option<Vec<Vec<f64>>> {
        let mut all = system.arguments();
        all.extend(&regressors.symbols);
        let tape = Tape::compile(&regressors.graph, &all, &regressors.columns).ok()?;
        Some(evaluated(&tape, &motion, grid, &[]))
    };
    let grids: Vec<Vec<f64>> = match other.grid.len() {
        0 => vec![vec![]],
        1 => [0.01, 0.03, 0.1, 0.3].iter().map(|q| vec![q * top]).collect(),
        _ => return None,
    };
    let mut all: Vec<(f64, Effect)> = Vec::new();
    for grid in grids {
        let columns = columns_of(&other, &grid)?;
        let n = columns.len() + 1;
        let value = |k: usize, i: usize| if k == 0 { force[i] } else { columns[k - 1][i] };
        let gram = Mat::from_fn(n, n, |a, b| (0..samples).map(|i| value(a, i) * value(b, i)).sum::<f64>());
        let at: Vec<usize> = (1..n).collect();
        let Some((gain, solution)) = solve(&gram, &at) else { continue };
        all.extend(seeded(&wanted, Some(&other), &solution, &grid).map(|effect| (gain, effect)));
    }
    let best = all.iter().map(|(gain, _)| *gain).fold(0.0, f64::max);
    Some(all.into_iter().filter(|(gain, _)| *gain > NEARLY_BEST * best).map(|(_, e)| e).collect())
}

/// The force of an effect of a model along a motion; `rests` tells the samples at rest.
fn force_of(
    effect: &Effect,
    model: &TrialModel,
    motion: &Motion,
    rests: impl Fn(usize) -> bool,
) -> Option<Vec<f64>> {
    let force = model.effects.iter().find(|applied| applied.effect.same(effect))?.force?;
    let mut graph = model.system.graph.clone();
    let modes = [0.0, 1.0].map(|mode| graph.with_rest(force, mode));
    let tape = Tape::compile(&graph, &model.system.arguments(), &modes).ok()?;
    let both = evaluated(&tape, motion, &[], &[]);
    Some((0..motion.samples()).map(|i| both[usize::from(rests(i))][i]).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_models::{effect, fitted, slowly_driven};

    /// Stribeck's law starts with a static level above its kinetic one.
    #[test]
    fn the_force_of_static_friction_at_rest_is_its_static_level() {
        let (base, noise) = slowly_driven("-(0.2 + 0.3*rest(v))*sgn(v)");
        let law = include_str!("../../../phys/laws/breakaway.ron");
        let breakaway = effect(&base, "breakaway", law, "v", &[0.2, 0.5]);
        let stribeck = LawEntry::read("stribeck", include_str!("../../../phys/laws/stribeck.ron"));
        let fit = fitted(base.with(&breakaway).expect("a model"), &noise);
        let starts =
            sibling_starts(&fit.model, &fit.cal, &breakaway, &stribeck.expect("a law")).expect("starts");
        assert!(starts.iter().all(|effect| (effect.start[0] - 0.2).abs() < 0.05));
        assert!(starts.iter().any(|effect| effect.start[1] > 1.5 * effect.start[0]));
    }
}
