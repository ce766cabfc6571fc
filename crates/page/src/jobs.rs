//! `run`, `gap` and `next` on a thread of their own, one at a time; what they are doing, for the page to watch.

use crate::check::said;
use crate::folder::{Working, stem};
use crate::results;
use phisindy::files::{self, Asked, Provenance, Purpose, Request, beside, load_text};
use phisindy::{Catalogue, Loaded, Options, Progress};
use phisindy_phys::Sources;
use phisindy_report::{Folder, Invocation, StopReason};
use serde_json::{Value, json};
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

/// Interval at which a result is tried to be written again, where the disk is full.
const AGAIN: Duration = Duration::from_millis(500);

/// What is to be done with a spec.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum What {
    /// Find the terms of the dictionary.
    Run,
    /// Find the laws that are missing.
    Gap,
    /// Design the next run.
    Next,
}

impl What {
    /// From its name in requests.
    pub(crate) fn named(name: &str) -> Option<What> {
        [What::Run, What::Gap, What::Next].into_iter().find(|what| what.name() == name)
    }

    fn name(self) -> &'static str {
        match self {
            What::Run => "run",
            What::Gap => "gap",
            What::Next => "next",
        }
    }

    fn purpose(self) -> Purpose {
        match self {
            What::Run | What::Next => Purpose::Run,
            What::Gap => Purpose::Gap,
        }
    }
}

/// The work of the page.
#[derive(Default)]
pub(crate) struct Jobs {
    now: Arc<Now>,
}

#[derive(Default)]
struct Now {
    state: Mutex<State>,
    stop: AtomicBool,
    /// Why the program ends: nothing new is started.
    closed: OnceLock<StopReason>,
}

/// The job that is under way, or the last one.
#[derive(Clone, Default)]
struct State {
    /// Counts jobs.
    job: u64,
    what: &'static str,
    spec: String,
    running: bool,
    /// It never goes back: a search that begins another round has more to do than it knew.
    fraction: f64,
    /// What is being done.
    activity: String,
    /// The least gap so far, from each time on at which it fell (s).
    curve: Vec<(f64, f64)>,
    begin: Option<Instant>,
    /// Seconds that it took.
    took: Option<f64>,
    /// How it ended, for the page.
    ended: Option<Value>,
}

impl Now {
    /// A panic of a thread that held the lock leaves data that are whole: each change is one assignment.
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn stopping(&self) -> bool {
        self.stop.load(Ordering::SeqCst) || self.closed.get().is_some()
    }

    /// Hears of the progress of work, and ends it.
    fn heard(&self, progress: Progress<'_>) -> ControlFlow<()> {
        self.tell(
            progress.fraction,
            if progress.activity.is_empty() { "fitting" } else { progress.activity },
        );
        if let Some(gap) = progress.gap {
            let mut state = self.state();
            let seconds = state.begin.map_or(0.0, |begin| begin.elapsed().as_secs_f64());
            if state.curve.last().is_none_or(|(_, least)| gap < *least) {
                state.curve.push((seconds, gap));
            }
        }
        if self.stopping() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// Says what is being done.
    fn tell(&self, fraction: f64, activity: &str) {
        let mut state = self.state();
        state.fraction = state.fraction.max(fraction.min(1.0));
        if state.activity != activity {
            activity.clone_into(&mut state.activity);
        }
    }
}

impl Jobs {
    /// Starts work on a spec of the folder.
    ///
    /// # Errors
    /// In words: something is running, or there is no such spec.
    pub(crate) fn start(
        &self,
        folder: &Working,
        request: &Request,
        spec: &str,
        what: What,
    ) -> Result<(), String> {
        let path = folder.file(spec)?;
        let text = phisindy::files::spec_text(&path).map_err(|d| d.message)?;
        {
            let mut state = self.now.state();
            if state.running {
                return Err("something is running: wait, or stop it first".to_owned());
            }
            if self.now.closed.get().is_some() {
                return Err("the program is ending".to_owned());
            }
            *state = State {
                job: state.job + 1,
                what: what.name(),
                spec: spec.to_owned(),
                running: true,
                begin: Some(Instant::now()),
                ..State::default()
            };
            self.now.stop.store(false, Ordering::SeqCst);
        }
        let (now, place, request) = (Arc::clone(&self.now), folder.path().to_owned(), request.clone());
        let work = move || {
            let worked = catch_unwind(AssertUnwindSafe(|| work(&now, &place, &request, &path, text, what)));
            let ended =
                worked.unwrap_or_else(|_| json!({ "error": "the program failed: please report this" }));
            let mut state = now.state();
            state.took = state.begin.map(|begin| begin.elapsed().as_secs_f64());
            state.running = false;
            state.ended = Some(ended);
        };
        let started = std::thread::Builder::new().name("work".to_owned()).spawn(work);
        started.map(drop).map_err(|why| {
            self.now.state().running = false;
            format!("cannot start the work: {why}")
        })
    }

