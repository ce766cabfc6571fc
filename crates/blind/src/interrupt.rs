//! Ctrl-C: the first one asks the work to end, the second one ends the program.

use std::sync::atomic::{AtomicBool, Ordering};

static REQUESTED: AtomicBool = AtomicBool::new(false);

/// Exit code of work that was interrupted.
pub(crate) const INTERRUPTED: u8 = 130;

/// Starts to listen. Without a handler Ctrl-C ends the program at once, which is no harm.
pub(crate) fn listen() {
    let _ = ctrlc::set_handler(|| {
        if REQUESTED.swap(true, Ordering::SeqCst) {
            std::process::exit(i32::from(INTERRUPTED));
        }
    });
}

/// Whether the work should end.
pub(crate) fn requested() -> bool {
    REQUESTED.load(Ordering::SeqCst)
}
