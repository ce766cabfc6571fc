//! `phisindy check`.

use super::spec_file::loaded_with_warnings;
use crate::args::Options;
use crate::terminal::{INPUT, complain, remark};
use phisindy::files::Purpose;
use phisindy_learn::suitable;
use phisindy_phys::spec::Role;
use std::path::PathBuf;

/// Checks specs and their data files, and returns the exit code.
pub(crate) fn check(specs: &[PathBuf], options: &Options) -> u8 {
    let codes = specs.iter().map(|spec| match loaded_with_warnings(spec, options, Purpose::Check, None) {
        Ok((loaded, warnings)) => {
            // What no method can learn from is refused here as it is by a run.
            let fitted = loaded.records.iter().filter(|r| loaded.case.is_open() && r.role == Role::Fit);
            let unfit = fitted.filter_map(|r| suitable(&loaded.case.system, r).err()).next();
            if let Some(why) = unfit {
                complain(&format!("{}: {why}", spec.display()));
                return INPUT;
            }
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
