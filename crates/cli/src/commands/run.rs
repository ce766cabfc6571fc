//! `phisindy run`.

use super::spec_file::{failed, keep, keep_failure, loaded};
use crate::args::{Format, Options};
use crate::outdir::{self, Results};
use crate::progress::Progress;
use crate::terminal::{INPUT, NUMERICS, REJECTED, print, remark, tell_report};
use crate::{draw, interrupt};
use anyhow::Result;
use phisindy::Loaded;
use phisindy::files::{Asked, Purpose};
use phisindy_learn::{Identified, LearnError, LearnOptions};
use phisindy_phys::{Diagnostic, Sources};
use phisindy_report::spec_text::IDENTIFIED;
use phisindy_report::{Ending, Folder, RunReport};
use std::io::{self, IsTerminal};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Identifies the unknown part of each spec, and returns the worst exit code.
pub(crate) fn run(specs: &[PathBuf], options: &Options) -> Result<u8> {
    let folders: Vec<Option<Results>> = match &options.out {
        Some(out) => outdir::places(out, specs, options)?.into_iter().map(Some).collect(),
        None => specs.iter().map(|_| None).collect(),
    };
    let mut worst = 0;
    for (k, (spec, folder)) in specs.iter().zip(&folders).enumerate() {
        if interrupt::requested() {
            interrupt::tell();
            return Ok(interrupt::code());
        }
        let code = run_one(spec, folder.as_ref(), options, k > 0)?;
        worst = worst.max(code);
    }
    Ok(worst)
}

fn run_one(spec: &Path, folder: Option<&Results>, options: &Options, follows: bool) -> Result<u8> {
    let begin = Instant::now();
    let plan = options.plan()?;
    let loaded = match loaded(spec, options, Purpose::Run, folder) {
        Ok(loaded) => loaded,
        Err(code) => return Ok(code),
    };
    let fail = |loaded: &Loaded, why: &str, diverged: bool| -> Result<()> {
        failed(&loaded.spec, why, diverged);
        interrupt::tell();
        folder.map_or(Ok(()), |folder| keep_failure(why, diverged, loaded.input(), options, folder))
    };
    let loaded = match with_formulas(&loaded, options) {
        Ok(with) => with.unwrap_or(loaded),
        Err(error) => {
            fail(&loaded, &error.to_string(), error.diverged())?;
            return Ok(NUMERICS);
        }
    };
    let (loaded, found) = match identify_with_progress(loaded.clone(), options) {
        Ok(found) => found,
        Err(error) => {
            fail(&loaded, &error.to_string(), error.diverged())?;
            return Ok(match error {
                LearnError::Data(_) => INPUT,
                LearnError::Numerics(_) => NUMERICS,
            });
        }
    };
    let ending = Ending {
        seconds: begin.elapsed().as_secs_f64(),
        stopped: found.interrupted().then(interrupt::ended),
    };
    let mut report = RunReport::new(loaded.input(), &found, ending);
    report.planned = plan.map(|plan| plan.beside_fit(&found.parameters));
    if !options.quiet {
        caution(&report, options);
    }
    let (request, method) = (options.request(), options.method.map(Into::into));
    let asked = Asked { command: Purpose::Run, spec, request: &request, method, without: &[] };
    let files = |how: &_| Folder::of_run(&report, loaded.input(), &found, how);
    let kept = keep(folder, &asked, &loaded, options, files);
    // A full disk must not lose the result, so it is printed first.
    let blank = if follows && options.format != Format::Json { "\n" } else { "" };
    let text =
        options.look.map_or_else(|| report.written(options.format.into()), |look| report.at_terminal(look));
    print(&format!("{blank}{text}"))?;
    let model = found.verdict.holds().then_some(IDENTIFIED);
    tell_report(kept?.as_deref(), model, options.look)?;
    if found.interrupted() {
        interrupt::tell();
    }
    Ok(match (found.interrupted(), &found.verdict) {
        (true, _) => interrupt::code(),
        (false, verdict) if verdict.holds() => 0,
        (false, _) => REJECTED,
    })
}

/// Notes and warnings on standard error; warnings not twice if the result goes to the same terminal.
fn caution(report: &RunReport<'_>, options: &Options) {
    let twice = options.format != Format::Json && io::stdout().is_terminal() && io::stderr().is_terminal();
    report.notes.iter().for_each(|note| remark(&format!("note: {note}")));
    if !twice {
        let said: Vec<Diagnostic> = report.warnings.iter().map(|w| Diagnostic::warning(w.clone())).collect();
        draw::show(&said, &Sources::default());
    }
}

/// Finds the formulas that the spec asks for, with a progress bar.
fn with_formulas(loaded: &Loaded, options: &Options) -> Result<Option<Loaded>, phisindy::Error> {
    let mut progress = Progress::new(&loaded.spec, options.quiet);
    let with = loaded.with_formulas(&mut |fraction, activity| {
        progress.doing(activity);
        progress.at(fraction);
        if interrupt::requested() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })?;
    drop(progress);
    let doubts = with.iter().flat_map(|with| &with.doubts[loaded.doubts.len()..]);
    let new: Vec<Diagnostic> = doubts.map(|d| Diagnostic::warning(d.clone())).collect();
    if !options.quiet {
        draw::show(&new, &Sources::default());
    }
    Ok(with)
}

/// Runs the identification with a progress bar, until an early end is requested.
fn identify_with_progress(loaded: Loaded, options: &Options) -> Result<(Loaded, Identified), LearnError> {
    let mut progress = Progress::new(&loaded.spec, options.quiet);
    let learn = LearnOptions { method: options.method.map(Into::into), ..Default::default() };
    loaded.identified(&learn, &mut |fraction| {
        progress.at(fraction);
        if interrupt::requested() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })
}
