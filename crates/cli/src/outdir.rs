//! The folder of `--out`: made and tried before the work starts, written so that no half-written file is ever seen.

use anyhow::{Context, Result, bail};
use phisindy_report::spec_text::head;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// A folder that can be written to.
pub(crate) struct OutDir(PathBuf);

impl OutDir {
    /// Makes the folder if needed and tries to write into it.
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

    /// The folder.
    pub(crate) fn path(&self) -> &Path {
        &self.0
    }

    /// Writes a file: under another name first, so that it is there as a whole or not at all.
    pub(crate) fn write(&self, name: &str, content: &str) -> Result<()> {
        let (temporary, path) = (self.temporary(name), self.0.join(name));
        whole(&temporary, content)
            .and_then(|()| fs::rename(&temporary, &path))
            .inspect_err(|_| drop(fs::remove_file(&temporary)))
            .with_context(|| format!("cannot write `{}`{ELSEWHERE}", path.display()))
    }

    /// Refuses a folder with what another command found: together with this one's files nobody could tell which belong to which.
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

/// A file whose content is on the disk when this returns: a name must not point to less than the whole, even after a power cut.
fn whole(path: &Path, content: &str) -> io::Result<()> {
    let mut file = File::create(path)?;
    file.write_all(content.as_bytes())?;
    file.sync_all()
}

/// What to do where nothing can be written.
const ELSEWHERE: &str =
    " (make room or give yourself the right to write there, or choose another folder with --out)";

/// Refuses to replace a file unless that is asked for: it may hold hours of somebody's edits.
pub(crate) fn unless_there(path: &Path, force: bool) -> Result<()> {
    if path.exists() && !force {
        bail!(
            "`{}` is there already and is left as it is: choose another name, or replace it with --force",
            path.display()
        );
    }
    Ok(())
}

/// Writes a file beside the folder of `--out`, in place of what was there.
pub(crate) fn replace_file(path: &Path, content: &str) -> Result<()> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    OutDir(folder.to_owned()).write(&name, content)
}

/// One folder for each spec: the given one for a single spec, else one in it named after each.
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
