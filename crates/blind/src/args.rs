//! The command line: one subcommand for each table.

use clap::{Parser, Subcommand};
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  phisindy-blind hidden --out sets --sets 200 --seed 7      data sets with a hidden effect, the truth beside each
  phisindy-blind score --out sets                           `phisindy gap` on each of them, compared with the truth
  phisindy-blind calibrate --sets 400 --seed 7 --out worlds  whole worlds from priors: is what is said as sure as it says?
  phisindy-blind formula --sets 48 --noise 2                laws of no catalogue: is the force found as a formula?
  phisindy-blind wrong --sets 105 --seed 7                  known parts with one mistake: does `run` tell of it?
  phisindy-blind odd --runs 1000 --seed 7                   odd specs and data: does it panic, hang, or err?
  phisindy-blind reword --runs 40 --seed 7                  the same question in other words: is the answer the same?
  phisindy-blind paper --write docs/results.md              every case of the paper with both methods
  phisindy-blind sweep --seeds 100 --write docs/results.md  many seeds of every case
  phisindy-blind language --write docs/reference.md         the operations of the language
  phisindy-blind decisions --write docs/method.md           the numbers that decide something";

/// Blind tests of the program `phisindy`, and the tables of its documents.
#[derive(Debug, Parser)]
#[command(name = "phisindy-blind", version, before_help = EXAMPLES, max_term_width = 110)]
pub(crate) struct Args {
    /// Which table.
    #[command(subcommand)]
    pub(crate) command: Command,
    /// Options of all of them.
    #[command(flatten)]
    pub(crate) options: Options,
}

/// A table, or the data for one.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Make data sets with a hidden effect
    Hidden(HiddenArgs),
    /// Run `phisindy gap` on the sets of a folder and compare with their truths; the seconds are those of one
    /// thread
    Score(ScoreArgs),
    /// Draw whole worlds from priors, run `phisindy gap` on each, and count how often what it says with a
    /// probability is so
    Calibrate(CalibrateArgs),
    /// Hide laws that no catalogue has: is the force found as a formula? The seconds are those of `--threads`
    Formula(FormulaArgs),
    /// Identify models with one mistake in the known part: is it told?
    Wrong(WrongArgs),
    /// Noise that is not white, late sensors, unmeasured forces: do the intervals hold the truth?
    Noise(NoiseArgs),
    /// Run the program on odd and on damaged specs, data, laws and journals: does it panic, hang, or err?
    Odd(OddArgs),
    /// Ask the same question in other words: units, signs, names, orders, formats. Is the answer the same?
    Reword(RewordArgs),
    /// Each case beside what the paper prints
    Paper(CaseArgs),
    /// Many seeds of each case
    Sweep(SweepArgs),
    /// The numbers that decide something, with their reasons
    Decisions,
    /// The operations of the expression language
    Language,
    /// For mdbook: formulas of the book as MathML, from standard input to standard output
    Book {
        /// `supports html`, as mdbook asks
        query: Vec<String>,
    },
}

/// Options of all tables.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "Options of all tables")]
pub(crate) struct Options {
    /// The program to test [default: `phisindy` beside this program]
    #[arg(long, global = true, value_name = "PATH")]
    pub(crate) program: Option<PathBuf>,
    /// Put the table between its marks in this file
    #[arg(long, global = true, value_name = "FILE")]
    pub(crate) write: Option<PathBuf>,
    /// Number of sets (`hidden`, `score`, `wrong`) or threads (`paper`, `sweep`) at a time [default: all
    /// cores]
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) jobs: Option<u16>,
    /// No progress
    #[arg(long, short, global = true)]
    pub(crate) quiet: bool,
}

impl Options {
    /// Number of sets or threads at a time.
    pub(crate) fn jobs(&self) -> usize {
        self.jobs.map_or_else(|| std::thread::available_parallelism().map_or(1, usize::from), usize::from)
    }
}

/// Which sets to make.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct HiddenArgs {
    /// Folder of the sets
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Number of sets
    #[arg(long, value_name = "N", default_value_t = 40)]
    pub(crate) sets: usize,
    /// Seed of all draws
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,
    /// Hide this law only (or nothing, two, outside)
    #[arg(long, value_name = "LAW")]
    pub(crate) only: Option<String>,
    /// What the sensors measure
    #[arg(long, value_enum, default_value_t = Sensors::Mixed)]
    pub(crate) sensors: Sensors,
}

/// What the sensors of all sets measure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Sensors {
    /// Displacements, in three of four sets velocities too
    Mixed,
    /// Displacements alone
    Displacement,
    /// Accelerations alone
    Acceleration,
}

/// Which sets to score.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct ScoreArgs {
    /// Folder of the sets
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Also run the sets that have a result already
    #[arg(long)]
    pub(crate) again: bool,
}

/// Which worlds.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct CalibrateArgs {
    /// Folder of the worlds and answers; the same command goes on from there
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Number of worlds
    #[arg(long, value_name = "N", default_value_t = 400)]
    pub(crate) sets: usize,
    /// Seed of all draws
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,
    /// Seconds for each answer; what takes longer has failed
    #[arg(long, value_name = "S", default_value_t = 300)]
    pub(crate) patience: u64,
    /// Write the counts for each range of probability into this file, which reports quote
    #[arg(long, value_name = "FILE")]
    pub(crate) table: Option<PathBuf>,
}

