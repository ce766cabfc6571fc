//! A record that grows: lines come from a port, a socket or a file, go into a file of the working folder as they are,
//! and are judged again and again, so that who moves the rig knows when it is enough.

mod judgement;
mod source;

use crate::folder::{LARGEST_SPEC, Place, Working};
use phisindy::files::{Request, spec_text};
use phisindy_phys::splice;
use serde_json::{Value, json};
pub use source::Source;
pub(crate) use source::Stream;
use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Name of the file that the lines go to; a further one gets a number.
const NAME: &str = "live.csv";
/// Time between two judgements, when they take none themselves.
const JUDGED: Duration = Duration::from_millis(500);

/// A record that grows.
pub(crate) struct Live {
    source: Source,
    /// Its file.
    name: String,
    /// The spec that judges it, where there is one.
    spec: Option<String>,
    stop: AtomicBool,
    state: Mutex<State>,
}

/// What the page is told.
struct State {
    /// Lines that are in the file.
    lines: u64,
    since: Instant,
    /// Why nothing comes at present.
    trouble: Option<String>,
    ended: bool,
    judged: Value,
    /// How many lines that knew.
    judged_lines: u64,
}

impl Live {
    /// Opens the source and the file. Where the page begins with a spec that reads a file, a copy of it that reads the
    /// record judges it; its name comes with it.
    ///
    /// # Errors
    /// The source cannot be opened, or the folder takes no file.
    pub(crate) fn open(
        folder: &Working,
        source: Source,
        first: Option<&str>,
    ) -> io::Result<(Live, Stream, File)> {
        let stream = source.open()?;
        let (name, file) = new_file(folder)?;
        let spec = first.filter(|first| first.ends_with(".ron")).and_then(|first| {
            let text = reading(&spec_text(&folder.file(first).ok()?).ok()?, &name)?;
            let stem = crate::folder::stem(first);
            Some(
                folder
                    .write(&format!("{stem}-live.ron"), &mut text.as_bytes(), LARGEST_SPEC, Place::Beside)
                    .ok()?
                    .0,
            )
        });
        let state = State {
            lines: 0,
            since: Instant::now(),
            trouble: None,
            ended: false,
            judged: Value::Null,
            judged_lines: 0,
        };
        let live = Live { source, name, spec, stop: AtomicBool::new(false), state: Mutex::new(state) };
        Ok((live, stream, file))
    }

    /// What the page begins with: the spec that judges, if there is one.
    pub(crate) fn first(&self) -> Option<&str> {
        self.spec.as_deref()
    }

    /// Ends the record; what has come is in the file.
    pub(crate) fn stop(&self) {
        self.stop.store(true, Ordering::SeqCst);
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What the page shows.
    pub(crate) fn now(&self) -> Value {
        let state = self.state();
        json!({
            "source": self.source.to_string(), "name": self.name, "spec": self.spec, "lines": state.lines,
            "seconds": state.since.elapsed().as_secs_f64(), "trouble": state.trouble, "ended": state.ended,
            "judged": state.judged, "judged_lines": state.judged_lines,
        })
    }

    /// Writes what comes until it ends or is stopped. A disk that is full stops it; lines that came are kept until
    /// they are written.
    pub(crate) fn record(&self, mut stream: Stream, mut file: File) {
        let mut waiting = Vec::new();
        while !self.stop.load(Ordering::SeqCst) && !stream.has_ended() {
            match stream.lines(&mut waiting) {
                Ok(()) => self.state().trouble = None,
                Err(why) => self.state().trouble = Some(why.to_string()),
            }
            self.written(&mut file, &mut waiting);
        }
        // What the system has received and nobody has read yet.
        let _ = stream.rest(&mut waiting);
        self.written(&mut file, &mut waiting);
        if let Err(why) = file.sync_all() {
            self.state().trouble = Some(format!("cannot write `{}`: {why}", self.name));
        }
        self.state().ended = true;
    }

    fn written(&self, file: &mut File, waiting: &mut Vec<u8>) {
        while !waiting.is_empty() {
            match file.write(waiting) {
                Ok(0) => break,
                Ok(n) => {
                    let lines = waiting.drain(..n).filter(|b| *b == b'\n').count();
                    self.state().lines += lines as u64;
                }
                Err(why) if why.kind() == io::ErrorKind::Interrupted => {}
                Err(why) => {
                    self.state().trouble =
                        Some(format!("cannot write `{}`: {why}; the lines wait", self.name));
                    break;
                }
            }
        }
    }

    /// Judges what is in the file until the record has ended, and once more then.
    pub(crate) fn judge(&self, folder: &Working, request: &Request) {
        let (mut seen, mut last) = (0, false);
        while !last {
            let (lines, ended) = {
                let state = self.state();
                (state.lines, state.ended)
            };
            last = ended;
            if lines > seen {
                seen = lines;
                let began = Instant::now();
                let judged = judgement::of(folder, &self.name, self.spec.as_deref(), request);
                {
                    let mut state = self.state();
                    (state.judged, state.judged_lines) = (judged, seen);
                }
                // The record comes first: a judgement takes half of the time at most.
                self.wait(began.elapsed());
            }
            self.wait(JUDGED);
        }
    }

    /// Sleeps, and wakes when the record ends.
    fn wait(&self, long: Duration) {
        let since = Instant::now();
        while since.elapsed() < long && !self.state().ended {
            std::thread::sleep(long.min(Duration::from_millis(50)));
        }
    }
}

/// A file of its own for the record, with the first name that is free.
fn new_file(folder: &Working) -> io::Result<(String, File)> {
    let stem = crate::folder::stem(NAME);
    let names = std::iter::once(NAME.to_owned()).chain((2..1000).map(|k| format!("{stem}-{k}.csv")));
    for name in names {
        let path = folder.file(&name).map_err(io::Error::other)?;
        match OpenOptions::new().append(true).create_new(true).open(path) {
            Err(why) if why.kind() == io::ErrorKind::AlreadyExists => {}
            made => return Ok((name, made?)),
        }
    }
    Err(io::Error::other(format!("there are too many files called `{NAME}`")))
}

/// A spec whose one record is `file`, read as its first record with a file is; `None` without one.
fn reading(text: &str, file: &str) -> Option<String> {
    use phisindy_phys::spec::{DataSpec, read};
    let (spec, _) = read(text, phisindy_phys::SourceId(0)).ok()?;
    let csv = spec.data.iter().find_map(|data| match data {
        DataSpec::Csv(csv) if !csv.in_memory => Some(csv),
        _ => None,
    })?;
    let mut own = splice::set(&text[csv.span.range()], "path", &format!("{file:?}")).ok()?;
    for (field, given, value) in [("window", csv.window.is_some(), "(0.0, 1e9)"), ("role", true, "Fit")] {
        if given {
            own = splice::set(&own, field, value).ok()?;
        }
    }
    splice::set(text, "data", &format!("[{own}]")).ok()
}
