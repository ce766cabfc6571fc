//! `phisindy check`.

use super::spec_file::loaded_with_warnings;
use crate::args::Options;
use crate::terminal::remark;
use phisindy::files::Purpose;
use std::path::PathBuf;

/// Checks specs and their data files, and returns the exit code.
pub(crate) fn check(specs: &[PathBuf], options: &Options) -> u8 {
    let codes = specs.iter().map(|spec| match loaded_with_warnings(spec, options, Purpose::Check, None) {
        Ok((_, warnings)) => {
            // Silence would not show that anything was checked.
            if !options.quiet {
                let warned = match warnings {
                    0 => String::new(),
                    1 => ", 1 warning".to_owned(),
                    n => format!(", {n} warnings"),
                };
                remark(&format!("{}: no mistakes{warned}", spec.display()));
            }
            0
        }
        Err(code) => code,
    });
    codes.max().unwrap_or(0)
}
