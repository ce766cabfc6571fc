//! `phisindy`: the program around the crates. The only one that reads and writes files, and that draws.
//!
//! ```text
//! args --> command --> load (spec, data files) --> phisindy_learn --> report (LaTeX, text, JSON) --> standard output, --out
//!                        +-- diagnostics --> draw --> standard error
//! ```

mod args;
mod chart;
mod command;
mod contribution;
mod datafile;
mod draw;
mod equation;
mod export;
mod gap;
mod held;
mod hidden;
mod html;
mod identified_spec;
mod interrupt;
mod json;
mod laws;
mod limit;
mod linear_combination;
mod load;
mod manual;
mod markup;
mod new;
mod outdir;
mod progress;
mod readme;
mod report;
mod simulate;
mod sweep;
mod table;
mod trends;
mod wrong;

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    command::execute(&args::Args::parse())
}
