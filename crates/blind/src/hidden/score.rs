//! Runs the workflow on every set of a folder and compares. Finished sets keep their results, so the same
//! command continues after an interruption.

use super::mark::mark;
use super::tally::{Marked, failures, tables};
use super::truth::Truth;
use crate::args::{Options, ScoreArgs};
use crate::folder::Folder;
use crate::interrupt;
use crate::program::Program;
use crate::progress::Progress;
use crate::table::Table;
use anyhow::{Context, Result, bail};
use rayon::prelude::*;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// A set that takes longer has failed.
pub(super) const PATIENCE: Duration = Duration::from_secs(1200);

/// Runs the sets without a result and compares all; none if the user stopped it.
///
/// # Errors
/// The folder holds no sets, or its files cannot be read or written.
pub(super) fn score(args: &ScoreArgs, options: &Options) -> Result<Option<Table>> {
    let sets = sets(&args.out)?;
    if sets.is_empty() {
        bail!(
            "there are no sets in `{}`; make some with `phisindy-blind hidden --out {0}`",
            args.out.display()
        );
    }
    let progress = Progress::new("score", sets.len(), options.quiet);
    let all: Vec<Option<Marked>> = sets
        .par_iter()
        .map(|set| {
            let marked = marked(set, options, args.again)?;
            progress.step();
            Ok(marked)
        })
        .collect::<Result<_>>()?;
    drop(progress);
    let all: Option<Vec<Marked>> = all.into_iter().collect();
    Ok(all.map(|all| Table { name: "score", table: tables(&all), failures: failures(&all) }))
}

/// A set with its marks; none if the user stopped it.
fn marked(set: &Path, options: &Options, again: bool) -> Result<Option<Marked>> {
    let truth: Truth = read(&set.join("truth.json"), "is no truth")?;
    let kept = set.join("result.json");
    if again || !kept.exists() {
        if interrupt::requested() {
            return Ok(None);
        }
        let Some(result) = run(set, &Program::find(options)?, &[], 1, PATIENCE)? else { return Ok(None) };
        Folder::create(set)?.write("result.json", &(serde_json::to_string_pretty(&result)? + "\n"))?;
    }
    let result: Value = read(&kept, "is damaged; delete it to run its set again")?;
    let name = set.file_name().map_or(String::new(), |n| n.to_string_lossy().into_owned());
    Ok(Some(Marked { set: name, mark: mark(&truth, &result), truth }))
}

pub(super) fn read<T: serde::de::DeserializeOwned>(path: &Path, damaged: &str) -> Result<T> {
    let shown = path.display();
    let text = std::fs::read_to_string(path).with_context(|| format!("cannot read `{shown}`"))?;
    serde_json::from_str(&text).with_context(|| format!("`{shown}` {damaged}"))
}

/// Folders with a truth, in order.
fn sets(folder: &Path) -> Result<Vec<PathBuf>> {
    let entries = std::fs::read_dir(folder).with_context(|| format!("cannot read `{}`", folder.display()))?;
    let mut all = Vec::new();
    for entry in entries {
        let path = entry.with_context(|| format!("cannot read `{}`", folder.display()))?.path();
        if path.join("truth.json").is_file() {
            all.push(path);
        }
    }
    all.sort();
    Ok(all)
}

/// Runs the workflow on a set as a user does, without some laws, with its messages in `gap.log`. None if the
/// user stopped it.
pub(super) fn run(
    set: &Path,
    program: &Program,
    without: &[&str],
    threads: u16,
    patience: Duration,
) -> Result<Option<Value>> {
    let log = set.join("gap.log");
    let mut command = program.command();
    command.arg("gap").arg(set.join("spec.ron")).args(["--format", "json", "--quiet", "--jobs"]);
    command.arg(threads.to_string());
    for law in without {
        command.args(["--without", law]);
    }
    // The data are only beside the spec.
    command.arg("--data").arg(set);
    let Some(output) = program.output(&mut command, Some(patience))? else { return Ok(None) };
    // No messages, no file.
    if output.err.trim().is_empty() {
        let _ = std::fs::remove_file(&log);
    } else {
        std::fs::write(&log, &output.err).with_context(|| format!("cannot write `{}`", log.display()))?;
    }
    let failed =
        |why: &str| json!({ "status": "failed", "error": why, "log": output.err, "seconds": output.seconds });
    Ok(Some(match output.status {
        None => failed("it took too long"),
        Some(status) => match serde_json::from_str::<Value>(&output.out) {
            Ok(mut result) => {
                result["exit"] = json!(status.code());
                result
            }
            Err(_) => failed(&format!("it printed no JSON and ended with {status}")),
        },
    }))
}
