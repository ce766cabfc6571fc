//! A record that grows: lines come from a port, a socket or a file, go into a file of the working folder as they are,
//! and are judged again and again, so that who moves the rig knows when it is enough.

mod judgement;
mod row;
mod snapshot;
mod source;

use crate::edit::record_like;
use crate::folder::{LARGEST_SPEC, Place, Working, names_like, stem};
use phisindy::files::{Request, spec_text};
use phisindy_phys::{SourceId, spec, splice};
use serde_json::{Value, json};
pub use source::Source;
pub(crate) use source::Stream;
use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// Name of the file that the lines go to; a further one gets a number.
const NAME: &str = "live.csv";
/// Time between two judgements, when they take none themselves.
const JUDGED: Duration = Duration::from_millis(500);

/// Most bytes that wait while they cannot be written: then nothing more is taken.
const WAITING: usize = 64 << 20;
/// How long the end waits for room for them.
const GRACE: Duration = Duration::from_secs(10);

/// A record that grows.
pub(crate) struct Live {
    source: Source,
    /// The spec that the page begins with.
    given: Option<String>,
    stop: AtomicBool,
    /// Whether the program ends: nobody waits for a judgement.
    closes: AtomicBool,
    /// Where what is judged lies.
    judged: TempDir,
    state: Mutex<State>,
}

/// What the page is told.
struct State {
    /// The file of the record, and the spec that judges it, where there is one.
    name: String,
    spec: Option<String>,
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

/// The file that lines go to.
pub(crate) struct RecordFile {
    name: String,
    spec: Option<String>,
    file: File,
    /// Bytes that are written, up to the end of the last whole line.
    written: u64,
    whole: u64,
    /// Bytes that came and are not written.
    waiting: Vec<u8>,
}

impl RecordFile {
    /// A file of its own, and a copy of the spec that the page begins with that reads it.
    fn new(folder: &Working, given: Option<&str>) -> io::Result<RecordFile> {
        let text = given.map(|given| {
            let path = folder.file(given).map_err(io::Error::other)?;
            let text = spec_text(&path).map_err(|d| io::Error::other(d.message))?;
            let why =
                "it is no spec, or none of its records reads a file: nothing could judge the record by it";
            let lacks = || io::Error::other(format!("`{given}` cannot be used with --live: {why}"));
            // Only to know that it can: the file gets its name below.
            reading(&text, NAME).ok_or_else(lacks).map(|_| (given, text))
        });
        let text = text.transpose()?;
        let (name, file) = new_file(folder)?;
        let spec = match text.and_then(|(given, text)| Some((given, reading(&text, &name)?))) {
            Some((given, text)) => {
                let new = format!("{}-live.ron", stem(given));
                let written = folder.write(&new, &mut text.as_bytes(), LARGEST_SPEC, Place::Beside);
                written.ok().map(|(name, _)| name)
            }
            None => None,
        };
        Ok(RecordFile { name, spec, file, written: 0, whole: 0, waiting: vec![] })
    }

    /// Writes what waits; how many lines that were.
    ///
    /// # Errors
    /// Not all of it can be written; the rest waits.
    fn write(&mut self) -> io::Result<u64> {
        let mut lines = 0;
        while !self.waiting.is_empty() {
            match self.file.write(&self.waiting) {
                Ok(0) => return Err(io::ErrorKind::WriteZero.into()),
                Ok(n) => {
                    if let Some(last) = self.waiting[..n].iter().rposition(|b| *b == b'\n') {
                        self.whole = self.written + last as u64 + 1;
                    }
                    self.written += n as u64;
                    lines += self.waiting.drain(..n).filter(|b| *b == b'\n').count() as u64;
                }
                Err(why) if why.kind() == io::ErrorKind::Interrupted => {}
                Err(why) => return Err(why),
            }
        }
        Ok(lines)
    }
}

impl Live {
    /// Opens the source and the file. Where the page begins with a spec, a copy of it that reads the record judges it.
    ///
    /// # Errors
    /// The source cannot be opened, the folder takes no file, or the spec reads no file.
    pub(crate) fn open(
        folder: &Working,
        source: Source,
        first: Option<&str>,
    ) -> io::Result<(Live, Stream, RecordFile)> {
        let stream = source.open()?;
        let given = first.filter(|first| first.ends_with(".ron")).map(str::to_owned);
        let to = RecordFile::new(folder, given.as_deref()).map_err(|why| {
            io::Error::new(why.kind(), format!("no record can grow in `{}`: {why}", folder.path().display()))
        })?;
        let state = State {
            name: to.name.clone(),
            spec: to.spec.clone(),
            lines: 0,
            since: Instant::now(),
            trouble: None,
            ended: false,
            judged: Value::Null,
            judged_lines: 0,
        };
        let [stop, closes] = [false, false].map(AtomicBool::new);
        let judged = tempfile::tempdir()?;
        Ok((Live { source, given, stop, closes, judged, state: Mutex::new(state) }, stream, to))
    }

