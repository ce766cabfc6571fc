//! The wish that work ends early.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// Time between two questions whether the work is to end.
const ASKS: Duration = Duration::from_millis(100);

/// A wish that work ends early, from any thread. Clones share it.
///
/// ```
/// let stop = phisindy_sim::Stop::default();
/// stop.clone().request();
/// assert!(stop.requested() && !stop.aborts() && stop.aborting().aborts());
/// ```
#[derive(Clone, Debug, Default)]
pub struct Stop {
    requested: Arc<AtomicBool>,
    /// Whether work ends without a result; otherwise with what it has.
    abort: bool,
}

impl Stop {
    /// Asks for the end.
    pub fn request(&self) {
        self.requested.store(true, Ordering::Relaxed);
    }

    /// Whether the end was asked for.
    pub fn requested(&self) -> bool {
        self.requested.load(Ordering::Relaxed)
    }

    /// Does some work, and asks again and again from another thread whether it is to end: a step of it may be long.
    ///
    /// ```
    /// let stop = phisindy_sim::Stop::default();
    /// let done = stop.during(|| true, || std::iter::repeat(()).take_while(|()| !stop.requested()).count());
    /// assert!(done > 0);
    /// ```
    pub fn during<T>(&self, mut ends: impl FnMut() -> bool + Send, work: impl FnOnce() -> T) -> T {
        // Dropped at the end of the work, also where it panics.
        let (working, ended) = channel::<()>();
        std::thread::scope(|scope| {
            scope.spawn(move || {
                while ended.recv_timeout(ASKS) == Err(RecvTimeoutError::Timeout) {
                    if ends() {
                        self.request();
                    }
                }
            });
            let _working = working;
            work()
        })
    }

    /// Whether work is to end without a result.
    pub fn aborts(&self) -> bool {
        self.abort && self.requested()
    }

    /// The same wish, to work whose result is not needed.
    pub fn aborting(&self) -> Stop {
        Stop { abort: true, ..self.clone() }
    }

    /// The same wish, to work that ends with what it has.
    pub fn finishing(&self) -> Stop {
        Stop { abort: false, ..self.clone() }
    }
}
