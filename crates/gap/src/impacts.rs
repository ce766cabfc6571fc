//! Impacts that the model lacks: the speed of a body turns suddenly, where a floor or a wall stands.

use crate::decisions::{ON_THE_WAY, SUDDEN, TURN_SAMPLES};
use crate::model::{Fitted, TrialModel};
use crate::place::{Effect, Place, Site};
use phisindy_learn::Effort;
use phisindy_phys::spec::Role;
use phisindy_phys::unit::Unit;
use phisindy_phys::{LawEntry, Record};
use phisindy_signal::mean_step;
use rayon::prelude::*;
use std::ops::Range;

/// The id of the law that is no force: a speed turns where a gap closes.
pub const IMPACT: &str = "impact";

/// A turn of a motion, from the speeds before and after.
#[derive(Clone, Copy, Debug)]
struct Turn {
    /// Where the straight lines before and after meet.
    at: f64,
    /// The part of the speed that is left.
    left: f64,
    /// Whether it takes no time: the speed changes by as much within a short time as within a longer one.
    sudden: bool,
}

/// The fit with the impact that leaves least, if it halves the gap at least.
pub(crate) fn with_impact(of: &Fitted, noise: &[Vec<f64>]) -> Option<Fitted> {
    let impacts = impacts(&of.model);
    if impacts.is_empty() {
        return None;
    }
    let model = of.settled();
    let models: Vec<TrialModel> = impacts.iter().filter_map(|effect| model.with(effect).ok()).collect();
    let fits = models.into_par_iter().filter_map(|m| Fitted::new(m, noise, Effort::Plain).ok());
    let best = fits.min_by(|a, b| a.score.fit.total_cmp(&b.score.fit))?;
    (best.score.fit < ON_THE_WAY * of.score.fit).then_some(best)
}

/// The impacts that the records show: on either side of each displacement that has a column.
fn impacts(model: &TrialModel) -> Vec<Effect> {
    let fit = || model.records.iter().filter(|r| r.role == Role::Fit);
    let measured = |k: &usize| model.system.states[*k].velocity.is_some();
    let sides = (0..model.system.states.len()).filter(measured).flat_map(|k| [(k, true), (k, false)]);
    let of = |(state, below): (usize, bool)| {
        let mut turns: Vec<Turn> = fit().flat_map(|r| turns(r, state, below)).collect();
        let side = if below { 1.0 } else { -1.0 };
        turns.sort_by(|a, b| (side * a.at).total_cmp(&(side * b.at)));
        // The wall is where the farther half of the sudden turns is. Most turns that go as far are sudden; one alone may be a
        // disturbance.
        let mut hits: Vec<Turn> = turns.iter().copied().filter(|turn| turn.sudden).collect();
        let far = hits.get(hits.len() / 2)?.at;
        let reach = |all: &[Turn]| all.iter().filter(|turn| side * turn.at <= side * far).count();
        let walled = hits.len() > 1 && 2 * reach(&hits) > reach(&turns);
        hits.truncate(reach(&hits).max(2));
        walled.then(|| impact(model, state, below, &hits)).flatten()
    };
    sides.filter_map(of).collect()
}

/// The turns of a displacement at its least values, or at its largest ones.
fn turns(record: &Record, state: usize, below: bool) -> Vec<Turn> {
    let Some((time, column)) = record.own_column(state) else { return vec![] };
    let sign = if below { 1.0 } else { -1.0 };
    let z: Vec<f64> = column.iter().map(|z| sign * z).collect();
    let [short, long] = TURN_SAMPLES;
    let line = |range: Range<usize>| line(&time[range.clone()], &z[range]);
    let lowest = |i: &usize| {
        let around = &z[i - long..=i + long];
        around.iter().all(|other| *other >= z[*i])
    };
    let last = z.len().saturating_sub(long);
    // The standard error of a change of speed is that of the noise over one step. Below three of them the body rests.
    let least = 3.0 * record.noise_level(state) / mean_step(&time);
    let turn = |i: usize| {
        let [(before, s), (after, t)] = [line(i - short..i), line(i + 1..i + 1 + short)];
        let [(_, earlier), (_, later)] = [line(i - long..i - short), line(i + 1 + short..i + 1 + long)];
        let meet = (before - after) / (t - s);
        let sudden = s < 0.0 && t > 0.0 && t - s > SUDDEN * (later - earlier);
        let turn = Turn { at: sign * (before + s * meet), left: -t / s, sudden };
        (turn.at.is_finite() && t - s > least).then_some(turn)
    };
    (long..last).filter(lowest).filter_map(turn).collect()
}