    /// What the page begins with: the spec that judges, if there is one.
    pub(crate) fn first(&self) -> Option<String> {
        self.state().spec.clone()
    }

    /// Ends the record; what has come is in the file.
    pub(crate) fn stop(&self) {
        self.stop.store(true, Ordering::SeqCst);
    }

    /// Ends it with the program.
    pub(crate) fn close(&self) {
        self.closes.store(true, Ordering::SeqCst);
        self.stop();
        // Nobody waits for a judgement that is under way: it finds nothing, and says so to nobody.
        let _ = std::fs::remove_dir_all(self.judged.path());
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What the page shows.
    pub(crate) fn now(&self) -> Value {
        let state = self.state();
        json!({
            "source": self.source.to_string(), "name": state.name, "spec": state.spec, "lines": state.lines,
            "seconds": state.since.elapsed().as_secs_f64(), "trouble": state.trouble, "ended": state.ended,
            "judged": state.judged, "judged_lines": state.judged_lines,
        })
    }

    /// Writes what comes until it ends or is stopped; what was lost, in words. Where the disk is full the lines wait.
    /// A source that broke off and is back begins a new record: a board counts its time anew.
    pub(crate) fn record(&self, folder: &Working, mut stream: Stream, mut to: RecordFile) -> Option<String> {
        while !self.stop.load(Ordering::SeqCst) && !stream.has_ended() {
            let read = if to.waiting.len() < WAITING { stream.lines(&mut to.waiting) } else { Ok(false) };
            let began_anew = matches!(read, Ok(true));
            let mut trouble = read.err().map(|why| why.to_string());
            match to.write() {
                Ok(lines) => self.state().lines += lines,
                Err(why) => trouble = Some(format!("cannot write `{}`: {why}; the lines wait", to.name)),
            }
            if began_anew && to.whole > 0 && to.waiting.is_empty() {
                match RecordFile::new(folder, self.given.as_deref()) {
                    Ok(new) => {
                        let mut state = self.state();
                        (state.name, state.spec) = (new.name.clone(), new.spec.clone());
                        (state.lines, state.judged_lines) = (0, 0);
                        to = new;
                    }
                    Err(why) => trouble = Some(format!("no new record can begin: {why}")),
                }
            }
            self.state().trouble = trouble;
        }
        // What the system has received and nobody has read yet.
        let _ = stream.rest(&mut to.waiting);
        let since = Instant::now();
        let mut written = to.write();
        while written.is_err() && since.elapsed() < GRACE {
            std::thread::sleep(Duration::from_millis(100));
            written = to.write();
        }
        let lost = written.and_then(|lines| {
            self.state().lines += lines;
            to.file.sync_all()
        });
        let lost = lost.err().map(|why| {
            // What is kept ends with a whole line.
            let _ = to.file.set_len(to.whole);
            let lines = to.waiting.iter().filter(|b| **b == b'\n').count();
            format!("{lines} lines could not be written to `{}` and are lost: {why}", to.name)
        });
        let mut state = self.state();
        state.trouble =
            lost.clone().or(stream.has_ended().then(|| "the sender has closed the connection".into()));
        state.ended = true;
        lost
    }

    /// Judges what is in the file until the record has ended, and once more then.
    pub(crate) fn judge(&self, folder: &Working, request: &Request) {
        let (mut seen, mut last) = (0, false);
        while !last && !self.closes.load(Ordering::SeqCst) {
            let (name, spec, lines, ended) = {
                let state = self.state();
                (state.name.clone(), state.spec.clone(), state.lines, state.ended)
            };
            last = ended;
            if lines != seen {
                seen = lines;
                let began = Instant::now();
                let judged = judgement::of(folder, (&name, spec.as_deref()), request, self.judged.path());
                {
                    let mut state = self.state();
                    if state.name == name {
                        (state.judged, state.judged_lines) = (judged, seen);
                    }
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
    for name in names_like(NAME) {
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
    let (spec, _) = spec::read_without_files(text, SourceId(0)).ok()?;
    let first = spec.data.iter().find_map(spec::DataSpec::of_file)?;
    let own = record_like(&text[first.span.range()], file, "Fit").ok()?;
    splice::set(text, "data", &format!("[{own}]")).ok()
}
