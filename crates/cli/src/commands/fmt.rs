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
            Ok((text, new)) if new != text => replace(file, &new)?,
            Ok(_) => {}
        }
    }
    Ok(code)
}

/// The text of standard input, as far as it can be a spec.
fn standard_input() -> Result<String, Diagnostic> {
    let mut text = String::new();
    let read = io::stdin().lock().take((1 << 20) + 1).read_to_string(&mut text);
    read.map(|_| text).map_err(|error| Diagnostic::error(format!("cannot read standard input: {error}")))
}

/// Replaces a file as a whole. A link leads to it still, and who may read it may do so still.
fn replace(path: &Path, text: &str) -> Result<()> {
    let shown = path.display();
    let write = || {
        let file = path.canonicalize()?;
        let rights = fs::metadata(&file)?.permissions();
        if rights.readonly() {
            return Err(io::ErrorKind::PermissionDenied.into());
        }
        write_whole(&file, text.as_bytes())?;
        fs::set_permissions(&file, rights)
    };
    write().with_context(|| format!("cannot write `{shown}`, which is left as it was"))
}
