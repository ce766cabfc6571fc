//! The verdict on a finished search: nothing missing, explained or unexplained, and which effects help. It
//! depends on scores only.

use super::{PlacedLaw, Status, Warning};
use crate::decisions::{BENT, CLEAN_FIT, ELEPHANT, HELPS};
use crate::model::{Fitted, Score};

/// Status of a search that ended with this score, and its warning. `repeats`: the residual is at the
/// repeatability of the motion. `bent`: the place of a spring that several effects describe.
pub(crate) fn status(last: &Score, repeats: bool, bent: Option<String>) -> (Status, Option<Warning>) {
    let count = last.effects;
    let white = last.explains();
    let some_left = count + 1 == ELEPHANT && last.fit > CLEAN_FIT && !repeats;
    let covered = count >= ELEPHANT || some_left || bent.is_some();
    let warning = match bent {
        _ if !white => None,
        Some(at) => Some(Warning::Curve { count: BENT, at }),
        None => covered.then_some(Warning::ManyEffects { count, some_left }),
    };
    let status = match ((white || repeats || last.is_exact()) && !covered, count == 0) {
        (true, true) => Status::NothingMissing,
        (true, false) => Status::Explained,
        (false, _) => Status::Unexplained,
    };
    (status, warning)
}

/// Number of effects that help on data not used: the first for which the gap there is nearly the smallest.
/// `path` has the models with no effect, one, two and so on, each with whether it follows the motion. A model
/// that hardly moves may have a smaller gap than one with a wrong motion, and explains nothing.
pub(crate) fn helpful(path: &[(&Score, bool)]) -> usize {
    let moves = |k: &usize| *k == 0 || path[*k].1;
    let last = path.len() - 1;
    if path[last].0.predictive.is_none() {
        return if moves(&last) { last } else { 0 };
    }
    let gap = |k: usize| path[k].0.gap();
    let least = (0..=last).filter(moves).map(gap).fold(f64::INFINITY, f64::min);
    (0..=last).filter(moves).find(|k| HELPS * gap(*k) <= least).unwrap_or(0)
}

/// The place of at least `BENT` effects that are springs, and so describe one curve.
pub(crate) fn bent(last: &Fitted) -> Option<String> {
    let springs = last.model.effects.iter().map(|a| &a.effect).filter(|e| e.entry.law.is_spring());
    let at: Vec<&String> = springs.map(|effect| &effect.place.at).collect();
    at.iter()
        .find(|place| at.iter().filter(|other| other == place).count() >= BENT)
        .map(|place| (*place).clone())
}

/// The warning on an effect that is not added although it may lower the gap on Fit records: the gaps with and
/// without it, beside the effects that are kept.
pub(crate) fn refused(whole: &Fitted, k: usize, kept: &Fitted, with: &Fitted) -> Option<Warning> {
    let validate = kept.score.validate.zip(with.score.validate)?;
    Some(Warning::Refused {
        law: PlacedLaw::of(&whole.model.effects[k].effect),
        fit: (kept.score.fit, with.score.fit),
        validate,
        follows: with.follows(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::tests::score;

    #[test]
    fn a_search_ends_as_its_score_says() {
        use Status::{Explained, NothingMissing, Unexplained};
        let table = [
            // fit, validate, effects, repeats, bent, status, warning
            (1.0, Some(1.0), 0, false, None, NothingMissing, None),
            (1.0, Some(1.0), 2, false, None, Explained, None),
            (1.0, Some(1.2), 1, false, None, Unexplained, None),
            (30.0, Some(36.0), 1, false, None, Unexplained, None),
            (30.0, Some(36.0), 3, true, None, Explained, None),
            (0.9, Some(0.9), 1, false, None, Explained, None),
            (1.01, Some(1.0), 3, false, None, Explained, None),
            (
                1.03,
                Some(1.0),
                3,
                false,
                None,
                Unexplained,
                Some(Warning::ManyEffects { count: 3, some_left: true }),
            ),
            (
                1.0,
                Some(1.0),
                4,
                false,
                None,
                Unexplained,
                Some(Warning::ManyEffects { count: 4, some_left: false }),
            ),
            (
                1.0,
                Some(1.0),
                3,
                false,
                Some("v"),
                Unexplained,
                Some(Warning::Curve { count: 3, at: "v".into() }),
            ),
            (9.0, Some(9.0), 3, false, Some("v"), Unexplained, None),
        ];
        for (fit, validate, effects, repeats, at, due, warning) in table {
            let found = status(&score(fit, validate, effects), repeats, at.map(str::to_owned));
            assert_eq!(found, (due, warning), "{fit} {validate:?} {effects}");
        }
    }

    /// A residual with a shape counts while it is more than the error of the simulation, however small it is.
    #[test]
    fn the_error_of_the_simulation_is_no_force() {
        let said =
            |least: f64| status(&Score { least, whiteness: 50.0, ..score(0.4, None, 1) }, false, None).0;
        assert_eq!([0.5, 0.3].map(said), [Status::Explained, Status::Unexplained]);
    }

    #[test]
    fn effects_help_up_to_where_the_gap_is_least() {
        let helps = |gaps: &[(f64, bool)]| {
            let path: Vec<Score> =
                gaps.iter().enumerate().map(|(k, (gap, _))| score(*gap, Some(*gap), k)).collect();
            helpful(&path.iter().zip(gaps).map(|(s, (_, follows))| (s, *follows)).collect::<Vec<_>>())
        };
        assert_eq!(helps(&[(9.0, true), (3.0, true), (2.9, true)]), 1);
        assert_eq!(helps(&[(9.0, true), (3.0, true), (2.0, true)]), 2);
        assert_eq!(helps(&[(9.0, true), (12.0, true)]), 0);
        // A model that stands still does not count.
        assert_eq!(helps(&[(9.0, true), (3.0, false)]), 0);
        // Without Validate records the last model that follows the motion counts.
        let (a, b) = (score(9.0, None, 0), score(8.9, None, 1));
        assert_eq!((helpful(&[(&a, true), (&b, true)]), helpful(&[(&a, true), (&b, false)])), (1, 0));
    }
}
