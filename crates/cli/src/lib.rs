//! The program `phisindy` around the libraries: arguments, terminal, folders, progress, limits. `main.rs` and
//! the package for Python call it.
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

use crate::args::{Args, Command, Options, command_line, refuse_unused};
use crate::limit::Limit;
use anyhow::{Context, Result, anyhow};
use clap::FromArgMatches;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use phisindy::SpecError;
use std::ffi::OsString;
use std::io;
use std::path::Path;

/// Runs the program with the words of a command line, of which the first is its name; returns the exit code.
///
/// Help, the version and mistakes of the command line end the process.
pub fn program(line: impl Iterator<Item = OsString>) -> u8 {
    interrupt::outlast_the_limit_of_files();
    let line: Vec<OsString> = line.collect();
    let mut args = match parsed(&line) {
        Ok(args) => args,
        Err(error) => error.exit(),
    };
    args.options.line = line.iter().skip(1).map(|word| word.to_string_lossy().into_owned()).collect();
    let form = args.options.line.iter().any(|word| word == "--format" || word.starts_with("--format="));
    args.options.look = terminal::look().filter(|_| !form);
    let unlimited = matches!(args.command, Command::Open(_) | Command::Lsp);
    let limit = args.options.limit.unwrap_or(if unlimited { Limit::none() } else { Limit::default() });
    interrupt::listen(limit, args.command.keeps());
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

/// The runs that the bytes of journals hold, a line of JSON for each, and the table that `sweep --merge` makes of
/// them. For the fuzzer.
///
/// # Errors
/// In words: one of them is no journal, is damaged, or is of another sweep.
#[doc(hidden)]
pub fn merged_journals(journals: &[&[u8]]) -> Result<(Vec<String>, String), String> {
    let read = |(k, text): (usize, &&[u8])| {
        let shown = format!("journal {k}");
        Ok((shown.clone(), sweep::Kept::of(text, &shown)?))
    };
    let told = |error: anyhow::Error| format!("{error:#}");
    let merged = sweep::merge(journals.iter().enumerate().map(read)).map_err(told)?;
    let cells = merged.design.cells();
    let result = merged.table(&cells);
    let lines = merged.runs.iter().flatten().map(serde_json::to_string).collect::<Result<_, _>>();
    let lines = lines.map_err(|error| error.to_string())?;
    Ok((lines, result.written(phisindy::Format::Text) + &result.written(phisindy::Format::Json)))
}

/// The words of a command line. A file in place of a command, and a misspelt command, get a suggestion.
fn parsed(line: &[OsString]) -> Result<Args, clap::Error> {
    let matches = command_line().try_get_matches_from(line);
    let read = |matches: clap::ArgMatches| {
        refuse_unused(&matches)?;
        Args::from_arg_matches(&matches)
    };
    matches.and_then(read).map_err(|mut error| {
        let word = match error.get(ContextKind::InvalidSubcommand) {
            Some(ContextValue::String(word)) => word.clone(),
            _ => String::new(),
        };
        if error.kind() == ErrorKind::InvalidSubcommand
            && error.get(ContextKind::SuggestedSubcommand).is_none()
            && let Some(advice) = command_for(&word)
        {
            error.insert(ContextKind::SuggestedSubcommand, ContextValue::String(advice));
        }
        error
    })
}

/// The command that was meant by a word that is none.
fn command_for(word: &str) -> Option<String> {
    let ending = Path::new(word).extension().map(|e| e.to_string_lossy().to_lowercase());
    match ending.as_deref() {
        Some("ron") => Some(format!("run {word}")),
        Some(_) => Some(format!("go {word}")),
        None => {
            let command = command_line();
            let names: Vec<&str> = command.get_subcommands().map(clap::Command::get_name).collect();
            // Letters that changed places are the commonest slip.
            let sorted = |text: &str| {
                let mut letters: Vec<char> = text.chars().collect();
                letters.sort_unstable();
                letters
            };
            let same = names.iter().find(|name| sorted(name) == sorted(word)).copied();
            same.or_else(|| phisindy_expr::nearest(word, names.iter().copied())).map(str::to_owned)
        }
    }
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
        Command::Go(args) => commands::go::command(args, options),
        Command::New(args) => commands::new::command(args, options),
        Command::Laws { words } => match &words.iter().map(String::as_str).collect::<Vec<_>>()[..] {
            ["new", name] => commands::laws::new(name, options),
            [_, other, ..] => Err(anyhow!(
                "`{other}` is one word too many: `phisindy laws NAME` or `phisindy laws new NAME`"
            )),
            words => commands::laws::laws(words.first().copied(), options),
        },
        Command::Open(args) => commands::open::open(args, options),
        Command::Export(args) => commands::export::export(args, options),
        Command::Fmt { files, check } => commands::fmt::fmt(files, *check),
        Command::Lsp => commands::editor::serve(options),
        Command::Schema { of } => commands::editor::schema(*of),
        Command::Completions { shell } => commands::manual::completions(*shell),
        Command::Man => commands::manual::pages(options),
        Command::Sweep(args) => commands::sweep::sweep(args, options),
        Command::Compare { paths } => commands::compare::compare(paths, options),
        Command::Next { path, narrow } => commands::next::next(path, narrow.as_deref(), options),
        Command::Verify { folder } => commands::verify::verify(folder, options),
    }
}

fn start_threads(options: &Options) -> Result<()> {
    if let Some(jobs) = options.jobs {
        rayon::ThreadPoolBuilder::new()
            .num_threads(jobs)
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
