//! Runs the program as a user does: from the top of the repository, output to pipes.

pub(crate) mod slider;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};

/// The program of the developers, in the tests of its package.
const BLIND: Option<&str> = option_env!("CARGO_BIN_EXE_phisindy-blind");

/// What the program did.
#[derive(Debug)]
pub(crate) struct Outcome {
    pub(crate) code: i32,
    pub(crate) out: String,
    pub(crate) err: String,
}

/// The top of the repository.
pub(crate) fn top() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().expect("the top of the repository")
}

/// Says that the test of this thread is skipped. The line passes the capture of output, so that it is seen, and
/// `.ci/run` counts such lines.
pub(crate) fn skipped(why: &str) {
    let thread = std::thread::current();
    let test = thread.name().unwrap_or("a test");
    // Nothing can be reported if standard error is closed.
    let _ = writeln!(std::io::stderr(), "skipped: {test}: {why}");
}

/// The folder PHISINDY_DATA, where it holds this file of other people's measurements; the test is skipped where
/// it does not.
pub(crate) fn measured(file: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("PHISINDY_DATA").map(|folder| top().join(folder));
    let found = folder.filter(|folder| folder.join(file).is_file());
    if found.is_none() {
        skipped(&format!("no data: the folder PHISINDY_DATA has no `{file}`"));
    }
    found
}

/// The program `phisindy`. The tests of `phisindy-blind` take the one that lies beside their own program.
fn executable() -> PathBuf {
    if let Some(own) = option_env!("CARGO_BIN_EXE_phisindy") {
        return own.into();
    }
    let path = Path::new(BLIND.expect("a program"))
        .with_file_name(format!("phisindy{}", std::env::consts::EXE_SUFFIX));
    assert!(path.is_file(), "build {} first: cargo test -p phisindy-cli -p phisindy-blind", path.display());
    path
}

/// The program with these arguments, not started yet.
pub(crate) fn program(arguments: &[&str]) -> Command {
    let mut command = Command::new(executable());
    command.current_dir(top()).env_remove("PHISINDY_DATA").args(arguments).stdin(Stdio::null());
    command
}

/// Runs the program to its end.
#[track_caller]
pub(crate) fn phisindy(arguments: &[&str]) -> Outcome {
    outcome(&mut program(arguments))
}

/// Runs the program of the developers to its end, from its own package's tests.
#[track_caller]
pub(crate) fn blind(arguments: &[&str]) -> Outcome {
    let path = BLIND.expect("a test of `phisindy-blind`");
    outcome(Command::new(path).current_dir(top()).args(arguments).stdin(Stdio::null()))
}

#[track_caller]
fn outcome(command: &mut Command) -> Outcome {
    let output = command.output().expect("the program starts");
    Outcome {
        code: output.status.code().expect("an exit code: the program was not killed"),
        out: String::from_utf8(output.stdout).expect("UTF-8"),
        err: String::from_utf8(output.stderr).expect("UTF-8"),
    }
}

/// The files of a folder with this extension, in order, relative to the top.
pub(crate) fn files(folder: &str, extension: &str) -> Vec<String> {
    let entries = std::fs::read_dir(top().join(folder)).expect("a folder");
    let mut names: Vec<String> = entries
        .map(|e| e.expect("an entry").path())
        .filter(|p| p.extension().is_some_and(|e| e == extension))
        .map(|p| format!("{folder}/{}", p.file_name().expect("a name").to_string_lossy()))
        .collect();
    names.sort();
    names
}

/// A fresh folder that is removed at the end. Tests share a process: names alone would meet.
pub(crate) struct Scratch(pub(crate) PathBuf);

impl Scratch {
    pub(crate) fn new(name: &str) -> Scratch {
        static FOLDERS: AtomicUsize = AtomicUsize::new(0);
        let of_its_own = FOLDERS.fetch_add(1, Ordering::Relaxed);
        let path = std::env::temp_dir().join(format!("phisindy-{}-{of_its_own}-{name}", std::process::id()));
        let _ = std::fs::remove_dir_all(&path);
        std::fs::create_dir_all(&path).expect("a temporary folder");
        Scratch(path)
    }

    pub(crate) fn path(&self, name: &str) -> String {
        self.0.join(name).to_str().expect("UTF-8").to_owned()
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}
