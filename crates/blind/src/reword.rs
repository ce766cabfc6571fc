//! `phisindy-blind reword`: an answer does not depend on how the question is put. Each case is asked as it is, and in
//! other words: verdict, terms and laws with their places, numbers and intervals must be the same.
//!
//! ```text
//! seed --cases--> Question: spec, tables --REWORDINGS--> the same in other words, and the way back
//!      --phisindy run, gap--> Answer --against--> agree? --tally--> table
//! ```

mod answer;
mod cases;
mod data;
mod format;
mod model;
mod order;
mod question;
mod rewording;
mod tally;

use crate::args::{Options, RewordArgs};
use crate::dice::Dice;
use crate::folder::Folder;
use crate::interrupt;
use crate::program::Program;
use crate::progress::Progress;
use crate::table::Table;
use answer::{Answer, Back};
use anyhow::{Result, bail};
use question::Question;
use rayon::prelude::*;
use rewording::{REWORDINGS, Reworded, Rewording};
use std::fs;
use std::path::Path;
use std::time::Duration;
use tally::{Outcome, tally};

/// What a case may take, in seconds: more is for a sweep of its own.
const LIMIT: u64 = 60;

/// The table, and a line for each disagreement; none if the user stopped it.
///
/// # Errors
/// There is no such rewording, files cannot be written, or the program cannot be started.
pub(crate) fn table(args: &RewordArgs, options: &Options) -> Result<Option<Table>> {
    let program = Program::find(options)?;
    let asked = |row: &&Rewording| args.kind.as_ref().is_none_or(|kind| *kind == row.name);
    let rows: Vec<&Rewording> = REWORDINGS.iter().filter(asked).collect();
    if rows.is_empty() {
        let names: Vec<&str> = REWORDINGS.iter().map(|row| row.name).collect();
        bail!("there is no such rewording; there is: {}", names.join(", "));
    }
    let temporary = std::env::temp_dir().join(format!("phisindy-reword-{}", std::process::id()));
    let progress = Progress::new("reword", args.runs, options.quiet);
    let all: Vec<Vec<Outcome>> = (0..args.runs)
        .into_par_iter()
        .filter(|index| args.only.is_none_or(|only| only == *index))
        .map(|index| {
            let folder = temporary.join(index.to_string());
            let outcomes = case(args, &program, &rows, index, &folder)?;
            if let Some(kept) = &args.out
                && (args.only.is_some() || outcomes.iter().any(|o| o.disagrees.is_some()))
            {
                crate::folder::copy(&folder, &kept.join(index.to_string()))?;
            }
            // What is left behind in a temporary folder does no harm.
            let _ = fs::remove_dir_all(&folder);
            progress.step();
            Ok(outcomes)
        })
        .collect::<Result<_>>()?;
    drop(progress);
    let _ = fs::remove_dir_all(&temporary);
    Ok((!interrupt::requested()).then(|| tally(&rows, &all.concat())))
}

/// One case in all words; empty if it has no answer, or the user stopped it.
fn case(
    args: &RewordArgs,
    program: &Program,
    rows: &[&Rewording],
    index: usize,
    folder: &Path,
) -> Result<Vec<Outcome>> {
    let Some(question) = cases::drawn(args, program, index, &folder.join("drawn"))? else {
        return Ok(vec![]);
    };
    let Some(spec) = question.read() else { bail!("case {index} cannot be read") };
    let Some(first) = ask(program, &question, &Back::default(), &folder.join("first"))? else {
        return Ok(vec![]);
    };
    let mut outcomes = Vec::new();
    for row in rows {
        let mut dice = Dice::new(args.seed, &format!("reword {index} {}", row.name));
        let reworded = (row.of)(question.clone(), &spec, &mut dice);
        let Some(Reworded { question: again, back }) = reworded.filter(|_| first.told()) else { continue };
        let Some(second) = ask(program, &again, &back, &folder.join(row.name.replace('/', " per ")))? else {
            continue;
        };
        let disagrees = first.against(&second, row.agree);
        outcomes.push(Outcome { index, command: question.command, kind: row.name, disagrees });
    }
    Ok(outcomes)
}

/// The answer; none if there is none in time, or the user stopped it.
fn ask(program: &Program, question: &Question, back: &Back, folder: &Path) -> Result<Option<Answer>> {
    let folder = Folder::create(folder)?;
    question.write(&folder)?;
    let mut command = program.command();
    command
        .arg(question.command)
        .arg(folder.path().join(question::SPEC))
        .args(["--format", "json", "--quiet"]);
    command.args(["--jobs", "1", "--limit", &format!("{LIMIT}s")]);
    let said = program.output(&mut command, Some(Duration::from_secs(2 * LIMIT)))?;
    // What a limit stopped is no answer.
    let whole = said.filter(|said| said.status.is_some() && said.seconds < LIMIT as f64);
    Ok(whole.map(|said| Answer::of(&said, back)))
}
