//! Early ends of work: Ctrl-C, or a limit. The first Ctrl-C requests that the work ends, the second one ends
//! the program. A limit ends the program if the work does not end soon after it is met.

use crate::limit::{Limit, resident_memory};
use crate::terminal::{NUMERICS, complain};
use phisindy_report::StopReason;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

static REQUESTED: AtomicBool = AtomicBool::new(false);
static MET: OnceLock<StopReason> = OnceLock::new();

/// Exit code after Ctrl-C.
const INTERRUPTED: u8 = 130;
/// Interval between checks of the limits.
const TICK: Duration = Duration::from_millis(20);
/// Time that work has to end after a limit is met.
const GRACE: Duration = Duration::from_secs(10);

/// Installs the handler of Ctrl-C and starts to check the limits. Without the handler Ctrl-C ends the program
/// at once.
pub(crate) fn listen(limit: Limit) {
    let _ = ctrlc::set_handler(|| {
        if REQUESTED.swap(true, Ordering::SeqCst) {
            std::process::exit(i32::from(INTERRUPTED));
        }
    });
    if limit != (Limit { time: None, memory: None }) {
        // The handle is not needed: the thread ends with the program.
        let _ = std::thread::Builder::new().name("limit".to_owned()).spawn(move || watch(limit));
    }
}

/// Checks time and memory until a limit is met, then whether the work ends.
fn watch(limit: Limit) {
    let begin = Instant::now();
    let met = loop {
        std::thread::sleep(TICK);
        let (time, memory) = (begin.elapsed(), limit.memory.and_then(|_| resident_memory()));
        if let Some(most) = limit.time.filter(|most| time >= *most) {
            break StopReason::TimeLimit(most);
        }
        if let Some(most) = limit.memory.filter(|most| memory.is_some_and(|now| now >= *most)) {
            break StopReason::MemoryLimit(most);
        }
    };
    let _ = MET.set(met);
    REQUESTED.store(true, Ordering::SeqCst);
    let since = Instant::now();
    let beyond =
        || limit.memory.is_some_and(|most| resident_memory().is_some_and(|now| now > most + most / 4));
    while since.elapsed() < GRACE && !beyond() {
        std::thread::sleep(TICK);
    }
    complain(&format!("{met}, and the work did not end by itself: nothing of it is kept; {RAISE}"));
    std::process::exit(i32::from(NUMERICS));
}

/// Advice about a limit that is met.
const RAISE: &str = "allow more with --limit, as in --limit 2h,16GB, or make the case smaller";

/// Whether the work should end.
pub(crate) fn requested() -> bool {
    REQUESTED.load(Ordering::SeqCst)
}

/// The exit code of work that ended early.
pub(crate) fn code() -> u8 {
    if MET.get().is_some() { NUMERICS } else { INTERRUPTED }
}

/// Why the work ended early.
pub(crate) fn reason() -> StopReason {
    MET.get().copied().unwrap_or(StopReason::Interrupt)
}

/// Reports that a limit was met, with advice. After Ctrl-C there is nothing to report.
pub(crate) fn tell() {
    if let Some(met) = MET.get() {
        complain(&format!("{met}: what was finished is kept; {RAISE}"));
    }
}
