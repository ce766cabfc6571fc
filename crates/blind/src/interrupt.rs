//! Ctrl-C: the first one requests the end of the work, the second one ends the program.

use std::sync::atomic::{AtomicBool, Ordering};

static REQUESTED: AtomicBool = AtomicBool::new(false);

/// Exit code of work that was interrupted.
pub(crate) const INTERRUPTED: u8 = 130;

/// Installs the handler. Without a handler Ctrl-C ends the program at once, which does no harm.
pub(crate) fn listen() {
    let _ = ctrlc::set_handler(|| {
        if REQUESTED.swap(true, Ordering::SeqCst) {
            std::process::exit(i32::from(INTERRUPTED));
        }
    });
}

/// Whether the user has requested the end of the work.
pub(crate) fn requested() -> bool {
    REQUESTED.load(Ordering::SeqCst)
}
