//! Output of the program: the result on standard output, everything else on standard error. Exit codes.

use crate::draw;
use anyhow::{Context, Result};
use phisindy_phys::{Diagnostic, Sources};
use phisindy_report::Look;
use std::io::{self, IsTerminal, Write};
use std::path::Path;

/// Exit code: the result is rejected.
pub(crate) const REJECTED: u8 = 1;
/// Exit code: the spec, its files or the command line are wrong.
pub(crate) const INPUT: u8 = 2;
/// Exit code: the numerics failed, or a limit was met.
pub(crate) const NUMERICS: u8 = 3;

/// Context of an error on standard output.
pub(crate) const STDOUT: &str =
    "cannot write to standard output: write into a file on a disk with space, or give --out DIR";

/// What the terminal behind standard output can show; `None` for a pipe or a file.
pub(crate) fn look() -> Option<Look> {
    let colour = draw::colours() && std::env::var_os("TERM").is_none_or(|term| term != "dumb");
    let width = usize::from(console::Term::stdout().size().1);
    io::stdout().is_terminal().then_some(Look { colour, width: if width == 0 { 80 } else { width } })
}

/// Says at the end where the report is, as a path that a terminal makes a link of.
pub(crate) fn tell_report(folder: Option<&Path>, look: Option<Look>) -> Result<()> {
    match (folder, look) {
        (Some(folder), Some(_)) => print(&format!("\nreport: {}\n", folder.join("report.html").display())),
        _ => Ok(()),
    }
}

/// Prints the result. Titles and names of somebody else's spec give no commands to a terminal.
pub(crate) fn print(text: &str) -> Result<()> {
    let mut out = io::stdout().lock();
    let text = if out.is_terminal() { draw::coloured(text) } else { text.into() };
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).context(STDOUT)
}

/// Prints an error message on standard error.
pub(crate) fn complain(message: &str) {
    draw::show([&Diagnostic::error(message)], &Sources::default());
}

/// Prints a line on standard error that is not an error.
pub(crate) fn remark(message: &str) {
    // If standard error is closed, there is nobody left to inform.
    let _ = io::stderr().write_all(&draw::printable(format!("{message}\n").as_bytes()));
}
