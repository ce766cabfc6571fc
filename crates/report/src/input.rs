//! What every report is about: a case with its records, how the program was called, and how the work ended.

use phisindy_phys::spec::Spec;
use phisindy_phys::{Case, Record};
use std::fmt;
use std::time::Duration;

/// A checked case and its records.
#[derive(Clone, Copy, Debug)]
pub struct Input<'a> {
    /// Name of the spec as the user gave it, usually its path.
    pub name: &'a str,
    /// Text of the spec with every `--set` in it.
    pub text: &'a str,
    /// The text, read.
    pub spec: &'a Spec,
    /// What the spec means.
    pub case: &'a Case,
    /// In the order of the spec.
    pub records: &'a [Record],
    /// What is odd about the spec and its data.
    pub doubts: &'a [String],
}

/// How the program was called, so that a reader can repeat it.
#[derive(Clone, Debug, Default)]
pub struct Invocation {
    /// Arguments of the command line, without the name of the program.
    pub arguments: Vec<String>,
    /// Whether the text of the spec holds values of `--set`.
    pub assigned: bool,
    /// The seed of `--seed`.
    pub seed: Option<u64>,
    /// One hash (SHA-256) of the spec, its data, its laws and the version, if the folder keeps where they are.
    pub inputs: Option<String>,
}

/// How the work ended.
#[derive(Clone, Copy, Debug)]
pub struct Ending {
    /// Duration of the work in seconds.
    pub seconds: f64,
    /// Why it ended early; `None` if it was finished.
    pub stopped: Option<StopReason>,
}

impl Ending {
    /// `stopped by you` for work that ended early.
    pub(crate) fn stopped_words(&self) -> Option<String> {
        self.stopped.map(|reason| match reason {
            StopReason::Interrupt => "stopped by you".to_owned(),
            StopReason::Signal(name) => format!("stopped by {name}"),
            limit => format!("stopped: {limit}"),
        })
    }
}

/// Why work ended early.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopReason {
    /// Who asked for the work asked for its end.
    Interrupt,
    /// A signal to the program asked for it: `Ctrl-C`, `SIGTERM`.
    Signal(&'static str),
    /// The limit of time is met.
    TimeLimit(Duration),
    /// The limit of memory is met, in bytes.
    MemoryLimit(u64),
}

impl fmt::Display for StopReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            StopReason::Interrupt => f.write_str("it was stopped"),
            StopReason::Signal(name) => f.write_str(name),
            StopReason::TimeLimit(time) => write!(f, "the limit of {} s is met", time.as_secs_f64()),
            StopReason::MemoryLimit(bytes) => {
                write!(f, "the limit of {} MB of memory is met", bytes / 1_000_000)
            }
        }
    }
}
