//! The program `phisindy` as users run it: a process with arguments and its output.

use crate::args::Options;
use crate::interrupt;
use anyhow::{Context, Result, bail};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};

/// The longest interval at which the process and Ctrl-C are polled; short runs are polled more often.
const TICK: Duration = Duration::from_millis(20);

/// Where the program is.
#[derive(Clone, Debug)]
pub(crate) struct Program(PathBuf);

/// The outcome of a process.
pub(crate) struct Output {
    /// Its exit status; none if it exceeded the time limit and was killed.
    pub(crate) status: Option<ExitStatus>,
    /// Standard output.
    pub(crate) out: String,
    /// Standard error.
    pub(crate) err: String,
    /// How long it took.
    pub(crate) seconds: f64,
}

impl Program {
    /// The path of `--program`, otherwise `phisindy` beside this program.
    ///
    /// # Errors
    /// There is no such file.
    pub(crate) fn find(options: &Options) -> Result<Program> {
        let path = match &options.program {
            Some(path) => path.clone(),
            None => {
                let own = std::env::current_exe().context("cannot find this program")?;
                own.with_file_name(format!("phisindy{}", std::env::consts::EXE_SUFFIX))
            }
        };
        if !path.is_file() {
            bail!(
                "there is no program `{}`: build it (`cargo build --release`), or name it with --program",
                path.display()
            );
        }
        Ok(Program(path))
    }

    /// A command of the program without input. Data files come from its arguments, never from the
    /// environment.
    pub(crate) fn command(&self) -> Command {
        let mut command = Command::new(&self.0);
        command.env_remove("PHISINDY_DATA").stdin(Stdio::null());
        command
    }

    /// Runs a process to its end, with the time limit `patience` if there is one; none if the user stopped
    /// it.
    ///
    /// # Errors
    /// It cannot be started or waited for.
    pub(crate) fn output(&self, command: &mut Command, patience: Option<Duration>) -> Result<Option<Output>> {
        let begin = Instant::now();
        let mut child = command
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .with_context(|| format!("cannot start `{}`", self.0.display()))?;
        // A full pipe would block the process, so both are read while it runs.
        let (out, err) = (reader(child.stdout.take()), reader(child.stderr.take()));
        let status = loop {
            if let Some(status) = child.try_wait().context("cannot wait for the program")? {
                break Some(status);
            }
            if interrupt::requested() || patience.is_some_and(|patience| begin.elapsed() > patience) {
                end(&mut child);
                break None;
            }
            thread::sleep((begin.elapsed() / 8).clamp(Duration::from_millis(1), TICK));
        };
        let seconds = begin.elapsed().as_secs_f64();
        let (out, err) = (out.join().unwrap_or_default(), err.join().unwrap_or_default());
        Ok((!interrupt::requested()).then_some(Output { status, out, err, seconds }))
    }
}

impl Output {
    /// Its first error message without its place: the reason in `error: SPEC: reason`.
    pub(crate) fn reason(&self, spec: &Path) -> String {
        let first = self.err.lines().find_map(|line| line.strip_prefix("error: "));
        let first = first.unwrap_or_else(|| self.err.trim());
        first.strip_prefix(&format!("{}: ", spec.display())).unwrap_or(first).to_owned()
    }
}

fn reader(pipe: Option<impl Read + Send + 'static>) -> thread::JoinHandle<String> {
    thread::spawn(move || {
        let mut bytes = Vec::new();
        // A read error keeps the text before it.
        let _ = pipe.map(|mut pipe| pipe.read_to_end(&mut bytes));
        String::from_utf8_lossy(&bytes).into_owned()
    })
}

/// Kills a process, which may have ended already.
fn end(child: &mut Child) {
    let _ = child.kill();
    let _ = child.wait();
}
