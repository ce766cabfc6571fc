//! `phisindy check`.

use super::spec_file::loaded_with_warnings;
use crate::args::Options;
use crate::terminal::{INPUT, complain, look, print, remark};
use phisindy::files::Purpose;
use phisindy_learn::suitable;
use phisindy_phys::spec::{Role, StructureSpec};
use phisindy_report::sketch;
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
                loaded.parsed.structure.iter().filter_map(StructureSpec::note).for_each(|note| remark(&note));
                if let Some(look) = look() {
                    return drawn(&sketch(&loaded.parsed, &loaded.case, look));
                }
            }
            0
        }
        Err(code) => code,
    });
    codes.max().unwrap_or(0)
}

/// Prints the sketch of a model, so that who wrote the spec sees what it says.
fn drawn(lines: &[String]) -> u8 {
    let text: String = lines.iter().map(|line| format!("{line}\n")).collect();
    match print(&text) {
        Ok(()) => 0,
        Err(why) => {
            complain(&format!("{why:#}"));
            INPUT
        }
    }
}
