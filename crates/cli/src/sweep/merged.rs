//! The journals of shards as one sweep.

use super::design::Design;
use super::journal::{Journal, Kept};
use anyhow::{Context, Result, bail};
use phisindy_report::sweep::{CellRuns, NamedTruth, Run, SweepRuns};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// A sweep whose runs come from many journals.
pub(crate) struct Merged {
    /// Name of the spec.
    pub(crate) spec: String,
    /// The whole sweep.
    pub(crate) design: Design,
    /// For each cell its finished runs, by seed.
    pub(crate) runs: Vec<Vec<Run>>,
    /// How many runs are in no journal.
    pub(crate) missing: u64,
}

impl Merged {
    /// What a table shows; the cells are those of the design.
    pub(crate) fn table<'a>(&'a self, cells: &'a [(String, Result<NamedTruth, String>)]) -> SweepRuns<'a> {
        let rows = cells.iter().zip(&self.runs);
        SweepRuns {
            spec: &self.spec,
            title: self.design.title(),
            method: self.design.method(),
            first: self.design.first,
            seeds: self.design.seeds,
            cells: rows.map(|((label, truth), runs)| CellRuns { label, truth, runs }).collect(),
            stopped: self.missing > 0,
            seconds: self.runs.iter().flatten().map(|run| run.seconds).sum(),
        }
    }
}

/// Merges all journals in some folders.
///
/// # Errors
/// A folder without a journal, journals of different sweeps, or two different results of one run.
pub(crate) fn merged(folders: &[PathBuf]) -> Result<Merged> {
    let paths = folders.iter().map(|f| journals(f)).collect::<Result<Vec<_>>>()?.into_iter().flatten();
    merge(paths.map(|path| Ok((path.display().to_string(), Journal::read(&path)?))))
}

/// Merges journals, each with its name.
///
/// # Errors
/// As [`merged`].
pub(crate) fn merge(journals: impl Iterator<Item = Result<(String, Kept)>>) -> Result<Merged> {
    let mut first: Option<(String, Kept)> = None;
    let mut all: HashMap<(String, u64), Run> = HashMap::new();
    for journal in journals {
        let (shown, mut kept) = journal?;
        for run in std::mem::take(&mut kept.runs) {
            let (cell, seed) = (run.cell.clone(), run.seed);
            let timeless = |run: &Run| Run { seconds: 0.0, ..run.clone() };
            if let Some(other) = all.insert((cell.clone(), seed), run.clone())
                && timeless(&other) != timeless(&run)
            {
                bail!(
                    "`{shown}` has another result for seed {seed}{} than a journal before it: they are not of one program",
                    if cell.is_empty() { cell } else { format!(" of {cell}") }
                );
            }
        }
        match &first {
            None => first = Some((shown, kept)),
            Some((other, one)) if one.fingerprint != kept.fingerprint || one.design != kept.design => bail!(
                "`{other}` and `{shown}` are not of one sweep: the spec, --seeds, --noise, --cutoffs, --vary, --set, the method or the program differ"
            ),
            Some(_) => {}
        }
    }
    let Some((_, Kept { spec, design, .. })) = first else { bail!("--merge names no folder") };
    let mut missing = 0_u64;
    let mut runs = Vec::new();
    // Sorted by seed; a design may ask for more seeds than anybody counts.
    let mut all: Vec<Run> = all.into_values().filter(|run| design.holds(run.seed)).collect();
    all.sort_by_key(|run| run.seed);
    for (label, truth) in design.cells() {
        let own: Vec<Run> = all.iter().filter(|run| run.cell == label).cloned().collect();
        let lacking = design.seeds.saturating_sub(own.len() as u64);
        missing = missing.saturating_add(if truth.is_ok() { lacking } else { 0 });
        runs.push(own);
    }
    Ok(Merged { spec, design, runs, missing })
}

/// The journals in a folder, by name.
fn journals(folder: &Path) -> Result<Vec<PathBuf>> {
    let shown = folder.display();
    let entries = std::fs::read_dir(folder).with_context(|| format!("cannot read the folder `{shown}`"))?;
    let paths: Vec<PathBuf> = entries
        .map(|e| Ok(e?.path()))
        .collect::<std::io::Result<_>>()
        .with_context(|| format!("cannot read the folder `{shown}`"))?;
    let ours = |path: &PathBuf| {
        let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        name.starts_with("sweep") && name.ends_with(".jsonl")
    };
    let mut found: Vec<PathBuf> = paths.into_iter().filter(ours).collect();
    found.sort();
    if found.is_empty() {
        bail!(
            "`{shown}` holds no journal of a sweep: give the folder of --out of `phisindy sweep SPEC --shard 1/2 --out DIR`"
        );
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = r#"{"journal":"phisindy sweep","spec":"a.ron","version":"1","fingerprint":"0","design":{"title":"","step":false,"first":7,"seeds":2,"cells":[{"label":"","names":[{"state":"y","candidate":"1"}],"coefficients":[0.5]}]}}"#;
    const RUN: &str = r#"{"cell":"","seed":7,"exact":true,"verdict":"identified","found":[{"value":0.5,"low":0.4,"high":null}],"bound":[0.1],"spurious":[],"seconds":1.0}"#;

    /// The finished and the missing runs of a journal, and its table.
    fn of(header: &str, run: &str) -> Result<(usize, u64, String)> {
        let merged = merge(std::iter::once(
            Kept::of(format!("{header}\n{run}\n").as_bytes(), "j").map(|kept| ("j".into(), kept)),
        ))?;
        let cells = merged.design.cells();
        let table = merged.table(&cells).written(phisindy_report::Format::Text);
        Ok((merged.runs[0].len(), merged.missing, table))
    }

    #[test]
    fn a_design_that_makes_no_sense_is_refused() {
        assert_eq!(of(HEADER, RUN).map(|(runs, missing, _)| (runs, missing)).expect("a journal"), (1, 1));
        for (from, to) in [
            ("\"coefficients\":[0.5]", "\"coefficients\":[]"),
            ("\"seeds\":2", "\"seeds\":0"),
            ("\"seeds\":2", "\"seeds\":18446744073709551615"),
        ] {
            assert!(HEADER.contains(from));
            let said = of(&HEADER.replace(from, to), RUN).expect_err(to).to_string();
            assert!(said.contains("damaged"), "{said}");
        }
    }

    #[test]
    fn runs_that_are_not_there_take_no_time() {
        let all =
            of(&HEADER.replace("\"seeds\":2", "\"seeds\":18446744073709551608"), RUN).expect("a journal");
        assert_eq!((all.0, all.1), (1, 18_446_744_073_709_551_607));
    }

    #[test]
    fn a_run_with_a_damaged_key_is_not_believed() {
        for (from, to) in
            [("\"low\"", "\"lox\""), ("\"low\":0.4,", ""), ("\"seconds\"", "\"x\":1,\"seconds\"")]
        {
            assert!(RUN.contains(from));
            let said = of(HEADER, &RUN.replace(from, to)).expect_err(to).to_string();
            assert!(said.contains("line 2") && said.contains("damaged"), "{said}");
        }
    }
}
