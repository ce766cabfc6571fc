//! What ends the work before its end: Ctrl-C, or a limit. The first Ctrl-C asks the work to end, the second one ends the program; so does a
//! limit, if the work does not end soon after.

use crate::limit::{Limit, held};
use crate::terminal::{NUMERICS, complain};
use phisindy_report::StopReason;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

static ASKED: AtomicBool = AtomicBool::new(false);
static MET: OnceLock<StopReason> = OnceLock::new();

/// Exit code of a program that was interrupted.
const INTERRUPTED: u8 = 130;
/// How often the limits are looked at.
const TICK: Duration = Duration::from_millis(20);
/// Work that does not end so long after a limit is ended.
const GRACE: Duration = Duration::from_secs(10);

/// Starts to listen and to watch. Without a handler Ctrl-C ends the program at once, which is no harm.
pub(crate) fn listen(limit: Limit) {
    let _ = ctrlc::set_handler(|| {
        if ASKED.swap(true, Ordering::SeqCst) {
            std::process::exit(i32::from(INTERRUPTED));
        }
    });
    if limit != (Limit { time: None, memory: None }) {
        // Nothing is lost with the handle: the thread ends with the program.
        let _ = std::thread::Builder::new().name("limit".to_owned()).spawn(move || watch(limit));
    }
}

/// Looks at the clock and at the memory until a limit is met, and then whether the work ends.
fn watch(limit: Limit) {
    let begin = Instant::now();
    let met = loop {
        std::thread::sleep(TICK);
        let (time, memory) = (begin.elapsed(), limit.memory.and_then(|_| held()));
        if let Some(most) = limit.time.filter(|most| time >= *most) {
            break StopReason::TimeLimit(most);
        }
        if let Some(most) = limit.memory.filter(|most| memory.is_some_and(|held| held >= *most)) {
            break StopReason::MemoryLimit(most);
        }
    };
    let _ = MET.set(met);
    ASKED.store(true, Ordering::SeqCst);
    let since = Instant::now();
    let beyond = || limit.memory.is_some_and(|most| held().is_some_and(|held| held > most + most / 4));
    while since.elapsed() < GRACE && !beyond() {
        std::thread::sleep(TICK);
    }
    complain(&format!("{met}, and the work did not end by itself: nothing of it is kept; {RAISE}"));
    std::process::exit(i32::from(NUMERICS));
}

/// What to do about a limit.
const RAISE: &str = "allow more with --limit, as in --limit 2h,16GB, or make the case smaller";

/// Whether the work should end.
pub(crate) fn asked() -> bool {
    ASKED.load(Ordering::SeqCst)
}

/// The exit code of work that ended because it was asked to.
pub(crate) fn code() -> u8 {
    if MET.get().is_some() { NUMERICS } else { INTERRUPTED }
}

/// Who asked, for a result that is not finished.
pub(crate) fn reason() -> StopReason {
    MET.get().copied().unwrap_or(StopReason::Interrupt)
}

/// Says that a limit was met, and what to do. Who typed Ctrl-C knows it.
pub(crate) fn tell() {
    if let Some(met) = MET.get() {
        complain(&format!("{met}: what was finished is kept; {RAISE}"));
    }
}
