//! `phisindy-blind odd`: valid specs and data in odd spellings, whose truth is known, and the same damaged. The program
//! may refuse what is damaged; it may not panic, hang, end with another exit code, or be wrong about what is valid.
//!
//! ```text
//! seed --Rig::draw--> rig --Written--> spec, data, law --damage (some)--> phisindy COMMAND --judged--> tally
//! ```

mod damage;
mod rig;
mod tally;
mod written;

use crate::args::{OddArgs, Options};
use crate::dice::Dice;
use crate::interrupt;
use crate::program::{Output, Program};
use crate::progress::Progress;
use crate::table::Table;
use anyhow::{Context, Result, bail};
use rayon::prelude::*;
use rig::Rig;
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::time::Duration;
use tally::{Outcome, tally};
use written::Written;

/// What the program is told to keep, in seconds ...
const LIMIT: u64 = 5;
/// ... and what is a hang: a machine with other work to do is slow.
const HANG: Duration = Duration::from_secs(60);
/// Commands, and how often each comes in 1000 executions: what costs more comes less often.
const COMMANDS: &[(Command, usize)] = &[
    (Command::Check, 680),
    (Command::Simulate, 200),
    (Command::New, 98),
    (Command::Run, 18),
    (Command::Law, 1),
    (Command::Gap, 1),
    (Command::Journal, 2),
];
/// The part of the inputs that is damaged.
const DAMAGED: f64 = 0.4;

/// What is asked of the program.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Command {
    Check,
    Simulate,
    New,
    Run,
    /// `gap` of a model that lacks friction.
    Gap,
    /// `gap` with a random law beside the catalogue.
    Law,
    /// `sweep` that goes on from a damaged journal.
    Journal,
}

impl Command {
    fn word(self) -> &'static str {
        match self {
            Command::Check => "check",
            Command::Simulate => "simulate",
            Command::New => "new",
            Command::Run => "run",
            Command::Gap | Command::Law => "gap",
            Command::Journal => "sweep",
        }
    }

    fn drawn(dice: &mut Dice) -> Command {
        let mut at = dice.whole(0, COMMANDS.iter().map(|(_, weight)| weight).sum::<usize>() - 1);
        let found = COMMANDS.iter().find(|(_, weight)| {
            let here = at < *weight;
            at = at.saturating_sub(*weight);
            here
        });
        found.map_or(Command::Check, |(command, _)| *command)
    }
}

/// The table, and a line for each failure; none if the user stopped it.
///
/// # Errors
/// Files cannot be written, the program cannot be started, or an execution panicked, hung, or ended otherwise than
/// the reference says.
pub(crate) fn table(args: &OddArgs, options: &Options) -> Result<Option<Table>> {
    let program = Program::find(options)?;
    let temporary = std::env::temp_dir().join(format!("phisindy-odd-{}", std::process::id()));
    let progress = Progress::new("odd", args.runs, options.quiet);
    let all: Vec<Outcome> = (0..args.runs)
        .into_par_iter()
        .filter(|index| args.only.is_none_or(|only| only == *index))
        .map(|index| {
            let folder = temporary.join(index.to_string());
            let outcome = execution(&program, args.seed, index, &folder)?;
            if let (Some(outcome), Some(kept)) = (&outcome, &args.out)
                && (outcome.failed() || outcome.wrong.is_some() || args.only.is_some())
            {
                crate::folder::copy(&folder, &kept.join(index.to_string()))?;
            }
            // What is left behind in a temporary folder does no harm.
            let _ = fs::remove_dir_all(&folder);
            progress.step();
            Ok(outcome)
        })
        .collect::<Result<Vec<_>>>()?
        .into_iter()
        .flatten()
        .collect();
    drop(progress);
    let _ = fs::remove_dir_all(&temporary);
    if interrupt::requested() {
        return Ok(None);
    }
    let made = tally(&all);
    let failed = all.iter().filter(|o| o.failed()).count();
    if failed > 0 {
        crate::folder::print(&format!("{}\n{}", made.table, made.failures))?;
        bail!("{failed} of {} executions panicked, hung or ended with another exit code", all.len());
    }
    Ok(Some(made))
}

