//! The journals of shards as one sweep.

use super::design::Design;
use super::journal::{Journal, Kept};
use anyhow::{Context, Result, bail};
use phisindy_report::sweep::Run;
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

/// Merges all journals in some folders.
///
/// # Errors
/// A folder without a journal, journals of different sweeps, or two different results of one run.
pub(crate) fn merged(folders: &[PathBuf]) -> Result<Merged> {
    let mut first: Option<(PathBuf, Kept)> = None;
    let mut all: HashMap<(String, u64), Run> = HashMap::new();
    for path in folders.iter().map(|f| journals(f)).collect::<Result<Vec<_>>>()?.into_iter().flatten() {
        let mut kept = Journal::read(&path)?;
        for run in std::mem::take(&mut kept.runs) {
            let (cell, seed) = (run.cell.clone(), run.seed);
            let timeless = |run: &Run| Run { seconds: 0.0, ..run.clone() };
            if let Some(other) = all.insert((cell.clone(), seed), run.clone())
                && timeless(&other) != timeless(&run)
            {
                bail!(
                    "`{}` has another result for seed {seed}{} than a journal before it: they are not of one program",
                    path.display(),
                    if cell.is_empty() { cell } else { format!(" of {cell}") }
                );
            }
        }
        match &first {
            None => first = Some((path, kept)),
            Some((other, one)) if one.fingerprint != kept.fingerprint || one.design != kept.design => bail!(
                "`{}` and `{}` are not of one sweep: the spec, --seeds, --noise, --cutoffs, --vary, --set, the method or the program differ",
                other.display(),
                path.display()
            ),
            Some(_) => {}
        }
    }
    let Some((_, Kept { spec, design, .. })) = first else { bail!("--merge names no folder") };
    let seeds = || (0..design.seeds).map(|i| design.first.wrapping_add(i));
    let mut missing = 0;
    let mut runs = Vec::new();
    for (label, truth) in design.cells() {
        let own: Vec<Run> = seeds().filter_map(|seed| all.get(&(label.clone(), seed)).cloned()).collect();
        missing += if truth.is_ok() { design.seeds - own.len() as u64 } else { 0 };
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
