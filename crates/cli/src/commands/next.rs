//! `phisindy next`.

use crate::args::Options;
use crate::interrupt;
use crate::outdir::Results;
use crate::progress::watched;
use crate::terminal::{INPUT, complain, print, tell_report};
use anyhow::Result;
use phisindy::files;
use std::path::Path;

/// Designs the next run; returns the exit code.
pub(crate) fn next(path: &Path, narrow: Option<&str>, options: &Options) -> Result<u8> {
    let folder = options.out.as_ref().map(|out| Results::prepare(out, path, options)).transpose()?;
    let request = options.request();
    let what = path.display().to_string();
    let report = watched(&what, options.quiet, |work| files::next(path, narrow, &request, work));
    let report = match report {
        Ok(report) => report,
        Err(_) if interrupt::requested() => {
            // It is stopped before there is a run.
            interrupt::keeps_nothing();
            interrupt::tell();
            return Ok(interrupt::code());
        }
        Err(why) => {
            complain(&why);
            return Ok(INPUT);
        }
    };
    let kept = folder.as_ref().map_or(Ok(None), |folder| folder.put(&report.folder(&options.line)));
    print(&report.written(options.format.into()))?;
    tell_report(kept?.as_deref(), None, options.look)?;
    if interrupt::requested() {
        interrupt::tell();
        return Ok(interrupt::code());
    }
    Ok(0)
}
