//! Specs with synthetic data, loaded without any file but the spec: what the truth is, in the program's own
//! terms.

use crate::args::Assignment;
use anyhow::{Context, Result, anyhow};
use phisindy_phys::{Case, Diagnostic, Origin, Record, SourceId, check, spec, splice};
use phisindy_sim::{Trajectory, synthesize};
use std::path::Path;

/// A case with its records.
pub(crate) struct Loaded {
    /// The spec.
    pub(crate) text: String,
    /// What it says.
    pub(crate) case: Case,
    /// In the order of the spec.
    pub(crate) records: Vec<Record>,
    /// For each record, what it would be without noise.
    pub(crate) truths: Vec<Trajectory>,
}

/// Reads a spec file, with some fields changed.
///
/// # Errors
/// It cannot be read, or [`load`] refuses it.
pub(crate) fn load_file(path: &Path, sets: &[Assignment], seed: Option<u64>) -> Result<Loaded> {
    let shown = path.display();
    let mut text =
        std::fs::read_to_string(path).with_context(|| format!("cannot read the spec `{shown}`"))?;
    for set in sets {
        text = splice::set(&text, &set.path, &set.value)
            .with_context(|| format!("{}={}", set.path, set.value))?;
    }
    load(text, seed).map_err(|why| anyhow!("{why}")).with_context(|| format!("the table needs `{shown}`"))
}

/// Makes the records of a spec. `seed` replaces that of the first record; the others have seeds that follow
/// from it, as with the program's `--seed`.
///
/// # Errors
/// In words: the text is no spec, or its data are not all synthetic, or a truth cannot be simulated.
pub(crate) fn load(text: String, seed: Option<u64>) -> Result<Loaded, String> {
    let case = checked(&text)?;
    let (mut records, mut truths) = (Vec::new(), Vec::new());
    for (index, plan) in case.records.iter().enumerate() {
        let Origin::Synthetic(truth) = &plan.origin else {
            return Err(format!(
                "record `{}` is measured, and this table is about synthetic data",
                plan.name
            ));
        };
        let seed = seed.map(|seed| seed.wrapping_add((index as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15)));
        let no_file = |_: &spec::InputSpec| Err("inputs from files are not read here".to_owned());
        let (record, exact) = synthesize(plan, truth, &case.system, seed, &no_file)
            .map_err(|error| format!("record `{}`: {error}", plan.name))?;
        records.push(record);
        truths.push(exact);
    }
    Ok(Loaded { text, case, records, truths })
}

/// The case that a text describes.
///
/// # Errors
/// All its mistakes, in words.
pub(crate) fn checked(text: &str) -> Result<Case, String> {
    let words = |all: Vec<Diagnostic>| {
        let mistakes = all.into_iter().filter(Diagnostic::is_error).map(|d| d.message);
        mistakes.collect::<Vec<_>>().join("; ")
    };
    let (spec, _) = spec::read(text, SourceId(0)).map_err(words)?;
    check(&spec, SourceId(0)).map(|(case, _)| case).map_err(words)
}