/// One execution; none if the user stopped it.
fn execution(program: &Program, seed: u64, index: usize, folder: &Path) -> Result<Option<Outcome>> {
    if interrupt::requested() {
        return Ok(None);
    }
    let mut dice = Dice::new(seed, &format!("odd {index}"));
    let command = Command::drawn(&mut dice);
    let rig = Rig::draw(&mut dice);
    let synthetic = matches!(command, Command::Simulate | Command::Journal) || dice.chance(0.3);
    let mut written = Written::new(&rig, synthetic, command != Command::Simulate, &mut dice);
    if command == Command::Law {
        written.files.push(("laws/odd.ron".to_owned(), written::law(&mut dice).into_bytes()));
    }
    if matches!(command, Command::Gap | Command::Law) {
        written.believed_complete();
    }
    let damaged = command != Command::Journal && dice.chance(DAMAGED);
    if damaged {
        let which = dice.whole(0, written.files.len() - 1);
        written.files[which].1 = damage::damaged(&written.files[which].1, &mut dice);
    }
    for (name, content) in &written.files {
        let path = folder.join(name);
        fs::create_dir_all(path.parent().unwrap_or(folder))
            .and_then(|()| fs::write(&path, content))
            .with_context(|| format!("cannot write `{}`", path.display()))?;
    }
    let mut words: Vec<String> = match command {
        Command::New => vec!["new".to_owned(), folder.join(written::DATA).display().to_string()],
        _ => vec![command.word().to_owned(), folder.join(written::SPEC).display().to_string()],
    };
    if command == Command::Journal {
        words.extend(["--seeds", "2", "--out"].map(str::to_owned));
        words.push(folder.join("sweep").display().to_string());
        if ask(program, &words)?.is_none() {
            return Ok(None);
        }
        let journal = folder.join("sweep/sweep.jsonl");
        // A sweep of records that cannot be fitted leaves none.
        if let Ok(text) = fs::read(&journal) {
            fs::write(&journal, damage::damaged(&text, &mut dice)).context("cannot write the journal")?;
        }
    } else {
        if matches!(command.word(), "run" | "gap" | "sweep") {
            words.extend(["--format", "json"].map(str::to_owned));
        }
        words.extend(dice.chance(0.5).then(|| "--quiet".to_owned()));
    }
    let Some(said) = ask(program, &words)? else { return Ok(None) };
    let wrong = if damaged { None } else { judged(command, &rig, &written, &said) };
    let panicked = said.err.contains("panicked at");
    let code = said.status.and_then(|status| status.code());
    let hung = said.status.is_none();
    Ok(Some(Outcome {
        index,
        command: command.word(),
        damaged,
        code,
        hung,
        panicked,
        wrong,
        seconds: said.seconds,
    }))
}

/// Runs the program on one thread; none if the user stopped it. A machine with other work to do stalls now and then: what
/// hangs, hangs every time.
fn ask(program: &Program, words: &[String]) -> Result<Option<Output>> {
    let limit = format!("{LIMIT}s");
    let mut last = None;
    for _ in 0..3 {
        let mut command = program.command();
        command.args(words).args(["--limit", &limit]);
        if words[0] != "new" {
            command.args(["--jobs", "1"]);
        }
        last = program.output(&mut command, Some(HANG))?;
        if last.as_ref().is_none_or(|said| said.status.is_some()) {
            break;
        }
    }
    Ok(last)
}

/// What is wrong about an answer to a valid question, if anything is.
fn judged(command: Command, rig: &Rig, written: &Written, said: &Output) -> Option<String> {
    let code = said.status.and_then(|status| status.code())?;
    let first = || said.err.lines().find(|l| l.starts_with("error")).unwrap_or_default().to_owned();
    if code == 2 && command != Command::Journal {
        return Some(format!("refused: {}", first()));
    }
    let answer = || serde_json::from_str::<Value>(&said.out).ok();
    match command {
        Command::Simulate if code == 0 => written.simulated(rig, &said.out),
        Command::Simulate => Some(format!("exit code {code}: {}", first())),
        Command::Run => {
            let answer = answer()?;
            let terms = answer["equations"].as_array()?.iter().flat_map(|e| e["terms"].as_array()).flatten();
            let level = terms.filter(|t| t["candidate"] == "1").find_map(|t| {
                Some((t["coefficient"].as_f64()?, t["ci95"][0].as_f64()?, t["ci95"][1].as_f64()?))
            });
            let doubted = answer["verdict"] != "identified"
                || answer["warnings"].as_array().is_some_and(|w| !w.is_empty());
            let off = level.map_or(f64::INFINITY, |(found, low, high)| {
                // Rounded readings are no normal noise: a hundredth is near enough.
                (found - rig.friction).abs() / (0.5 * (high - low)).max(0.01 * rig.friction)
            });
            (!doubted && off > 4.0)
                .then(|| format!("identified without a warning, off by {off:.1} half widths"))
        }
        Command::Gap => {
            let answer = answer()?;
            (answer["status"] == "nothing-missing")
                .then(|| "nothing is missing, it says; friction is".to_owned())
        }
        Command::Check | Command::New | Command::Law | Command::Journal => None,
    }
}