/// Value at time 0 and slope of the straight line through samples.
fn line(time: &[f64], z: &[f64]) -> (f64, f64) {
    let n = time.len() as f64;
    let (mt, mz) = (time.iter().sum::<f64>() / n, z.iter().sum::<f64>() / n);
    let both = time.iter().zip(z);
    let (cross, square) =
        both.fold((0.0, 0.0), |(c, s), (t, z)| (c + (t - mt) * (z - mz), s + (t - mt) * (t - mt)));
    let slope = cross / square;
    (mz - slope * mt, slope)
}

/// An impact where these turns are.
fn impact(model: &TrialModel, state: usize, below: bool, hits: &[Turn]) -> Option<Effect> {
    let own = &model.system.states[state];
    let median = |of: fn(&Turn) -> f64| {
        let mut all: Vec<f64> = hits.iter().map(of).collect();
        all.sort_by(f64::total_cmp);
        all[all.len() / 2]
    };
    let (at, left) = (median(|turn| turn.at), median(|turn| turn.left).clamp(0.05, 0.95));
    let reach = model.records.iter().filter_map(|r| r.columns[state].as_deref());
    let (low, high) =
        reach.flatten().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), z| (a.min(*z), b.max(*z)));
    let within = (low - (high - low), high + (high - low));
    let unit = if Unit::parse(&own.unit).is_ok() { own.unit.as_str() } else { "" };
    let text = format!(
        "(name: \"impact\", about: \"A body hits a wall and rebounds with a part of its speed.\", \
         parameters: {{ \"x0\": (unit: {unit:?}, within: {within:?}), \"e\": (unit: \"\", within: (0.0, 1.0)) }}, force: \"0\")"
    );
    let place = Place { at: own.name.clone(), site: Site::Impact { state, below } };
    Some(Effect::new(LawEntry::read(IMPACT, &text).ok()?, place, vec![at, left]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_models::model;

    /// Whether an impact is seen below and above.
    fn seen(known: &str, more: &str, start: &str) -> Vec<bool> {
        let text = format!(
            r#"(states: {{ "z": "m", "v": "m/s" }}, known: {{ "z": "v", "v": "{known}" }}, unknown: {{}}, {more}
            data: [ Synthetic(truth: {{}}, start: {{ {start} }}, duration: 8.0, step: 0.02, seed: 1, noise: Relative(0.01)) ])"#
        );
        let (model, _) = model(&text);
        let of = |e: &Effect| matches!(e.place.site, Site::Impact { below: true, .. });
        impacts(&model).iter().map(of).collect()
    }

    #[test]
    fn a_motion_that_turns_suddenly_is_told_from_one_that_swings() {
        let floor = r#"impacts: { "floor": (when: "z - 0.3", restitution: 0.8) },"#;
        let ceiling = r#"impacts: { "ceiling": (when: "0.3 - z", restitution: 0.8) },"#;
        assert_eq!(seen("-9.81", floor, r#""z": 2.0, "v": 0.0"#), [true]);
        assert_eq!(seen("9.81", ceiling, r#""z": -2.0, "v": 0.0"#), [false]);
        assert!(seen("-30*z - 0.1*v", "", r#""z": 2.0, "v": 0.0"#).is_empty());
        assert!(seen("-30*z - 40*z^3", "", r#""z": 2.0, "v": 0.0"#).is_empty());
    }
}
