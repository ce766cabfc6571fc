//! The inputs of a search, and who is told of its progress.

use crate::decisions::MOST_EFFECTS;
use crate::result::{Activity, RoundStart};
use phisindy_phys::LawEntry;
use phisindy_sim::Stop;
use std::sync::Mutex;

/// The inputs of a search.
#[derive(Clone, Copy)]
pub(crate) struct Search<'a> {
    pub(crate) catalogue: &'a [LawEntry],
    pub(crate) noise: &'a [Vec<f64>],
    /// Gap on Validate records below which no effect is added: the repeatability of the rig.
    pub(crate) floor: f64,
    pub(crate) observer: &'a dyn Observe,
}

/// Receives the progress as a fraction and an activity; returns true to stop.
type Tell<'a> = dyn FnMut(f64, Activity) -> bool + Send + 'a;

/// Hears of the progress, from any thread.
pub(crate) trait Observe: Sync {
    /// Tells of the progress; whether the work is to end.
    fn tell(&self, part: f64, what: Activity) -> bool;
    /// Whether the work is to end.
    fn stopped(&self) -> bool;
    /// The present round of the search.
    fn round(&self) -> RoundStart;
}

/// Hands the progress on, and remembers that it was asked for an end.
pub(crate) struct Observer<'a> {
    told: Mutex<Told<'a>>,
    stop: Stop,
}

struct Told<'a> {
    tell: &'a mut Tell<'a>,
    /// What was told last.
    last: Option<(f64, Activity)>,
    /// The present round.
    round: RoundStart,
}

/// How much of a round a step of it is shown as: of what is left of the round, for nobody knows how many will
/// follow.
const STRIDE: f64 = 0.02;
/// The part of a search that one more effect is, and where the search ends.
pub(crate) const ROUND: f64 = 0.8 / (MOST_EFFECTS + 1) as f64;
pub(crate) const SEARCHED: f64 = 0.92;

impl<'a> Observer<'a> {
    /// Does some work with an observer that tells of the progress, and tells the last of it again and again
    /// while a step takes long: so that a wish to end is heard.
    pub(crate) fn during<T>(tell: &'a mut Tell<'a>, work: impl FnOnce(&Observer<'a>) -> T) -> T {
        let told = Mutex::new(Told { tell, last: None, round: RoundStart::default() });
        let observer = Observer { told, stop: Stop::default() };
        let again = || {
            observer.hand_on(None);
            false
        };
        observer.stop().during(again, || work(&observer))
    }

    /// What ends fits once the end was asked for.
    pub(crate) fn stop(&self) -> Stop {
        self.stop.clone()
    }

    /// Tells of the progress, or of the last once more.
    fn hand_on(&self, progress: Option<(f64, Activity)>) {
        let Ok(mut told) = self.told.lock() else { return };
        told.advance(progress);
        if let Some((part, what)) = told.last.clone()
            && (told.tell)(part, what)
        {
            self.stop.request();
        }
    }
}

impl Told<'_> {
    /// Takes up what is told. What it says of the part that is done is where its round begins; each step
    /// after that goes a little further, up to the next one.
    fn advance(&mut self, progress: Option<(f64, Activity)>) {
        let Some((begin, what)) = progress else { return };
        if let Activity::Screening(round) = what {
            self.round = round;
        }
        let shown = match &self.last {
            Some((shown, last)) if *shown >= begin && *last != what => {
                let ends = [begin + ROUND, SEARCHED];
                let end = ends.into_iter().find(|end| end > shown).unwrap_or(*shown);
                shown + STRIDE * (end - shown)
            }
            Some((shown, _)) => shown.max(begin),
            None => begin,
        };
        self.last = Some((shown, what));
    }
}

impl Observe for Observer<'_> {
    fn tell(&self, part: f64, what: Activity) -> bool {
        self.hand_on(Some((part, what)));
        self.stopped()
    }

    fn stopped(&self) -> bool {
        self.stop.requested()
    }

    fn round(&self) -> RoundStart {
        self.told.lock().map_or(RoundStart::default(), |told| told.round)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn progress_moves_with_every_fit_and_never_beyond_its_round() {
        let mut parts = vec![];
        let mut tell = |part: f64, _: Activity| {
            parts.push(part);
            false
        };
        Observer::during(&mut tell, |observer| {
            let round = RoundStart { number: 1, gap: 5.0 };
            observer.tell(0.1, Activity::Screening(round));
            for done in 1..=100 {
                observer
                    .tell(0.26, Activity::Fitting { round: observer.round(), done, all: 100, best: None });
            }
            observer.tell(0.42, Activity::Comparing { round, done: 1, all: 7 });
        });
        parts.dedup();
        assert!(parts.len() == 102 && parts.is_sorted(), "{parts:?}");
        assert_eq!((parts[0], parts[1], parts[101]), (0.1, 0.26, 0.42));
        assert!(parts[100] < 0.42, "{parts:?}");
    }
}
