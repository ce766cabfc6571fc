//! Early ends of work: a signal, or a limit. The first signal requests that the work ends, a second Ctrl-C ends
//! the program. A limit ends the program if the work does not end soon after it is met.

use crate::limit::{Limit, resident_memory};
use crate::terminal::{NUMERICS, complain, remark};
use phisindy_report::StopReason;
use std::io::IsTerminal;
#[cfg(unix)]
use std::sync::Arc;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

static REQUESTED: AtomicBool = AtomicBool::new(false);
static MET: OnceLock<StopReason> = OnceLock::new();
/// The signal that came first.
static SIGNAL: OnceLock<&str> = OnceLock::new();

/// Whether there is work, where the program also waits for some.
static WORKS: OnceLock<Box<dyn Fn() -> bool + Send + Sync>> = OnceLock::new();

/// Whether nothing is kept of work that ends early.
static LOSES: AtomicBool = AtomicBool::new(false);

/// The name of the signal that a terminal sends.
const CTRL_C: &str = "Ctrl-C";
/// Exit code after a signal.
const INTERRUPTED: u8 = 130;
/// Interval between checks of the limits.
const TICK: Duration = Duration::from_millis(20);
/// Time that work has to end after a limit is met: with a million samples a last run along all of them and the
/// errors of its numbers take minutes.
const GRACE: Duration = Duration::from_secs(600);
/// Whether the work has ended, and what it found is being written.
static ENDED: AtomicBool = AtomicBool::new(false);

/// Starts to check the limits, and listens to signals if the work keeps what it has: other work they end at once,
/// as a limit does.
pub(crate) fn listen(limit: Limit, keeps: bool) {
    if keeps {
        listen_to_signals();
    }
    if limit != (Limit { time: None, memory: None }) {
        // The handle is not needed: the thread ends with the program.
        let _ = std::thread::Builder::new().name("limit".to_owned()).spawn(move || watch(limit, keeps));
    }
}

/// A file that grows beyond a limit is an error of its write, as a full disk is; by itself the system would
/// end the program.
pub(crate) fn outlast_the_limit_of_files() {
    #[cfg(unix)]
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default());
}

/// Hears the signals that ask for an end: Ctrl-C, the end of a batch job, a terminal that is closed.
#[cfg(unix)]
fn listen_to_signals() {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    // `nohup` asks to go on without a terminal.
    let all = [SIGINT, SIGTERM, SIGHUP].into_iter().filter(|&signal| signal != SIGHUP || !is_ignored(SIGHUP));
    let Ok(mut signals) = signal_hook::iterator::Signals::new(all) else { return };
    let _ = std::thread::Builder::new().name("signals".to_owned()).spawn(move || {
        signals.forever().for_each(|signal| {
            request(match signal {
                SIGTERM => "SIGTERM",
                SIGHUP => "SIGHUP",
                _ => CTRL_C,
            });
        });
    });
}

/// Whether the program was started so that it does not hear a signal, where the system tells.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok())
        .is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}

/// Windows tells neither which event it was nor waits long for the end of the program.
#[cfg(not(unix))]
fn listen_to_signals() {
    let _ = ctrlc::set_handler(|| request(CTRL_C));
}

/// Requests the end of the work. Whoever presses Ctrl-C a second time does not want to wait. Other signals
/// come twice by themselves: from the system and from a shell.
fn request(signal: &'static str) {
    let works = WORKS.get().is_none_or(|works| works());
    // On a terminal the line of progress is there already.
    if SIGNAL.set(signal).is_ok() && works && !std::io::stderr().is_terminal() {
        let fate = if loses() { "nothing of it is kept" } else { "what was found is kept" };
        remark(&format!("{signal}: the work ends after its present step, and {fate}"));
    }
    if REQUESTED.swap(true, Ordering::SeqCst) && signal == CTRL_C {
        std::process::exit(i32::from(INTERRUPTED));
    }
}

/// Checks time and memory until a limit is met, then whether the work ends.
fn watch(limit: Limit, keeps: bool) {
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
    while keeps && since.elapsed() < GRACE && !beyond() {
        if ENDED.load(Ordering::SeqCst) {
            return;
        }
        std::thread::sleep(TICK);
    }
    let late = if keeps { ", and the work did not end by itself" } else { "" };
    complain(&format!("{met}{late}: nothing of it is kept; {RAISE}"));
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

/// Why the work ended early. What it found is kept from here on, however long that takes.
pub(crate) fn ended() -> StopReason {
    ENDED.store(true, Ordering::SeqCst);
    why()
}

/// Why the work should end, if it should.
pub(crate) fn reason() -> Option<StopReason> {
    requested().then(why)
}

fn why() -> StopReason {
    let signal = || StopReason::Signal(SIGNAL.get().unwrap_or(&CTRL_C));
    MET.get().copied().unwrap_or_else(signal)
}

/// Says that the program also waits for work, and how to ask whether there is some.
pub(crate) fn ask_for_work(works: impl Fn() -> bool + Send + Sync + 'static) {
    let _ = WORKS.set(Box::new(works));
}

/// Says that of this work a part is worth nothing: nothing is kept if it ends early.
pub(crate) fn keeps_nothing() {
    LOSES.store(true, Ordering::SeqCst);
}

fn loses() -> bool {
    LOSES.load(Ordering::SeqCst)
}

/// Reports that a limit was met, with advice. After a signal there is nothing to report.
pub(crate) fn tell() {
    if let Some(met) = MET.get() {
        let fate = if loses() { "nothing of it is kept" } else { "what was finished is kept" };
        complain(&format!("{met}: {fate}; {RAISE}"));
    }
}