    /// Asks the work to end; what is finished is kept.
    pub(crate) fn stop(&self) {
        self.now.stop.store(true, Ordering::SeqCst);
    }

    /// Asks the work to end, and starts nothing any more.
    pub(crate) fn close(&self, why: StopReason) {
        let _ = self.now.closed.set(why);
    }

    /// Whether something is running.
    pub(crate) fn busy(&self) -> bool {
        self.now.state().running
    }

    /// What is being done, or how it ended.
    pub(crate) fn now(&self) -> Value {
        let state = self.now.state();
        let seconds = state.took.or(state.begin.map(|begin| begin.elapsed().as_secs_f64()));
        json!({
            "job": state.job, "what": state.what, "spec": state.spec, "running": state.running,
            "fraction": state.fraction, "activity": state.activity, "seconds": seconds, "curve": state.curve, "ended": state.ended,
            "stopping": state.running && self.now.stopping(),
        })
    }
}

/// Does the work and keeps its result; how it ended.
fn work(now: &Now, folder: &Path, request: &Request, path: &Path, text: String, what: What) -> Value {
    let begin = Instant::now();
    now.tell(0.0, "reading the spec and its data");
    let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    if what == What::Next {
        let observe = |progress: Progress<'_>| now.heard(progress);
        let options = Options { observe: Some(&observe), ..Options::default() };
        return match files::next(path, None, request, &options) {
            Ok(found) => {
                let files = found.folder(&[what.name().to_owned(), name.clone()]);
                kept(now, folder, (&name, what), &files, found.design.stopped)
            }
            Err(why) => json!({ "error": why }),
        };
    }
    let (mut sources, mut found) = (Sources::default(), Vec::new());
    let loaded = load_text(path, text, request, what.purpose(), &mut sources, &mut found);
    let Ok(loaded) = loaded else {
        return json!({ "diagnostics": said(&found, &sources, false) });
    };
    let doubts = found.iter().map(|d| d.message.clone()).collect();
    let loaded = Loaded { doubts, spec: name.clone(), ..loaded };
    let laws = match beside(path, request) {
        Ok(laws) => laws,
        Err(why) => return json!({ "error": why.to_string() }),
    };
    let asked = Asked { command: what.purpose(), spec: path, request, method: None, without: &[] };
    let made = Provenance::of(&asked, &loaded, &results::place(folder));
    match worked(now, loaded.clone(), &laws, what, begin, &made) {
        Ok((mut files, stopped)) => {
            made.put_into(&mut files, &loaded);
            kept(now, folder, (&name, what), &files, stopped)
        }
        Err(error) => {
            json!({ "error": error.to_string(), "help": phisindy_report::html::advice(error.diverged()) })
        }
    }
}

/// Keeps a result. An answer of hours waits until there is room for it, unless it is given up.
fn kept(now: &Now, folder: &Path, (spec, what): (&str, What), files: &Folder, stopped: bool) -> Value {
    now.stop.store(false, Ordering::SeqCst);
    loop {
        match results::keep(folder, stem(spec), what.name(), files) {
            Ok(result) => return json!({ "result": result, "stopped": stopped, "lacks": files.lacks }),
            Err(why) if now.stopping() => return json!({ "error": why }),
            Err(why) => now.tell(1.0, &format!("{why}; trying again, until it is stopped")),
        }
        std::thread::sleep(AGAIN);
    }
}

/// The files of the result, and whether the work was stopped.
fn worked(
    now: &Now,
    loaded: Loaded,
    laws: &Catalogue,
    what: What,
    begin: Instant,
    made: &Provenance,
) -> Result<(Folder, bool), phisindy::Error> {
    let observe = |progress: Progress<'_>| now.heard(progress);
    let options = Options { laws: Some(laws), observe: Some(&observe), ..Options::default() };
    let seconds = || begin.elapsed().as_secs_f64();
    let spec = loaded.spec.clone();
    let arguments = vec![what.name().to_owned(), spec];
    let command = Invocation { arguments, inputs: Some(made.inputs()), ..Invocation::default() };
    let why = || now.closed.get().copied().unwrap_or(StopReason::Interrupt);
    Ok(match what.purpose() {
        Purpose::Gap => {
            let found = loaded.gap(&options)?;
            (found.folder_of(seconds(), &command, why()), found.stopped())
        }
        _ => {
            let found = loaded.identify(&options)?;
            (found.folder_of(seconds(), &command, why()), found.stopped())
        }
    })
}
