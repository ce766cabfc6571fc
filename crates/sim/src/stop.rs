//! The wish that work ends early.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

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
