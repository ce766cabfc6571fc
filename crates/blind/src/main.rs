//! `phisindy-blind`: tests of the program `phisindy` for its developers, with answers that it does not see,
//! and the tables of the documents.
//!
//! ```text
//! seed --hidden--> DIR/NNN: spec and data of a rig with an effect that the spec lacks | truth.json
//! DIR/NNN --phisindy gap--> result.json --score, with truth.json--> table
//! seed --calibrate--> worlds drawn from priors --phisindy gap--> probabilities beside how often it is so --> tables
//! seed --formula--> sets with a law of no catalogue --phisindy gap--> compared forces --> table
//! seed --wrong--> specs with one mistake in the known part --identify--> is it reported? --> table
//! seed --noise--> sliders with noise that is not white, late sensors, forces --identify--> intervals right? --> table
//! seed --odd--> odd and damaged files --phisindy COMMAND--> exit code, answer --> table
//! a case --reword--> the same question in other words --phisindy run, gap--> the same answer? --> table
//! specs of the paper --phisindy run, phisindy sweep--> tables of docs/results.md
//! ```

mod args;
mod book;
mod dice;
mod folder;
mod hidden;
mod interrupt;
mod markdown;
mod names;
mod noise;
mod odd;
mod program;
mod progress;
mod readme;
mod reword;
mod synthetic;
mod table;
mod wrong;

use anyhow::{Context, Result};
use args::{Args, Command, Options};
use clap::Parser;
use std::io::Write;
use std::process::ExitCode;
use table::Table;

/// Exit code of a wrong command line, spec or folder.
const INPUT: u8 = 2;

fn main() -> ExitCode {
    interrupt::listen();
    match run(&Args::parse()) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(interrupt::INTERRUPTED),
        Err(error) => {
            // Nothing can be reported if standard error is closed.
            let _ = writeln!(std::io::stderr(), "error: {error:#}");
            ExitCode::from(INPUT)
        }
    }
}

/// Runs the command; false if the user stopped it.
fn run(args: &Args) -> Result<bool> {
    let options = &args.options;
    rayon::ThreadPoolBuilder::new()
        .num_threads(options.jobs())
        .build_global()
        .context("cannot start the threads")?;
    let made = match &args.command {
        Command::Hidden(args) => return hidden::make(args, options),
        Command::Book { query } => return book::preprocess(query).map(|()| true),
        Command::Score(args) => hidden::score(args, options)?,
        Command::Calibrate(args) => hidden::calibrate(args, options)?,
        Command::Formula(args) => hidden::formula(args, options)?,
        Command::Wrong(args) => wrong::table(args, options)?,
        Command::Noise(args) => noise::table(args, options)?,
        Command::Odd(args) => odd::table(args, options)?,
        Command::Reword(args) => reword::table(args, options)?,
        Command::Paper(args) => readme::paper(args, options)?.map(|table| Table::new("paper", table)),
        Command::Sweep(args) => readme::sweep(args, options)?.map(|table| Table::new("sweep", table)),
        Command::Decisions => Some(Table::new("decisions", readme::decisions())),
        Command::Language => Some(Table::new("language", readme::language())),
    };
    made.map_or(Ok(false), |table| shown(&table, options).map(|()| true))
}

/// Prints a table, and writes it into a document if the options name one.
fn shown(made: &Table, options: &Options) -> Result<()> {
    folder::print(&made.table)?;
    if !made.failures.is_empty() {
        folder::print(&format!("\n{}", made.failures))?;
    }
    if let Some(path) = &options.write {
        let shown = path.display();
        let text = std::fs::read_to_string(path).with_context(|| format!("cannot read `{shown}`"))?;
        let new =
            markdown::between_marks(&text, made.name, &made.table).with_context(|| format!("`{shown}`"))?;
        folder::replace(path, &new)?;
    }
    Ok(())
}
