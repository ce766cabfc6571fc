//! Shared by commands that work on a spec: reading it, reporting its mistakes, reporting failures.

use crate::args::Options;
use crate::draw;
use crate::outdir::Results;
use crate::progress::Progress;
use crate::terminal::{INPUT, NUMERICS, complain};
use anyhow::Result;
use phisindy::Loaded;
use phisindy::files::{Asked, Provenance, Purpose, Refusal, load};
use phisindy_phys::{Diagnostic, Sources};
use phisindy_report::{Folder, Input, Invocation, html};
use std::path::{Path, PathBuf};

/// Reads a spec and shows its diagnostics; mistakes also go into the report of a folder.
///
/// # Errors
/// The exit code: the spec or its files are wrong.
pub(super) fn loaded(
    spec: &Path,
    options: &Options,
    purpose: Purpose,
    folder: Option<&Results>,
) -> Result<Loaded, u8> {
    loaded_with_warnings(spec, options, purpose, folder).map(|(loaded, _)| loaded)
}

/// The same with the number of warnings.
///
/// # Errors
/// The exit code: the spec or its files are wrong.
pub(super) fn loaded_with_warnings(
    spec: &Path,
    options: &Options,
    purpose: Purpose,
    folder: Option<&Results>,
) -> Result<(Loaded, usize), u8> {
    let (mut sources, mut found) = (Sources::default(), Vec::new());
    let loaded = {
        let _progress = Progress::new(&format!("reading {} and its data", spec.display()), options.quiet);
        load(spec, &options.request(), purpose, &mut sources, &mut found)
    };
    // Next to a mistake, warnings are mostly its consequences: what failed to parse leaves constants unused.
    let drawn = || found.iter().filter(|d| d.is_error() || (loaded.is_ok() && !options.quiet));
    draw::show(drawn(), &sources);
    if let (Err(_), Some(folder)) = (&loaded, folder) {
        let name = spec.display().to_string();
        let text = sources.files.iter().find(|f| f.name.starts_with(&name)).map(|f| f.text.as_str());
        let (errors, drawn) = (drawn().collect(), draw::text(drawn(), &sources));
        let refused = html::Refused { spec: &name, text, errors, sources: &sources, drawn };
        let page = html::refusal(&refused, &invocation(options));
        let kept = folder.put(&Folder::of_page(page));
        kept.map_or_else(|error| complain(&format!("{error:#}")), drop);
    }
    let doubts = || found.iter().map(|d| d.message.clone()).collect();
    loaded.map(|loaded| (Loaded { doubts: doubts(), ..loaded }, found.len())).map_err(exit_code)
}

/// The exit code of a refusal.
pub(super) fn exit_code(refusal: Refusal) -> u8 {
    match refusal {
        Refusal::Input => INPUT,
        Refusal::Numerics => NUMERICS,
    }
}

/// Reports a failure on standard error, with advice if a state grew without bound.
pub(super) fn failed(spec: &str, why: &str, diverged: bool) {
    let d = Diagnostic::error(format!("{spec}: {why}"));
    draw::show([&html::advice(diverged).into_iter().fold(d, Diagnostic::help)], &Sources::default());
}

/// Writes a failure as a report into the folder of `--out`.
pub(super) fn keep_failure(
    why: &str,
    diverged: bool,
    input: Input<'_>,
    options: &Options,
    folder: &Results,
) -> Result<()> {
    folder.put(&Folder::of_page(html::failure(why, diverged, input, &invocation(options)))).map(drop)
}

/// Writes the files of a result and what they were made from, and returns where they are.
pub(super) fn keep(
    folder: Option<&Results>,
    asked: &Asked<'_>,
    loaded: &Loaded,
    options: &Options,
    files: impl FnOnce(&Invocation) -> Folder,
) -> Result<Option<PathBuf>> {
    let Some(folder) = folder else { return Ok(None) };
    let made = Provenance::of(asked, loaded, folder.path());
    let mut files = files(&Invocation { inputs: Some(made.inputs()), ..invocation(options) });
    made.put_into(&mut files, loaded);
    if let Some(why) = &files.lacks {
        complain(why);
    }
    folder.put(&files)
}

/// How the program was called.
fn invocation(options: &Options) -> Invocation {
    let assigned = !options.sets.is_empty();
    Invocation { arguments: options.line.clone(), assigned, seed: options.seed, inputs: None }
}
