//! How long one execution takes and how much memory it holds at its worst.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::time::Instant;

/// What one execution may need.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Longest time, in milliseconds.
    pub milliseconds: f64,
    /// Most memory at a time.
    pub bytes: usize,
    /// How often a new worst is tried again: a machine with other work to do stalls now and then, and what is slow is slow every time.
    pub again: usize,
}

/// Of what reads text.
const READER: Limits = Limits { milliseconds: 1000.0, bytes: 256 << 20, again: 3 };

static HELD: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);
static WORST_MICROSECONDS: AtomicUsize = AtomicUsize::new(0);
static WORST_BYTES: AtomicUsize = AtomicUsize::new(0);

/// The system's allocator, counting.
struct Counting;

// SAFETY: every call is handed on to the system's allocator as it came.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let held = HELD.fetch_add(layout.size(), Relaxed) + layout.size();
        PEAK.fetch_max(held, Relaxed);
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        HELD.fetch_sub(layout.size(), Relaxed);
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

fn timed(work: impl Fn()) -> usize {
    let begin = Instant::now();
    work();
    begin.elapsed().as_micros() as usize
}

/// Does it within the limits of what reads text.
pub fn measured(work: impl Fn()) {
    measured_within(READER, work);
}

/// Does it, fails if it takes too long or too much, and tells of each new worst on standard error.
pub fn measured_within(limits: Limits, work: impl Fn()) {
    let before = HELD.load(Relaxed);
    PEAK.store(before, Relaxed);
    let mut microseconds = timed(&work);
    let bytes = PEAK.load(Relaxed).saturating_sub(before);
    for _ in 0..limits.again {
        if microseconds > WORST_MICROSECONDS.load(Relaxed) {
            microseconds = microseconds.min(timed(&work));
        }
    }
    if microseconds > WORST_MICROSECONDS.fetch_max(microseconds, Relaxed) {
        eprintln!("worst time {:.3} ms", microseconds as f64 / 1e3);
    }
    if bytes > WORST_BYTES.fetch_max(bytes, Relaxed) {
        eprintln!("worst memory {:.3} MB", bytes as f64 / 1e6);
    }
    assert!(microseconds as f64 / 1e3 < limits.milliseconds, "{microseconds} us for one input");
    assert!(bytes < limits.bytes, "{bytes} bytes for one input");
}
