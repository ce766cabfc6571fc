//! The inputs of a search, and who is told of its progress.

use crate::result::Activity;
use phisindy_phys::LawEntry;
use phisindy_sim::Stop;
use std::sync::Mutex;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

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
}

/// Time between two questions whether the work is to end.
const ASKS: Duration = Duration::from_millis(100);

impl<'a> Observer<'a> {
    /// Does some work with an observer that tells of the progress, and tells the last of it again and again while a step
    /// takes long: so that a wish to end is heard.
    pub(crate) fn during<T>(tell: &'a mut Tell<'a>, work: impl FnOnce(&Observer<'a>) -> T) -> T {
        let told = Mutex::new(Told { tell, last: None });
        let observer = Observer { told, stop: Stop::default() };
        // Dropped at the end of the work, also where it panics.
        let (working, ended) = channel::<()>();
        std::thread::scope(|scope| {
            scope.spawn(|| {
                let ended = ended;
                while ended.recv_timeout(ASKS) == Err(RecvTimeoutError::Timeout) {
                    observer.hand_on(None);
                }
            });
            let _working = working;
            work(&observer)
        })
    }

    /// What ends fits once the end was asked for.
    pub(crate) fn stop(&self) -> Stop {
        self.stop.clone()
    }

    /// Tells of the progress, or of the last once more.
    fn hand_on(&self, progress: Option<(f64, Activity)>) {
        let Ok(mut told) = self.told.lock() else { return };
        told.last = progress.or(told.last.take());
        if let Some((part, what)) = told.last.clone()
            && (told.tell)(part, what)
        {
            self.stop.request();
        }
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
}
