//! `phisindy fmt`.

use crate::draw;
use crate::terminal::{INPUT, print};
use anyhow::{Context, Result};
use phisindy::files::{spec_text, write_whole};
use phisindy_phys::{Diagnostic, Sources, format};
use std::fs;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// Exit code: a file is not in order.
const UNORDERED: u8 = 1;

/// Puts files in order, or names those that are not, and returns the exit code.
pub(crate) fn fmt(files: &[PathBuf], check: bool) -> Result<u8> {
    let mut code = 0;
    for file in files {
        let stdin = file == Path::new("-");
        let mut sources = Sources::default();
        let text = if stdin { standard_input() } else { spec_text(file) };
        let formatted = text.and_then(|text| {
            let source = sources.add(file.display().to_string(), text.clone());
            format(&text, source).map(|new| (text, new))
        });
        match formatted {
            Err(mistake) => {
                draw::show([&mistake], &sources);
                code = INPUT;
            }
            Ok((text, new)) if check => {
                if new != text {
                    print(&format!("{}\n", file.display()))?;
                    code = code.max(UNORDERED);
                }
            }
            Ok((_, new)) if stdin => print(&new)?,
            // One file that cannot be written does not keep the others from it.
            Ok((text, new)) if new != text => {
                if let Err(error) = replace(file, &new) {
                    draw::show([&Diagnostic::error(format!("{error:#}"))], &sources);
                    code = INPUT;
                }
            }
            Ok(_) => {}
        }
    }
    Ok(code)
}

/// The text of standard input, as far as it can be a spec.
fn standard_input() -> Result<String, Diagnostic> {
    let mut text = String::new();
    let read = io::stdin().lock().take((1 << 20) + 1).read_to_string(&mut text);
    let text = || text.strip_prefix('\u{feff}').unwrap_or(&text).to_owned();
    read.map(|_| text()).map_err(|error| Diagnostic::error(format!("cannot read standard input: {error}")))
}

/// Replaces a file as a whole. Links lead to it still, and who may read it may do so still.
fn replace(path: &Path, text: &str) -> Result<()> {
    let shown = path.display();
    let write = || {
        let file = path.canonicalize()?;
        let was = fs::metadata(&file)?;
        if was.permissions().readonly() {
            return Err(io::ErrorKind::PermissionDenied.into());
        }
        if has_other_names(&was) {
            return fs::write(&file, text);
        }
        write_whole(&file, text.as_bytes())?;
        give_back(&file, &was)
    };
    write().with_context(|| format!("cannot write `{shown}`"))
}

/// Whether hard links lead to a file: a new one in its place would part them.
fn has_other_names(was: &fs::Metadata) -> bool {
    #[cfg(unix)]
    return std::os::unix::fs::MetadataExt::nlink(was) > 1;
    #[cfg(not(unix))]
    return false;
}

/// Gives a new file the rights of the one before, and its owner and group as far as the system allows it.
fn give_back(file: &Path, was: &fs::Metadata) -> io::Result<()> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::{MetadataExt, chown};
        for (owner, group) in [(Some(was.uid()), None), (None, Some(was.gid()))] {
            let _ = chown(file, owner, group);
        }
    }
    fs::set_permissions(file, was.permissions())
}
