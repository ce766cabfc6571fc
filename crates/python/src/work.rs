//! Work without the interpreter's lock: on threads of its own, while the caller's thread hears of the
//! progress and of Ctrl-C.

use crate::errors::{DataError, NumericsError};
use phisindy::Progress;
use pyo3::prelude::*;
use std::any::Any;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// How long Ctrl-C waits at most for the thread of the caller to look: shorter than anybody notices.
const LOOK: Duration = Duration::from_millis(50);

/// The stack of a thread of the interpreter, of which a spec may need more than the two megabytes of others.
const STACK: usize = 8 << 20;

/// Hears of the progress, and may stop the work.
pub(crate) type Observe<'a> = dyn Fn(Progress<'_>) -> ControlFlow<()> + Sync + 'a;

/// Ends works from another thread: signals reach the first thread alone.
#[pyclass(frozen)]
#[derive(Default)]
pub(crate) struct Stop(AtomicBool);

#[pymethods]
impl Stop {
    #[new]
    fn new() -> Stop {
        Stop::default()
    }

    /// Ends all works that were given this; what they return is unfinished.
    fn set(&self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// What the working threads tell that of the caller.
#[derive(Default)]
struct Told {
    /// The last progress that the caller has not yet heard of.
    news: Option<(f64, String)>,
    done: bool,
}

/// Runs `task` on so many threads (none given: one for each core) that live as long as it does, so that
/// nothing is left for a forked process to wait for. `progress` is called by the caller's thread with a
/// fraction and what is being done. Its exceptions, and those of signals, end the work, and so does `other`.
pub(crate) fn worked<T: Send>(
    py: Python<'_>,
    jobs: Option<usize>,
    progress: Option<&Py<PyAny>>,
    other: Option<&Stop>,
    task: impl FnOnce(&Observe<'_>) -> T + Send,
) -> PyResult<T> {
    let threads = rayon::ThreadPoolBuilder::new().num_threads(jobs.unwrap_or(0)).stack_size(STACK);
    let pool = threads.build().map_err(|e| {
        DataError::new_err(format!("{} threads cannot be started: {e}", jobs.unwrap_or_default()))
    })?;
    let (told, changed, stop) = (Mutex::new(Told::default()), Condvar::new(), AtomicBool::new(false));
    let tell = |change: &dyn Fn(&mut Told)| {
        change(&mut locked(&told));
        changed.notify_one();
    };
    let observe = |at: Progress<'_>| {
        if progress.is_some() {
            tell(&|told| told.news = Some((at.fraction, at.activity.to_owned())));
        }
        let stopped =
            stop.load(Ordering::Relaxed) || other.is_some_and(|other| other.0.load(Ordering::Relaxed));
        if stopped { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let mut found = None;
    let heard = pool.in_place_scope(|scope| {
        scope.spawn(|_| {
            found = Some(catch_unwind(AssertUnwindSafe(|| task(&observe))));
            tell(&|told| told.done = true);
        });
        let mut heard = Ok(());
        loop {
            let (news, done) = py.detach(|| next(&told, &changed));
            let now = py.check_signals().and_then(|()| match (news, progress) {
                (Some(news), Some(progress)) if heard.is_ok() => progress.call1(py, news).map(drop),
                _ => Ok(()),
            });
            if let (Ok(()), Err(error)) = (&heard, now) {
                stop.store(true, Ordering::Relaxed);
                heard = Err(error);
            }
            if done {
                return heard;
            }
        }
    });
    heard?;
    let found = found.ok_or_else(|| NumericsError::new_err("the work did not begin"))?;
    found.map_err(|panic| NumericsError::new_err(format!("a mistake of phisindy: {}", words(&*panic))))
}

/// Waits for news, for the end of the work, or a little.
fn next(told: &Mutex<Told>, changed: &Condvar) -> (Option<(f64, String)>, bool) {
    let waiting = |told: &mut Told| told.news.is_none() && !told.done;
    let waited = changed.wait_timeout_while(locked(told), LOOK, waiting);
    let (mut told, _) = waited.unwrap_or_else(PoisonError::into_inner);
    (told.news.take(), told.done)
}

fn locked(told: &Mutex<Told>) -> MutexGuard<'_, Told> {
    told.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What a panic says.
fn words(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("no words")
}
