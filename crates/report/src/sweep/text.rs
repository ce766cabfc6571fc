//! The result of a sweep for people.

use super::runs::{CellRuns, Run, RunVerdict, SweepRuns};
use super::statistics::Statistics;
use crate::table::{aligned, short};

/// Most failed runs that are listed; the JSON has all.
const LISTED: usize = 20;

fn word(x: Option<f64>) -> String {
    x.map_or("-".to_owned(), short)
}

/// A fraction in per cent.
fn percent(x: Option<f64>) -> String {
    x.map_or("-".to_owned(), |x| format!("{} %", short(100.0 * x)))
}

fn words(words: &[&str]) -> Vec<String> {
    words.iter().map(|w| (*w).to_owned()).collect()
}

/// The table as lines. It depends only on the runs, not on their duration.
pub(super) fn table(sweep: &SweepRuns<'_>) -> Vec<String> {
    let (first, last) = (sweep.first, sweep.first.wrapping_add(sweep.seeds - 1));
    let name = if sweep.title.is_empty() {
        sweep.spec.to_owned()
    } else {
        format!("{} ({})", sweep.title, sweep.spec)
    };
    let mut lines = vec![name, format!("method {}, seeds {first} to {last}", sweep.method.name())];
    let all = sweep.statistics();
    if all.len() > 1 {
        let mut rows = vec![words(&[
            "cell",
            "runs",
            "exact support",
            "worst median error",
            "worst rmse/bound",
            "least coverage",
            "most",
        ])];
        for (checked, cell) in sweep.cells.iter().zip(&all) {
            let mut row = vec![label(checked)];
            match cell {
                Ok(s) => row.extend([
                    s.runs.to_string(),
                    s.exact.to_string(),
                    percent(s.worst_median()),
                    word(s.worst_ratio()),
                    percent(s.coverage().map(|c| c.0)),
                    percent(s.coverage().map(|c| c.1)),
                ]),
                Err(why) => row.push(why.clone()),
            }
            rows.push(row);
        }
        lines.push(String::new());
        lines.extend(aligned(&rows));
    }
    for (checked, cell) in sweep.cells.iter().zip(&all) {
        lines.push(String::new());
        if all.len() > 1 {
            lines.push(format!("{}:", label(checked)));
        }
        match cell {
            Ok(statistics) => lines.extend(block(checked, statistics)),
            Err(why) => lines.push(why.clone()),
        }
    }
    lines
}

fn label(checked: &CellRuns<'_>) -> String {
    if checked.label.is_empty() { "as in the spec".to_owned() } else { checked.label.to_owned() }
}

/// One cell.
fn block(checked: &CellRuns<'_>, statistics: &Statistics) -> Vec<String> {
    let mut lines =
        vec![format!("exactly the true terms in {} of {} runs", statistics.exact, statistics.runs)];
    let mut rows = vec![words(&[
        "equation",
        "candidate",
        "truth",
        "found in",
        "median",
        "rmse",
        "bound",
        "rmse/bound",
        "95 % interval covers",
    ])];
    for c in &statistics.coefficients {
        rows.push(vec![
            c.name.state.clone(),
            c.name.candidate.clone(),
            short(c.truth),
            c.found.to_string(),
            word(c.median),
            word(c.rmse),
            word(c.bound),
            word(c.rmse.zip(c.bound).map(|(e, b)| e / b)),
            percent(c.coverage),
        ]);
    }
    lines.extend(aligned(&rows));
    let failed: Vec<&Run> = checked.runs.iter().filter(|r| !r.exact).collect();
    lines.extend(failed.iter().take(LISTED).map(|run| format!("seed {}: {}", run.seed, brief(checked, run))));
    if failed.len() > LISTED {
        lines.push(format!("and {} more", failed.len() - LISTED));
    }
    lines
}

/// Why a run is not exact, in words.
fn brief(checked: &CellRuns<'_>, run: &Run) -> String {
    if matches!(run.verdict, RunVerdict::Failed(_)) {
        return run.verdict.to_string();
    }
    let mut parts = Vec::new();
    if !run.spurious.is_empty() {
        parts.push(format!("spurious {}", run.spurious.join(", ")));
    }
    let missing = checked.missing(run);
    if !missing.is_empty() {
        parts.push(format!("missing {}", missing.join(", ")));
    }
    if run.verdict != RunVerdict::Identified {
        parts.push(run.verdict.to_string());
    }
    parts.join("; ")
}
