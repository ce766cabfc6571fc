//! `phisindy compare`.

use crate::args::Options;
use crate::interrupt;
use crate::outdir::{Results, unless_read};
use crate::progress::watched;
use crate::terminal::{INPUT, REJECTED, complain, print, tell_report};
use anyhow::Result;
use phisindy::files;
use phisindy_report::Folder;
use std::path::PathBuf;

/// Sets results beside each other; returns the exit code.
pub(crate) fn compare(paths: &[PathBuf], options: &Options) -> Result<u8> {
    interrupt::keeps_nothing();
    options.out.iter().try_for_each(|out| paths.iter().try_for_each(|read| unless_read(out, read)))?;
    let folder = options.out.as_ref().map(|out| Results::prepare(out, &paths[0], options)).transpose()?;
    let request = options.request();
    let what = paths[0].display().to_string();
    let report = watched(&what, options.quiet, |work| files::compare(paths, &request, work));
    if interrupt::requested() {
        interrupt::tell();
        return Ok(interrupt::code());
    }
    let report = match report {
        Ok(report) => report,
        Err(why) => {
            complain(&why);
            return Ok(INPUT);
        }
    };
    let kept =
        folder.as_ref().map_or(Ok(None), |folder| folder.put(&Folder::of_comparison(&report, &options.line)));
    print(&report.written(options.format.into()))?;
    tell_report(kept?.as_deref(), None, options.look)?;
    Ok(if report.is_quiet() { 0 } else { REJECTED })
}
