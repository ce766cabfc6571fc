//! The inputs of a search, and who is told of its progress.

use crate::result::Activity;
use phisindy_phys::LawEntry;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

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
    tell: Mutex<&'a mut Tell<'a>>,
    stopped: AtomicBool,
}

impl<'a> Observer<'a> {
    pub(crate) fn new(tell: &'a mut Tell<'a>) -> Observer<'a> {
        Observer { tell: Mutex::new(tell), stopped: AtomicBool::new(false) }
    }
}

impl Observe for Observer<'_> {
    fn tell(&self, part: f64, what: Activity) -> bool {
        if let Ok(mut tell) = self.tell.lock()
            && tell(part, what)
        {
            self.stopped.store(true, Ordering::Relaxed);
        }
        self.stopped()
    }

    fn stopped(&self) -> bool {
        self.stopped.load(Ordering::Relaxed)
    }
}
