//! Output: folders whose files are written completely or not at all, and standard output.

use anyhow::{Context, Result};
use phisindy::files::write_whole;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// A folder that can be written to.
pub(crate) struct Folder(PathBuf);

impl Folder {
    /// Makes the folder if needed.
    ///
    /// # Errors
    /// It cannot be made.
    pub(crate) fn create(path: &Path) -> Result<Folder> {
        fs::create_dir_all(path).with_context(|| format!("cannot make the folder `{}`", path.display()))?;
        Ok(Folder(path.to_owned()))
    }

    /// The folder.
    pub(crate) fn path(&self) -> &Path {
        &self.0
    }

    /// Writes a file.
    ///
    /// # Errors
    /// It cannot be written.
    pub(crate) fn write(&self, name: &str, content: &str) -> Result<()> {
        replace(&self.0.join(name), content)
    }
}

/// Writes a file under another name first, then renames it.
///
/// # Errors
/// It cannot be written.
pub(crate) fn replace(path: &Path, content: &str) -> Result<()> {
    write_whole(path, content.as_bytes()).with_context(|| format!("cannot write `{}`", path.display()))
}

/// Copies a folder and all that is in it.
///
/// # Errors
/// A file cannot be read or written.
pub(crate) fn copy(from: &Path, to: &Path) -> Result<()> {
    fs::create_dir_all(to).with_context(|| format!("cannot make the folder `{}`", to.display()))?;
    for entry in fs::read_dir(from).with_context(|| format!("cannot read `{}`", from.display()))? {
        let (path, target) = entry.map(|e| (e.path(), to.join(e.file_name())))?;
        if path.is_dir() {
            copy(&path, &target)?;
        } else {
            fs::copy(&path, &target).with_context(|| format!("cannot write `{}`", target.display()))?;
        }
    }
    Ok(())
}

/// Prints the result.
///
/// # Errors
/// Standard output cannot be written.
pub(crate) fn print(text: &str) -> Result<()> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).context("cannot write to standard output")
}
