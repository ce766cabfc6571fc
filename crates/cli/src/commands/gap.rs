//! `phisindy gap`.

use super::spec_file::{failed, keep, keep_failure, loaded};
use crate::args::Options;
use crate::interrupt;
use crate::outdir::Results;
use crate::progress::Progress;
use crate::terminal::{INPUT, NUMERICS, REJECTED, print, remark, tell_report};
use anyhow::{Result, bail};
use phisindy::files::{Asked, Purpose, beside};
use phisindy_gap::GapError;
use phisindy_report::spec_text::COMPLETED;
use phisindy_report::{Ending, Folder, GapReport};
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

/// Runs the workflow on one spec without some laws of the catalogue, prints and keeps what it found, and
/// returns the exit code.
pub(crate) fn gap(spec: &Path, without: &[String], options: &Options) -> Result<u8> {
    let begin = Instant::now();
    let folder = match &options.out {
        Some(out) => Some(Results::prepare(out, spec, options)?),
        None => None,
    };
    let plan = options.plan()?;
    let loaded = match loaded(spec, options, Purpose::Gap, folder.as_ref()) {
        Ok(loaded) => loaded,
        Err(code) => return Ok(code),
    };
    let catalogue = beside(spec, &options.request())?;
    let ids = || catalogue.laws().iter().map(|law| law.id.as_str());
    if let Some(id) = without.iter().find(|id| !ids().any(|known| known == *id)) {
        let near = phisindy_expr::nearest(id, ids())
            .map_or(String::new(), |near| format!("; did you mean `{near}`?"));
        bail!("--without {id}: there is no law `{id}` (`phisindy laws` lists them){near}");
    }
    let catalogue = catalogue.without(without);
    let found = {
        let mut progress = Progress::new(&loaded.spec, options.quiet);
        let (case, records) = (loaded.case.clone(), loaded.records.clone());
        phisindy_gap::gap(&loaded.text, case, records, catalogue.laws(), &mut |fraction, activity| {
            progress.doing(&activity.to_string());
            progress.at(fraction);
            if interrupt::requested() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })
    };
    let found = match found {
        Ok(found) => found,
        Err(error) => {
            let why = error.to_string();
            let diverged = error.diverged();
            failed(&loaded.spec, &why, diverged);
            interrupt::tell();
            if let Some(folder) = &folder {
                keep_failure(&why, diverged, loaded.input(), options, folder)?;
            }
            return Ok(match error {
                GapError::Data(_) => INPUT,
                GapError::Numerics(_) => NUMERICS,
            });
        }
    };
    let ending = Ending {
        seconds: begin.elapsed().as_secs_f64(),
        stopped: found.interrupted().then(interrupt::ended),
    };
    let planned = plan.map(|plan| plan.beside_search(&found));
    let (input, catalogue, planned) = (loaded.input(), catalogue.laws(), planned.as_ref());
    let report = GapReport { input, gap: &found, catalogue, planned, ending };
    // At a terminal they stand in the result.
    if !options.quiet && options.look.is_none() {
        report.notes().for_each(|w| remark(&format!("note: {w}")));
    }
    let request = options.request();
    let asked = Asked { command: Purpose::Gap, spec, request: &request, method: None, without };
    let kept = keep(folder.as_ref(), &asked, &loaded, options, |how| Folder::of_gap(&report, how));
    // A full disk must not lose the result, so it is printed first.
    print(
        &options.look.map_or_else(|| report.written(options.format.into()), |look| report.at_terminal(look)),
    )?;
    let model = found.status.holds().then_some(COMPLETED);
    tell_report(kept?.as_deref(), model, options.look)?;
    if found.interrupted() {
        interrupt::tell();
    }
    Ok(match (found.interrupted(), found.status) {
        (true, _) => interrupt::code(),
        (false, status) if !status.holds() => REJECTED,
        (false, _) => 0,
    })
}
