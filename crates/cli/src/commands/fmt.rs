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

/// Replaces a file as a whole. A link leads to it still, and who may read it may do so still: a file with several names,
/// or of another owner, is written where it is.
fn replace(path: &Path, text: &str) -> Result<()> {
    let shown = path.display();
    let write = || {
        let file = path.canonicalize()?;
        let was = fs::metadata(&file)?;
        if was.permissions().readonly() {
            return Err(io::ErrorKind::PermissionDenied.into());
        }
        if is_shared(&file, &was)? {
            return fs::write(&file, text);
        }
        write_whole(&file, text.as_bytes())?;
        fs::set_permissions(&file, was.permissions())
    };
    write().with_context(|| format!("cannot write `{shown}`, which is left as it was"))
}

/// Whether a new file in the place of this one would not be the same to others: it has more names, or an owner or a
/// group that a new file beside it does not get.
#[cfg(unix)]
fn is_shared(file: &Path, was: &fs::Metadata) -> io::Result<bool> {
    use std::os::unix::fs::MetadataExt;
    let mut beside = file.as_os_str().to_owned();
    beside.push(".fmt-owner");
    let new = fs::File::create_new(&beside)?.metadata();
    fs::remove_file(&beside)?;
    let new = new?;
    Ok(was.nlink() > 1 || (was.uid(), was.gid()) != (new.uid(), new.gid()))
}

#[cfg(not(unix))]
fn is_shared(_: &Path, _: &fs::Metadata) -> io::Result<bool> {
    Ok(false)
}
