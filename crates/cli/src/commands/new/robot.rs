//! A spec for a robot of URDF or MJCF.

use super::{Purpose, asked, named, names, next_command, put, tabled};
use crate::args::{NewArgs, Options};
use crate::draw;
use crate::progress::Progress;
use crate::terminal::{INPUT, remark};
use anyhow::{Context, Result, bail};
use phisindy_import::{Robot, RobotLog};
use phisindy_phys::Sources;
use std::cell::RefCell;
use std::io::Read;
use std::path::Path;

/// Largest file of a robot.
const LARGEST: u64 = 1 << 24;
/// In so many bytes a file says what it is.
const BEGIN: usize = 1 << 16;

/// The text of a robot, if the file is of one: XML with the element that a robot has.
///
/// # Errors
/// It is a robot, and cannot be read.
pub(super) fn text(path: &Path) -> Result<Option<String>> {
    // What cannot be opened is told as of a data file.
    let Ok(file) = phisindy::files::open_plain_file(path) else { return Ok(None) };
    let mut bytes = vec![];
    let read = file.take(LARGEST + 1).read_to_end(&mut bytes);
    let begin = String::from_utf8_lossy(&bytes[..bytes.len().min(BEGIN)]);
    let is_xml = begin.trim_start_matches('\u{feff}').trim_start().starts_with('<');
    let is_named = path
        .extension()
        .is_some_and(|own| own.eq_ignore_ascii_case("urdf") || own.eq_ignore_ascii_case("mjcf"));
    if !(is_xml && (is_named || begin.contains("<robot") || begin.contains("<mujoco"))) {
        return Ok(None);
    }
    let shown = path.display();
    read.with_context(|| format!("cannot read `{shown}`"))?;
    if bytes.len() as u64 > LARGEST {
        bail!("`{shown}` is larger than {} MiB: a robot of joints is not", LARGEST >> 20);
    }
    match String::from_utf8(bytes) {
        Ok(text) => Ok(Some(text)),
        Err(e) => bail!("`{shown}` is no UTF-8 at byte {}: save it as UTF-8", e.utf8_error().valid_up_to()),
    }
}

/// Writes a spec for a robot and returns the exit code.
///
/// # Errors
/// The spec cannot be written.
pub(super) fn written(
    text: &str,
    args: &NewArgs,
    options: &Options,
    (purpose, out): (Purpose, Option<&Path>),
) -> Result<u8> {
    let path = &args.paths[0];
    if purpose == Purpose::Search {
        bail!(
            "`{0}` is a robot, whose draft has to be looked at first: `phisindy new {0} --data LOG --out robot.ron`, \
             then `phisindy gap robot.ron`",
            path.display()
        );
    }
    let file = names(&args.paths)?.remove(0);
    let mut sources = Sources::default();
    let source = sources.add(path.display().to_string(), text);
    let robot = match Robot::read(text, source) {
        Ok(robot) => robot,
        Err(d) => {
            draw::show([&*d], &sources);
            return Ok(INPUT);
        }
    };
    let mut answers = args.said.answers();
    let (log, data) = loop {
        let Some(data) = &options.data else { break (None, String::new()) };
        let name = names(std::slice::from_ref(data))?.remove(0);
        let (shown, at) = named(data, purpose, &mut sources);
        let progress = RefCell::new(Progress::new("reading", options.quiet));
        let table = tabled(data, (&shown, at), args, &progress, &mut sources);
        let log = table.and_then(|table| {
            RobotLog::of(table, &robot, &answers).map_err(|why| why.diagnostic(&shown, at))
        });
        let log = match log {
            Ok(log) => log,
            Err(d) => {
                draw::show([&*d], &sources);
                return Ok(INPUT);
            }
        };
        drop(progress);
        if !asked(log.questions.iter(), &mut answers)? {
            break (Some(log), name);
        }
    };
    let next = next_command(options.data.as_deref().unwrap_or(path), out);
    let spec = robot.spec_text(log.as_ref(), (&file, &data), &next);
    if put(spec, &file, options, (out, &mut sources))?.is_none() {
        return Ok(INPUT);
    }
    if options.quiet {
        return Ok(0);
    }
    robot.summary(log.as_ref()).iter().for_each(|line| remark(line));
    let edit = "look at its lines marked EDIT, then type";
    remark(&match out {
        Some(out) => format!("{} is written: {edit}", out.display()),
        None => format!("save this as a file (or say --out FILE), {edit}"),
    });
    remark(&format!("    phisindy {} {next}", if log.is_some() { "gap" } else { "simulate" }));
    Ok(0)
}
