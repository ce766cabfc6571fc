//! Many seeds of one case, in cells that differ in noise, cut-off or anything else; parallel over runs,
//! resumable.
//!
//! ```text
//! spec text --cells--> one text per cell --> runs (cell, seed) on all cores --> journal --> statistics --> table
//!                                              +-- shard: only some of them        +-- merged: of all shards
//! ```

mod cells;
mod design;
mod journal;
mod merged;
pub(crate) mod shard;

pub(crate) use cells::{Axis, Cell, listed, product, vary};
pub(crate) use design::Design;
pub(crate) use journal::{Journal, Kept, NAME};
pub(crate) use merged::{Merged, merge, merged};
use shard::Shard;

use crate::args::Options;
use crate::interrupt;
use crate::progress::Progress;
use anyhow::{Result, anyhow};
use phisindy::Loaded;
use phisindy::files::{Purpose, Refusal, load_text};
use phisindy_learn::{LearnOptions, SweepRun, bound, project, sweep_one};
use phisindy_phys::{Case, Diagnostic, Origin, Sources};
use phisindy_report::sweep::{Found, NamedTruth, Run, RunVerdict, TermName};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// How often the bar moves and Ctrl-C is looked for.
const TICK: Duration = Duration::from_millis(100);

/// What to run.
pub(crate) struct Plan {
    /// Where data files are looked for.
    pub(crate) spec: PathBuf,
    /// Folders, method, threads.
    pub(crate) options: Options,
    /// Checked, in the order of the table.
    pub(crate) cells: Vec<Checked>,
    /// First seed.
    pub(crate) first: u64,
    /// How many.
    pub(crate) seeds: u64,
    /// The part that is done here; `None` for all.
    pub(crate) shard: Option<Shard>,
}

impl Plan {
    /// The seeds of a cell, by its place, that are done here.
    fn own(&self, cell: usize) -> impl Iterator<Item = u64> {
        let numbers = (0..self.seeds).filter(move |i| {
            let number = (cell as u64).wrapping_mul(self.seeds).wrapping_add(*i);
            self.shard.is_none_or(|shard| shard.holds(number))
        });
        numbers.map(|i| self.first + i)
    }

    /// What a journal says of it.
    pub(crate) fn design(&self, title: &str, method: phisindy_phys::spec::Method) -> Design {
        let cells = self.cells.iter().map(|c| (c.cell.label.as_str(), &c.truth));
        Design::new(title, method, (self.first, self.seeds), cells)
    }
}

/// A cell whose text makes sense.
pub(crate) struct Checked {
    /// The cell.
    pub(crate) cell: Cell,
    /// The truth in terms of its dictionary, or why there is none.
    pub(crate) truth: Result<NamedTruth, String>,
}

/// What came of it.
pub(crate) struct Outcome {
    /// For each cell its finished runs, by seed.
    pub(crate) runs: Vec<Vec<Run>>,
    /// Whether the user stopped it before the end.
    pub(crate) stopped: bool,
    /// How long this program worked on it.
    pub(crate) seconds: f64,
}

/// A term as results name it.
fn term_name(case: &Case, term: usize) -> TermName {
    let term = &case.system.terms[term];
    TermName { state: case.system.states[term.state].name.clone(), candidate: term.candidate.clone() }
}

impl Checked {
    /// Reads the text of a cell, makes its records once, and projects its truth. What there is to say goes to
    /// `found`.
    ///
    /// # Errors
    /// The text makes no sense, or its truth cannot be simulated.
    pub(crate) fn new(
        spec: &Path,
        cell: Cell,
        options: &Options,
        sources: &mut Sources,
        found: &mut Vec<Diagnostic>,
    ) -> Result<(Checked, Loaded), Refusal> {
        let loaded = load_text(spec, cell.text.clone(), &options.request(), Purpose::Run, sources, found)?;
        let truth = match (loaded.case.laws.first(), loaded.case.searches.first()) {
            (Some((_, law)), _) => Err(format!(
                "`unknown` names the law `{}`, and laws have no terms to count: `run` fits them, candidates can be swept",
                law.value
            )),
            (None, Some(_)) => Err(
                "`unknown` asks for a formula, which has no terms to count: `run` finds it, candidates can be swept"
                    .to_owned(),
            ),
            (None, None) => project(&loaded.case, &loaded.records).map_err(|e| e.to_string()),
        };
        let truth = truth.map(|truth| {
            let names = truth.terms.iter().map(|&t| term_name(&loaded.case, t)).collect();
            NamedTruth { truth, names }
        });
        Ok((Checked { cell, truth }, loaded))
    }
}

/// The seed of the first synthetic record.
pub(crate) fn seed_of(case: &Case) -> Option<u64> {
    case.records.iter().find_map(|plan| match &plan.origin {
        Origin::Synthetic(s) => Some(s.seed),
        Origin::Csv(_) => None,
    })
}

