//! Runs the workflow on every set of a folder and compares. What is finished is kept, so that the same command goes on after an interruption.

use super::mark::mark;
use super::tally::{Marked, failures, tables};
use super::truth::Truth;
use crate::args::Options;
use crate::interrupt;
use crate::outdir::OutDir;
use crate::progress::Progress;
use anyhow::{Context, Result, bail};
use serde_json::{Value, json};
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// How often Ctrl-C is looked for.
const TICK: Duration = Duration::from_millis(20);
/// Longer than this and the set has failed.
const PATIENCE: Duration = Duration::from_secs(600);

/// The tables and the list of failures.
pub(crate) struct Score {
    pub(crate) tables: String,
    pub(crate) failures: String,
}

/// Runs what has no result yet, and compares all; none if the user stopped it.
///
/// # Errors
/// The folder holds no sets, or its files cannot be read or written.
pub(super) fn score(folder: &Path, options: &Options, again: bool) -> Result<Option<Score>> {
    let sets = sets(folder)?;
    if sets.is_empty() {
        bail!(
            "there are no sets in `{}`; make some with `phisindy table hidden --out {0}`",
            folder.display()
        );
    }
    let mut progress = Progress::new("score", options.quiet);
    let mut all = Vec::new();
    for (k, set) in sets.iter().enumerate() {
        let truth = set.join("truth.json");
        let text =
            std::fs::read_to_string(&truth).with_context(|| format!("cannot read `{}`", truth.display()))?;
        let truth: Truth =
            serde_json::from_str(&text).with_context(|| format!("`{}` is no truth", truth.display()))?;
        let kept = set.join("result.json");
        if again || !kept.exists() {
            let Some(result) = run(set, options)? else { return Ok(None) };
            OutDir::create(set)?.write("result.json", &(serde_json::to_string_pretty(&result)? + "\n"))?;
        }
        let text =
            std::fs::read_to_string(&kept).with_context(|| format!("cannot read `{}`", kept.display()))?;
        let result: Value = serde_json::from_str(&text)
            .with_context(|| format!("`{}` is damaged; delete it to run its set again", kept.display()))?;
        let name = set.file_name().map_or(String::new(), |n| n.to_string_lossy().into_owned());
        all.push(Marked { set: name, mark: mark(&truth, &result), truth });
        progress.at((k + 1) as f64 / sets.len() as f64);
    }
    Ok(Some(Score { tables: tables(&all), failures: failures(&all) }))
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

/// Runs the workflow on a set as a user does; what it has to say on the way is in `gap.log`. None if the user stopped it.
fn run(set: &Path, options: &Options) -> Result<Option<Value>> {
    let (out, log) = (set.join(".gap.out"), set.join("gap.log"));
    let file = |path: &Path| File::create(path).with_context(|| format!("cannot write `{}`", path.display()));
    let mut command = Command::new(std::env::current_exe().context("cannot find this program")?);
    command.arg("gap").arg(set.join("spec.ron")).args(["--format", "json", "--quiet"]);
    if let Some(jobs) = options.jobs {
        command.args(["--jobs", &jobs.to_string()]);
    }
    // The data are beside the spec and nowhere else.
    command.arg("--data").arg(set).env_remove("PHISINDY_DATA");
    let begin = Instant::now();
    let mut child = command
        .stdin(Stdio::null())
        .stdout(file(&out)?)
        .stderr(file(&log)?)
        .spawn()
        .context("cannot start this program")?;
    let status = loop {
        if let Some(status) = child.try_wait().context("cannot wait for the workflow")? {
            break Some(status);
        }
        if interrupt::asked() || begin.elapsed() > PATIENCE {
            // It may have ended just now.
            let _ = child.kill();
            let _ = child.wait();
            break None;
        }
        std::thread::sleep(TICK);
    };
    let text = std::fs::read_to_string(&out).unwrap_or_default();
    let _ = std::fs::remove_file(&out);
    if interrupt::asked() {
        return Ok(None);
    }
    let seconds = begin.elapsed().as_secs_f64();
    let said = std::fs::read_to_string(&log).unwrap_or_default();
    // Nothing to say is no file worth keeping.
    if said.trim().is_empty() {
        let _ = std::fs::remove_file(&log);
    }
    let failed = |why: &str| json!({ "status": "failed", "error": why, "log": said, "seconds": seconds });
    Ok(Some(match status {
        None => failed("it took too long"),
        Some(status) => serde_json::from_str(&text)
            .unwrap_or_else(|_| failed(&format!("it printed no JSON and ended with {status}"))),
    }))
}
