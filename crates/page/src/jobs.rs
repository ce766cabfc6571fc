//! `run` and `gap` on a thread of their own, one at a time; what they are doing, for the page to watch.

use crate::check::said;
use crate::folder::{Working, stem};
use crate::results;
use phisindy::files::{Purpose, Request, beside, load_text};
use phisindy::{Catalogue, Loaded, Options, Progress};
use phisindy_phys::Sources;
use phisindy_report::Folder;
use serde_json::{Value, json};
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Least time between two states that are sent.
const BEAT: Duration = Duration::from_millis(150);

/// What is to be done with a spec.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum What {
    /// Find the terms of the dictionary.
    Run,
    /// Find the laws that are missing.
    Gap,
}

impl What {
    /// From its name in requests.
    pub(crate) fn named(name: &str) -> Option<What> {
        [What::Run, What::Gap].into_iter().find(|what| what.name() == name)
    }

    fn name(self) -> &'static str {
        match self {
            What::Run => "run",
            What::Gap => "gap",
        }
    }

    fn purpose(self) -> Purpose {
        match self {
            What::Run => Purpose::Run,
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
    changed: Condvar,
    stop: AtomicBool,
}

/// The job that is under way, or the last one.
#[derive(Clone, Default)]
struct State {
    /// Counts changes.
    version: u64,
    /// Counts jobs.
    job: u64,
    what: &'static str,
    spec: String,
    running: bool,
    fraction: f64,
    /// What was begun, and when (s).
    log: Vec<(f64, String)>,
    begin: Option<Instant>,
    /// How it ended, for the page.
    ended: Option<Value>,
}

impl State {
    fn json(&self) -> Value {
        json!({
            "job": self.job, "what": self.what, "spec": self.spec, "running": self.running,
            "fraction": self.fraction, "log": self.log, "ended": self.ended,
            "seconds": self.begin.filter(|_| self.running).map(|b| b.elapsed().as_secs_f64()),
        })
    }
}

impl Now {
    /// A panic of a thread that held the lock leaves data that are whole: each change is one assignment.
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn change(&self, change: impl FnOnce(&mut State)) {
        let mut state = self.state();
        change(&mut state);
        state.version += 1;
        self.changed.notify_all();
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
            *state = State {
                version: state.version + 1,
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
            now.change(|state| {
                state.running = false;
                state.ended = Some(ended);
            });
        };
        let started = std::thread::Builder::new().name("work".to_owned()).spawn(work);
        started.map(drop).map_err(|why| {
            self.now.change(|state| state.running = false);
            format!("cannot start the work: {why}")
        })
    }

    /// Asks the work to end; what is finished is kept.
    pub(crate) fn stop(&self) {
        self.now.stop.store(true, Ordering::SeqCst);
    }

    /// Whether something is running.
    pub(crate) fn busy(&self) -> bool {
        self.now.state().running
    }

    /// The state, once it is another one than that of `version`, with its version; after `patience` in any
    /// case.
    pub(crate) fn after(&self, version: Option<u64>, patience: Duration) -> (u64, Value) {
        let state = self.now.state();
        let same = |state: &mut State| Some(state.version) == version;
        let waited = self.now.changed.wait_timeout_while(state, patience, same);
        let (state, _) = waited.unwrap_or_else(PoisonError::into_inner);
        (state.version, state.json())
    }
}

/// Does the work and keeps its result; how it ended.
fn work(now: &Now, folder: &Path, request: &Request, path: &Path, text: String, what: What) -> Value {
    let begin = Instant::now();
    now.change(|state| state.log.push((0.0, "reading the spec and its data".to_owned())));
    let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
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
    match worked(now, loaded, &laws, what, begin) {
        Ok((files, stopped)) => {
            let kept = results::keep(folder, stem(&name), what.name(), &files);
            let lacks = files.lacks;
            match kept {
                Ok(result) => json!({ "result": result, "stopped": stopped, "lacks": lacks }),
                Err(why) => json!({ "error": why }),
            }
        }
        Err(error) => {
            json!({ "error": error.to_string(), "help": phisindy_report::html::advice(error.diverged()) })
        }
    }
}

/// The files of the result, and whether the work was stopped.
fn worked(
    now: &Now,
    loaded: Loaded,
    laws: &Catalogue,
    what: What,
    begin: Instant,
) -> Result<(Folder, bool), phisindy::Error> {
    let told = Mutex::new(begin);
    let observe = |progress: Progress<'_>| {
        tell(now, progress, begin, &told);
        if now.stop.load(Ordering::SeqCst) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let options = Options { laws: Some(laws), observe: Some(&observe), ..Options::default() };
    let seconds = || begin.elapsed().as_secs_f64();
    let spec = loaded.spec.clone();
    let command = [what.name(), spec.as_str()];
    Ok(match what {
        What::Run => {
            let found = loaded.identify(&options)?;
            (found.folder_of(seconds(), &command), found.stopped())
        }
        What::Gap => {
            let found = loaded.gap(&options)?;
            (found.folder_of(seconds(), &command), found.stopped())
        }
    })
}

/// Tells the page, not more often than it can be seen.
fn tell(now: &Now, progress: Progress<'_>, begin: Instant, told: &Mutex<Instant>) {
    let mut last = told.lock().unwrap_or_else(PoisonError::into_inner);
    let activity = if progress.activity.is_empty() { "fitting" } else { progress.activity };
    let new = now.state().log.last().is_none_or(|(_, words)| words != activity);
    if !new && last.elapsed() < BEAT {
        return;
    }
    *last = Instant::now();
    now.change(|state| {
        state.fraction = progress.fraction.clamp(0.0, 1.0);
        if new {
            state.log.push((begin.elapsed().as_secs_f64(), activity.to_owned()));
        }
    });
}
