//! What the end of a search means: nothing missing, explained, unexplained; and which of its effects help.

use crate::effect::{Effect, role};
use crate::fitted::Fitted;
use crate::found::Status;

/// An explained record ends below this many times its noise.
pub(crate) const EXPLAINED: f64 = 1.08;
/// Effects that explain: more of them cover up whatever is missing ("with four parameters I can fit an elephant").
const ELEPHANT: usize = 4;
/// One fewer must leave no more than this many times the noise on the records that they were fitted to: what is a little more is what a curve through something else leaves.
const CLEAN: f64 = 1.02;
/// So many elastic effects at one place draw any curve.
const BENT: usize = 3;

/// Effects that lower a gap by less are no help.
const HELPS: f64 = 0.95;

/// How a search that ended here ends; what a reader should know of it goes to the warnings.
pub(crate) fn status(last: &Fitted, repeats: bool, warnings: &mut Vec<String>) -> Status {
    let count = last.draft.effects.len();
    let white = last.explains();
    // Below the estimated noise, which of clean columns is too large, there is nothing to find.
    let below = last.fit <= 1.0 && last.carried.unwrap_or(last.fit) <= 1.0;
    let little_left = count + 1 == ELEPHANT && last.fit > CLEAN && !repeats;
    let bent = bent(last);
    let covered = count >= ELEPHANT || little_left || bent.is_some();
    if let Some(at) = bent.filter(|_| white) {
        warnings.push(format!(
            "{BENT} corrections of the spring at {at} describe its curve, as so many would any: which law it follows they do not say; a static test, force against displacement, would"
        ));
    } else if covered && white {
        let what = if little_left { "hardly more than noise" } else { "nothing but noise" };
        warnings.push(format!(
            "with {count} effects the model leaves {what}, but so many corrections may cover up one effect that no law here describes"
        ));
    }
    match ((white || repeats || below) && !covered, count == 0) {
        (true, true) => Status::NothingMissing,
        (true, false) => Status::Explained,
        (false, _) => Status::Unexplained,
    }
}

/// How many of the effects help on data not used: those up to where the gap there is about as small as it gets. A model that hardly moves misses less than one that moves otherwise than the rig,
/// and explains nothing.
pub(crate) fn helpful(way: &[Fitted]) -> usize {
    let carried = |k: &usize| way[*k].carried.unwrap_or(way[*k].fit);
    let moves = |k: &usize| *k == 0 || way[*k].follows();
    let last = way.len() - 1;
    if way[last].carried.is_none() {
        return if moves(&last) { last } else { 0 };
    }
    let least = (0..=last).filter(moves).map(|k| carried(&k)).fold(f64::INFINITY, f64::min);
    (0..=last).filter(moves).find(|k| HELPS * carried(k) <= least).unwrap_or(0)
}

/// Where so many effects are forces of one displacement alone that they are one spring.
fn bent(last: &Fitted) -> Option<String> {
    let elastic = |effect: &&Effect| {
        let law = &effect.entry.law;
        role(law, 'x').is_some() && role(law, 'v').is_none() && law.internal.is_empty()
    };
    let effects = last.draft.effects.iter().map(|(effect, ..)| effect);
    let at: Vec<&String> = effects.filter(elastic).map(|effect| &effect.place.at).collect();
    at.iter()
        .find(|place| at.iter().filter(|other| other == place).count() >= BENT)
        .map(|place| (*place).clone())
}

/// An effect that is not added, though it may bring the gap on Fit records down: how far, and what it does to the other gap beside the effects that are.
pub(crate) fn refused(whole: &Fitted, k: usize, kept: &Fitted, with: &Fitted) -> Option<String> {
    let (effect, ..) = &whole.draft.effects[k];
    let (from, to) = kept.validate.zip(with.validate)?;
    let why = if with.follows() { "" } else { ", where the model hardly moves any more" };
    Some(format!(
        "{} at {} is not added: it takes the gap on the fitted data from {:.3} to {:.3}, and that on data not used from {from:.3} to {to:.3}{why}",
        effect.entry.id, effect.place.at, kept.fit, with.fit
    ))
}
