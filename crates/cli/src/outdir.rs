//! The folder of `--out`: created and tested before the work starts. A file appears in it as a whole or not
//! at all.

use anyhow::{Context, Result, bail};
use phisindy_report::spec_text::head;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// A writable folder.
pub(crate) struct OutDir(PathBuf);

impl OutDir {
    /// Creates the folder if it does not exist, and tries to write into it.
    pub(crate) fn create(path: &Path) -> Result<OutDir> {
        fs::create_dir_all(path)
            .with_context(|| format!("cannot make the folder `{}` of --out{ELSEWHERE}", path.display()))?;
        let dir = OutDir(path.to_owned());
        let probe = dir.temporary("probe");
        fs::write(&probe, b"").and_then(|()| fs::remove_file(&probe)).with_context(|| {
            format!("cannot write into the folder `{}` of --out{ELSEWHERE}", path.display())
        })?;
        Ok(dir)
    }

    /// The path of the folder.
    pub(crate) fn path(&self) -> &Path {
        &self.0
    }

    /// Writes a file, first under another name, so that it appears as a whole or not at all.
    pub(crate) fn write(&self, name: &str, content: impl AsRef<[u8]>) -> Result<()> {
        let (temporary, path) = (self.temporary(name), self.0.join(name));
        whole(&temporary, content.as_ref())
            .and_then(|()| fs::rename(&temporary, &path))
            .inspect_err(|_| drop(fs::remove_file(&temporary)))
            .with_context(|| format!("cannot write `{}`{ELSEWHERE}", path.display()))
    }

    /// Refuses a folder with the results of another command: mixed results could not be told apart.
    pub(crate) fn without(&self, other: &str, name: &str) -> Result<()> {
        let path = self.0.join(name);
        let ours = fs::read_to_string(&path).is_ok_and(|text| text.starts_with(&head(other)));
        if ours {
            bail!(
                "the folder `{}` of --out holds what `phisindy {other}` found ({name}): choose another one, or delete it",
                self.0.display()
            );
        }
        Ok(())
    }

    fn temporary(&self, name: &str) -> PathBuf {
        self.0.join(format!(".{name}.{}.part", std::process::id()))
    }
}

/// Writes a file and flushes it to the disk, so that even after a power cut no name points to a part of a
/// file.
fn whole(path: &Path, content: &[u8]) -> io::Result<()> {
    let mut file = File::create(path)?;
    file.write_all(content)?;
    file.sync_all()
}

/// Advice if nothing can be written.
const ELSEWHERE: &str =
    " (make room or give yourself the right to write there, or choose another folder with --out)";

/// Refuses to replace a file without `--force`: it may contain hours of edits.
pub(crate) fn unless_there(path: &Path, force: bool) -> Result<()> {
    if path.exists() && !force {
        bail!(
            "`{}` is there already and is left as it is: choose another name, or replace it with --force",
            path.display()
        );
    }
    Ok(())
}

/// Writes a file, or replaces it.
pub(crate) fn replace_file(path: &Path, content: impl AsRef<[u8]>) -> Result<()> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    OutDir(folder.to_owned()).write(&name, content)
}

/// One folder for each spec: `out` for a single spec, else a folder in it named after each spec.
pub(crate) fn folders(out: &Path, specs: &[PathBuf]) -> Result<Vec<OutDir>> {
    let name = |k: usize| {
        let stem =
            |p: &PathBuf| p.file_stem().map_or("spec".to_owned(), |s| s.to_string_lossy().into_owned());
        let own = stem(&specs[k]);
        let same = specs[..k].iter().filter(|p| stem(p) == own).count();
        if same == 0 { own } else { format!("{own}-{}", same + 1) }
    };
    (0..specs.len())
        .map(|k| OutDir::create(&if specs.len() == 1 { out.to_owned() } else { out.join(name(k)) }))
        .collect()
}
