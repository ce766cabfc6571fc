//! Shared by commands that work on a spec: reading it, reporting its mistakes, reporting failures.

use crate::args::Options;
use crate::draw;
use crate::outdir::OutDir;
use crate::progress::Progress;
use crate::terminal::{INPUT, NUMERICS, complain};
use anyhow::Result;
use phisindy::Loaded;
use phisindy::files::{Purpose, Refusal, load};
use phisindy_phys::{Diagnostic, Sources};
use phisindy_report::html::{self, HtmlReport};
use phisindy_report::{Folder, Input, Invocation};
use std::path::Path;

/// Reads a spec and shows its diagnostics; mistakes also go into the report of a folder.
///
/// # Errors
/// The exit code: the spec or its files are wrong.
pub(super) fn loaded(
    spec: &Path,
    options: &Options,
    purpose: Purpose,
    folder: Option<&OutDir>,
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
    folder: Option<&OutDir>,
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
        write_html(&page, folder).unwrap_or_else(|error| complain(&format!("{error:#}")));
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
    folder: &OutDir,
) -> Result<()> {
    write_html(&html::failure(why, diverged, input, &invocation(options)), folder)
}

/// Writes a report and its figures.
fn write_html(report: &HtmlReport, folder: &OutDir) -> Result<()> {
    if !report.figures.is_empty() {
        let figures = OutDir::create(&folder.path().join("figures"))?;
        for (name, svg) in &report.figures {
            figures.write(name, svg)?;
        }
    }
    folder.write("report.html", &report.page)
}

/// Writes the files of a result.
pub(super) fn keep(files: &Folder, folder: &OutDir) -> Result<()> {
    if let Some(why) = &files.lacks {
        complain(why);
    }
    for (path, text) in &files.files {
        match path.rsplit_once('/') {
            Some((inner, name)) => OutDir::create(&folder.path().join(inner))?.write(name, text)?,
            None => folder.write(path, text)?,
        }
    }
    Ok(())
}

/// How the program was called.
pub(super) fn invocation(options: &Options) -> Invocation {
    Invocation { arguments: options.line.clone(), assigned: !options.sets.is_empty(), seed: options.seed }
}