/// Which sets for formulas.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct FormulaArgs {
    /// What is hidden
    #[arg(long, value_enum, default_value_t = Missing::Never)]
    pub(crate) what: Missing,
    /// Number of sets
    #[arg(long, value_name = "N", default_value_t = 24)]
    pub(crate) sets: usize,
    /// Seed of all draws
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,
    /// Noise, per cent of the standard deviation of each column
    #[arg(long, value_name = "P", default_value_t = 2.0)]
    pub(crate) noise: f64,
    /// Hide this law only
    #[arg(long, value_name = "LAW")]
    pub(crate) only: Option<String>,
    /// Keep sets and results in this folder; the same command goes on from there [default: a temporary
    /// folder]
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Run the sets that have a result already, too
    #[arg(long)]
    pub(crate) again: bool,
    /// Leave out the whole catalogue: the search of formulas alone
    #[arg(long)]
    pub(crate) bare: bool,
    /// Threads of each run
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) threads: u16,
}

/// What a set for formulas hides.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Missing {
    /// A static law that is in no catalogue
    Never,
    /// A static law of the catalogue, which is left out of it
    LeaveOneOut,
    /// Nothing
    Nothing,
    /// A law with memory, where all laws with memory are left out
    Memory,
}

/// Which known parts to get wrong.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct WrongArgs {
    /// Keep the specs in this folder
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Number of sets
    #[arg(long, value_name = "N", default_value_t = 40)]
    pub(crate) sets: usize,
    /// Seed of all draws, and of the noise in place of one of each set's own [default: 0]
    #[arg(long, value_name = "N")]
    pub(crate) seed: Option<u64>,
    /// This mistake only (or small: those that noise may hide)
    #[arg(long, value_name = "MISTAKE")]
    pub(crate) only: Option<String>,
}

/// Which noises.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct NoiseArgs {
    /// Number of sets of each kind
    #[arg(long, value_name = "N", default_value_t = 30)]
    pub(crate) sets: usize,
    /// Seed of all draws [default: 0]
    #[arg(long, value_name = "N")]
    pub(crate) seed: Option<u64>,
}

/// Which odd cases.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct OddArgs {
    /// Keep the files of what fails or is wrong in this folder
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Number of executions
    #[arg(long, value_name = "N", default_value_t = 1000)]
    pub(crate) runs: usize,
    /// Seed of all draws
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,
    /// This execution only, and keep its files
    #[arg(long, value_name = "INDEX")]
    pub(crate) only: Option<usize>,
}

/// Which questions to ask in other words.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct RewordArgs {
    /// Keep the files of what disagrees in this folder
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Number of cases
    #[arg(long, value_name = "N", default_value_t = 40)]
    pub(crate) runs: usize,
    /// Seed of all draws
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,
    /// Cases of this kind only
    #[arg(long, value_enum)]
    pub(crate) from: Option<Source>,
    /// This case only, and keep its files
    #[arg(long, value_name = "INDEX")]
    pub(crate) only: Option<usize>,
    /// This rewording only
    #[arg(long, value_name = "NAME")]
    pub(crate) kind: Option<String>,
    /// Folder of the specs
    #[arg(long, value_name = "DIR", default_value = "specs")]
    pub(crate) specs: PathBuf,
}

/// Where a case comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Source {
    /// Rigs of `wrong`, right ones: `run`
    Rig,
    /// Specs with synthetic records: `run`
    Spec,
    /// Sets of `hidden`: `gap`
    Hidden,
}

/// Which cases of the paper.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct CaseArgs {
    /// Only these cases, as in 1a,7
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub(crate) cases: Vec<String>,
    /// Folder of the specs
    #[arg(long, value_name = "DIR", default_value = "specs")]
    pub(crate) specs: PathBuf,
    /// Change a field of each spec, as in learn.cutoff=0.1; repeatable
    #[arg(long = "set", value_name = "PATH=VALUE", value_parser = assignment)]
    pub(crate) sets: Vec<Assignment>,
    /// Seed of the (first) noise, in place of the spec's
    #[arg(long, value_name = "N")]
    pub(crate) seed: Option<u64>,
}

/// Which cases, and how many seeds of each.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct SweepArgs {
    /// Which cases
    #[command(flatten)]
    pub(crate) cases: CaseArgs,
    /// Number of seeds
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub(crate) seeds: u64,
    /// Keep finished runs in this folder; the same command goes on from there
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
}

/// `PATH=VALUE`, as in the option `--set` of the program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Assignment {
    /// Parts joined by points.
    pub(crate) path: String,
    /// RON.
    pub(crate) value: String,
}

impl Assignment {
    /// A field and its value.
    pub(crate) fn new(path: &str, value: &str) -> Assignment {
        Assignment { path: path.to_owned(), value: value.to_owned() }
    }
}

fn assignment(text: &str) -> Result<Assignment, String> {
    match text.split_once('=') {
        Some((path, value)) if !path.trim().is_empty() && !value.trim().is_empty() => {
            Ok(Assignment::new(path.trim(), value.trim()))
        }
        _ => Err("expected PATH=VALUE, such as learn.cutoff=0.1".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        Args::command().debug_assert();
    }
}
