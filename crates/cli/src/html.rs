//! `report.html`: what a run or a gap found, in one file that needs no network and no script, and its figures as files of their own.
//!
//! ```text
//! Report, Gap or a failure --> sections (tables, equations, figures) --> Page --> report.html, figures/*.svg
//! ```

mod correlation;
mod data;
mod force;
mod friction;
mod gap;
mod map;
mod mathml;
mod motion;
mod page;
mod regimes;
mod repeat;
mod residual;
mod run;
mod selection;
mod shrink;
mod table;

use crate::args::Options;
use crate::command::advice;
use crate::load::Loaded;
use crate::outdir::OutDir;
use crate::report::Report;
use anyhow::Result;
use page::{Banner, Page, Tone, add_remarks, block};
use phisindy_gap::{Entry, Gap};

/// Writes what `run` found.
pub(crate) fn write_run(
    report: &Report<'_>,
    loaded: &Loaded,
    options: &Options,
    folder: &OutDir,
) -> Result<()> {
    run::page(report, loaded, options).write(folder)
}

/// Writes what `gap` found.
pub(crate) fn write_gap(
    found: &Gap,
    catalogue: &[Entry],
    loaded: &Loaded,
    seconds: f64,
    options: &Options,
    folder: &OutDir,
) -> Result<()> {
    gap::page(found, catalogue, loaded, seconds, options).write(folder)
}

/// Writes what is wrong with a spec or its files, as it was drawn; `text` is the spec, as far as it could be read.
pub(crate) fn write_refusal(
    spec: &str,
    text: Option<&str>,
    mistakes: &str,
    options: &Options,
    folder: &OutDir,
) -> Result<()> {
    let banner = Banner {
        tone: Tone::Bad,
        headline: "Not run".to_owned(),
        text: "Nothing was computed: the spec or its data cannot be used as they are.".to_owned(),
    };
    let mut page = Page::of_refusal(spec, banner);
    page.section("What is wrong", [block(mistakes.trim_end(), "mistakes")]);
    page.section("To repeat it", repeat::command(None, spec, text, options));
    page.write(folder)
}

/// Writes why there is no result, beside what was measured.
pub(crate) fn write_failure(why: &str, loaded: &Loaded, options: &Options, folder: &OutDir) -> Result<()> {
    let text = advice(why).map_or_else(|| why.to_owned(), |advice| format!("{why}: {advice}"));
    let banner = Banner { tone: Tone::Bad, headline: "Failed".to_owned(), text };
    let mut page = Page::new(loaded, banner);
    add_remarks(&mut page, &[], &loaded.doubts, &data::notes(loaded));
    let seen = data::measured(loaded);
    page.figures("Measured", motion::charts(&seen));
    repeat::add(&mut page, loaded, options);
    page.write(folder)
}
