//! What the program says: the result on standard output, everything else on standard error, and its exit codes.

use crate::draw;
use anyhow::{Context, Result};
use phisindy_phys::{Diagnostic, Sources};
use std::io::{self, Write};

/// The result was rejected.
pub(crate) const REJECTED: u8 = 1;
/// The spec, its files or the command line are wrong.
pub(crate) const INPUT: u8 = 2;
/// The numerics failed.
pub(crate) const NUMERICS: u8 = 3;

/// What is wrong where the result has nowhere to go.
pub(crate) const STDOUT: &str =
    "cannot write to standard output: write into a file on a disk with space, or give --out DIR";

/// The result.
pub(crate) fn print(text: &str) -> Result<()> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).context(STDOUT)
}

/// A message on standard error.
pub(crate) fn complain(message: &str) {
    draw::show([&Diagnostic::error(message)], &Sources::default());
}

/// A line on standard error that is no mistake.
pub(crate) fn remark(message: &str) {
    // Nobody is left to tell if standard error is closed.
    let _ = writeln!(io::stderr(), "{message}");
}
