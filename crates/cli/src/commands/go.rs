//! `phisindy go`: from a data file to the report of `gap`, without a stop.

use super::{gap, new};
use crate::args::{GoArgs, NewArgs, Options};
use crate::outdir::Results;
use crate::terminal::{complain, remark};
use anyhow::{Result, anyhow};
use phisindy_report::Folder;
use std::ffi::OsString;
use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Writes a spec for data files unless it is there, looks for what is missing, and opens the report; returns
/// the exit code of `gap`.
///
/// # Errors
/// A file cannot be written.
pub(crate) fn command(args: &GoArgs, options: &Options) -> Result<u8> {
    let path = &args.paths[0];
    let named = |ending: &str| {
        let mut name = path.file_stem().map_or("data".into(), OsString::from);
        name.push(ending);
        PathBuf::from(name)
    };
    let out = options.out.clone().unwrap_or_else(|| named("-found"));
    // The result has an `identified.ron` of its own, and some systems take `Identified.ron`
    // for the same name.
    let of_result = |name: &Path| Folder::may_hold(&name.to_string_lossy().to_lowercase());
    let draft = Some(named(".ron")).filter(|name| !of_result(name)).unwrap_or_else(|| named("-spec.ron"));
    let spec = out.join(draft);
    Results::prepare(&out, &spec, options)?;
    // A spec that is there may hold edits: they count.
    if spec.exists() {
        if args.said.is_something() {
            return Err(anyhow!(
                "`{0}` is there and is used as it is: what you say of the file would not count. Change its lines, or \
                 delete it and type the same again",
                spec.display()
            ));
        }
        say(options, &format!("{} is there and is used as it is", spec.display()));
    } else {
        say(options, &format!("looking at {}", path.display()));
        let draft = NewArgs { paths: args.paths.clone(), sheet: args.sheet.clone(), said: args.said.clone() };
        let drafting = Options { out: Some(spec.clone()), ..options.clone() };
        std::fs::create_dir_all(&out)?;
        // A search on what nobody knows would be one on an invention.
        let code = new::written(&draft, &drafting, new::Purpose::Search);
        if !matches!(code, Ok(0)) {
            // Only if there is nothing in it.
            let _ = std::fs::remove_dir(&out);
            return code;
        }
        say(
            options,
            &format!(
                "{} is written: a guess. Look at its lines marked EDIT, change them, and type the same command again",
                spec.display()
            ),
        );
    }
    let beside = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let data = options.data.clone().or_else(|| Some(beside.to_owned()));
    let code = gap::gap(&spec, &[], &Options { data, out: Some(out.clone()), ..options.clone() })?;
    let report = out.join("report.html");
    if !args.no_open && io::stdout().is_terminal() && report.is_file() {
        open(&report);
    }
    Ok(code)
}

fn say(options: &Options, words: &str) {
    if !options.quiet {
        remark(words);
    }
}

/// Opens a file with the program that the desktop has for it, and does not wait for it.
fn open(path: &Path) {
    let (program, first): (&str, &[&str]) = if cfg!(target_os = "macos") {
        ("open", &[])
    } else if cfg!(windows) {
        ("cmd", &["/c", "start", ""])
    } else {
        ("xdg-open", &[])
    };
    let quiet = || Stdio::null();
    let started =
        Command::new(program).args(first).arg(path).stdin(quiet()).stdout(quiet()).stderr(quiet()).spawn();
    if started.is_err() {
        complain(&format!("cannot open `{}`: open it in a browser", path.display()));
    }
}