/// Does all runs that the journal does not hold yet.
///
/// Every worker is a thread pool of one, so that a run never waits for pieces of another one, and its numbers
/// cannot depend on how many there are.
///
/// # Errors
/// The journal cannot be written, or a worker died.
pub(crate) fn sweep(plan: &Arc<Plan>, journal: &mut Journal, title: &str) -> Result<Outcome> {
    let begin = Instant::now();
    let mut todo = Vec::new();
    for (k, checked) in plan.cells.iter().enumerate() {
        if checked.truth.is_ok() {
            todo.extend(
                plan.own(k).filter(|&seed| !journal.has(&checked.cell.label, seed)).map(|seed| (k, seed)),
            );
        }
    }
    let mut progress = Progress::new(title, plan.options.quiet);
    let total = todo.len();
    let todo = Arc::new(todo);
    let next = Arc::new(AtomicUsize::new(0));
    let (sender, receiver) = channel();
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let jobs = plan.options.jobs.unwrap_or(cores).min(total);
    let mut pools = Vec::new();
    for _ in 0..jobs {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(1)
            .build()
            .map_err(|e| anyhow!("cannot start a thread: {e}"))?;
        let (plan, todo, next, sender) = (plan.clone(), todo.clone(), next.clone(), sender.clone());
        pool.spawn(move || {
            while let Some(&(cell, seed)) = todo.get(next.fetch_add(1, Ordering::Relaxed)) {
                if interrupt::requested() || sender.send(one(&plan, cell, seed)).is_err() {
                    return;
                }
            }
        });
        pools.push(pool);
    }
    drop(sender);
    let mut done = 0;
    while done < total && !interrupt::requested() {
        match receiver.recv_timeout(TICK) {
            Ok(run) => {
                journal.push(run)?;
                done += 1;
                progress.at(done as f64 / total as f64);
            }
            Err(RecvTimeoutError::Timeout) => progress.at(done as f64 / total as f64),
            Err(RecvTimeoutError::Disconnected) if interrupt::requested() => break,
            Err(RecvTimeoutError::Disconnected) => {
                return Err(anyhow!(
                    "{} of {total} runs died; this is a mistake of the program",
                    total - done
                ));
            }
        }
    }
    // What was finished while Ctrl-C arrived is kept too.
    while let Ok(run) = receiver.try_recv() {
        journal.push(run)?;
        done += 1;
    }
    let own = |k: usize| plan.own(k).collect::<Vec<u64>>();
    let runs = plan.cells.iter().enumerate();
    let runs = runs.map(|(k, c)| journal.runs(&c.cell.label, &own(k))).collect();
    Ok(Outcome { runs, stopped: done < total, seconds: begin.elapsed().as_secs_f64() })
}

/// Does a run of a cell, by its place.
fn one(plan: &Plan, cell: usize, seed: u64) -> Run {
    let begin = Instant::now();
    let options = Options { seed: Some(seed), ..plan.options.clone() };
    let Checked { cell: Cell { label, text }, truth } = &plan.cells[cell];
    let (mut sources, mut found) = (Sources::default(), Vec::new());
    let loaded =
        load_text(&plan.spec, text.clone(), &options.request(), Purpose::Run, &mut sources, &mut found);
    let run = match (loaded, truth) {
        (Ok(loaded), Ok(NamedTruth { truth, .. })) => {
            let learn = LearnOptions { method: options.method.map(Into::into), ..Default::default() };
            let least = bound(&loaded.case, &loaded.records, &loaded.truths, truth);
            let one = sweep_one(&loaded.case, &loaded.records, truth, &learn);
            summary(one, least.unwrap_or_default())
        }
        _ => {
            let why = found.iter().find(|d| d.is_error()).map_or(String::new(), |d| d.message.clone());
            let terms = truth.as_ref().map_or(0, |named| named.truth.terms.len());
            Run { verdict: RunVerdict::Failed(why), found: vec![None; terms], ..Run::default() }
        }
    };
    Run { cell: label.clone(), seed, seconds: begin.elapsed().as_secs_f64(), ..run }
}

/// What the journal keeps of a run.
fn summary(run: SweepRun, bound: Vec<f64>) -> Run {
    let finite = |x: f64| x.is_finite().then_some(x);
    let verdict = match &run.outcome {
        Ok(found) => match found.verdict.reason() {
            None => RunVerdict::Identified,
            Some(why) => RunVerdict::Doubted(format!("{}: {why}", found.verdict.word())),
        },
        Err(why) => RunVerdict::Failed(why.to_string()),
    };
    let found = run.found.iter().map(|found| {
        let e = (*found)?;
        Some(Found { value: finite(e.value)?, low: finite(e.ci95.0), high: finite(e.ci95.1) })
    });
    Run {
        exact: run.exact,
        verdict,
        found: found.collect(),
        bound: bound.into_iter().map(finite).collect(),
        spurious: run.spurious,
        ..Run::default()
    }
}
