//! `phisindy new`: writes a commented spec for a data file.

use crate::args::{NewArgs, Options};
use crate::terminal::{INPUT, print, remark};
use crate::{draw, outdir};
use anyhow::{Result, anyhow};
use phisindy::files;
use phisindy_expr::Span;
use phisindy_import::{Draft, accepted, csv, spec_text, summary};
use phisindy_phys::{Diagnostic, Sources};
use std::path::{Path, PathBuf};

/// Writes a spec for a data file and returns the exit code.
///
/// # Errors
/// The spec cannot be written.
pub(crate) fn command(args: &NewArgs, options: &Options) -> Result<u8> {
    let out = options.out.as_deref().filter(|out| *out != Path::new("-"));
    // Checked before any work: an existing spec may contain hours of edits.
    if let Some(out) = out {
        if out.is_dir() {
            return Err(anyhow!(
                "`{}` is a folder: give --out the name of a file, such as case.ron",
                out.display()
            ));
        }
        outdir::unless_there(out, args.force)?;
    }
    let mut sources = Sources::default();
    let draft = match drafted(args, &mut sources) {
        Ok(draft) => draft,
        Err(d) => {
            draw::show([&*d], &sources);
            return Ok(INPUT);
        }
    };
    let file = args.path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    let next = next_command(args, out);
    let text = spec_text(&draft, &file, &next);
    if let Err(why) = accepted(&text) {
        return Err(anyhow!("the spec for `{file}` would not be accepted ({why}): please report this"));
    }
    match out {
        Some(out) => outdir::replace_file(out, &text)?,
        None => print(&text)?,
    }
    if !options.quiet {
        summary(&draft, &file).iter().for_each(|line| remark(line));
        let edit = "look at its lines marked EDIT, then type";
        remark(&match out {
            Some(out) => format!("{} is written: {edit}", out.display()),
            None => format!("save this as a file (or say --out FILE), {edit}"),
        });
        remark(&format!("    phisindy run {next}"));
    }
    Ok(0)
}

fn drafted(args: &NewArgs, sources: &mut Sources) -> Result<Draft, Box<Diagnostic>> {
    let name = args.path.display().to_string();
    let words = format!("phisindy new {name}");
    let at = (sources.add("command line", words.clone()), Span::new(words.len() - name.len(), words.len()));
    let table = csv::table(files::opened(&args.path, &name, at)?, at, sources)?;
    Draft::of(table).map_err(|why| why.diagnostic(&name, at))
}

/// The next command, as arguments of `run`.
fn next_command(args: &NewArgs, out: Option<&Path>) -> String {
    let folder = |path: &Path| match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    };
    let spec = out.map_or_else(
        || Path::new(args.path.file_name().unwrap_or_default()).with_extension("ron"),
        Path::to_owned,
    );
    let data = folder(&args.path);
    let same = match (folder(&spec).canonicalize(), data.canonicalize()) {
        (Ok(a), Ok(b)) => a == b,
        _ => false,
    };
    if same { quoted(&spec) } else { format!("{} --data {}", quoted(&spec), quoted(&data)) }
}

/// The word quoted for a shell.
fn quoted(path: &Path) -> String {
    let text = path.display().to_string();
    let plain = text.chars().all(|c| c.is_alphanumeric() || "/._-+=".contains(c));
    if plain { text } else { format!("'{}'", text.replace('\'', "'\\''")) }
}
