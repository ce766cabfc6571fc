//! The program `phisindy` around the libraries: arguments, terminal, folders, progress, limits. `main.rs` and the
//! package for Python call it.
//!
//! ```text
//! args --> commands --> phisindy::files (spec, data) --> identify, gap --> phisindy_report --> terminal, outdir
//!                          +-- diagnostics --> draw --> terminal
//! ```

mod args;
mod commands;
mod draw;
mod fmu;
mod interrupt;
mod limit;
mod outdir;
mod progress;
mod sweep;
mod terminal;

use crate::args::{Args, Command, Options};
use anyhow::{Context, Result, anyhow};
use clap::Parser;
use phisindy::SpecError;
use std::ffi::OsString;
use std::io;

/// Runs the program with the words of a command line, of which the first is its name; returns the exit code.
///
/// Help, the version and mistakes of the command line end the process.
pub fn program(line: impl Iterator<Item = OsString>) -> u8 {
    let line: Vec<OsString> = line.collect();
    let mut args = Args::parse_from(&line);
    args.options.line = line.iter().skip(1).map(|word| word.to_string_lossy().into_owned()).collect();
    interrupt::listen(args.options.limit.unwrap_or_default());
    match execute(&args) {
        Ok(code) => code,
        // The reader of the result has closed the pipe.
        Err(error) if is_broken_pipe(&error) => 0,
        Err(error) => {
            terminal::complain(&format!("{error:#}"));
            terminal::INPUT
        }
    }
}

/// The mistakes of a spec as the program draws them: each with its line, marked, and what to do.
pub fn drawn(error: &SpecError) -> String {
    draw::text(error.mistakes(), error.sources())
}

/// Executes a command and returns the exit code.
fn execute(args: &Args) -> Result<u8> {
    let options = &args.options;
    start_threads(options)?;
    match &args.command {
        Command::Run { specs } => commands::run::run(specs, options),
        Command::Gap { spec, without } => commands::gap::gap(spec, without, options),
        Command::Simulate { spec, record } => commands::simulate::simulate(spec, record.as_deref(), options),
        Command::Check { specs } => Ok(commands::check::check(specs, options)),
        Command::New(args) => commands::new::command(args, options),
        Command::Laws { words } => match &words.iter().map(String::as_str).collect::<Vec<_>>()[..] {
            ["new", name] => commands::laws::new(name, options),
            [_, other, ..] => Err(anyhow!(
                "`{other}` is one word too many: `phisindy laws NAME` or `phisindy laws new NAME`"
            )),
            words => commands::laws::laws(words.first().copied(), options),
        },
        Command::Export(args) => commands::export::export(args, options),
        Command::Completions { shell } => commands::manual::completions(*shell),
        Command::Man => commands::manual::pages(options),
        Command::Sweep(args) => commands::sweep::sweep(args, options),
    }
}

fn start_threads(options: &Options) -> Result<()> {
    if let Some(jobs) = options.jobs {
        rayon::ThreadPoolBuilder::new()
            .num_threads(usize::from(jobs))
            .build_global()
            .context("cannot start the threads of --jobs")?;
    }
    Ok(())
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error.chain().any(|cause| {
        let direct = cause.downcast_ref::<io::Error>().map(io::Error::kind);
        let inside = cause.downcast_ref::<csv::Error>().and_then(|e| match e.kind() {
            csv::ErrorKind::Io(e) => Some(e.kind()),
            _ => None,
        });
        direct.or(inside) == Some(io::ErrorKind::BrokenPipe)
    })
}
