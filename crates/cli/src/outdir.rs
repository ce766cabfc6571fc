//! What `--out` names: the folder of a result, which appears as a whole, or one in which files are written one
//! by one (`sweep`, `laws`, `man`), each as a whole.

use crate::args::Options;
use crate::terminal::remark;
use anyhow::{Context, Result, anyhow, bail};
use phisindy::files::{FolderError, Kept, ResultFolder, try_to_write, write_whole};
use phisindy_report::Folder;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

/// Refuses a result in the place of what is read for it.
pub(crate) fn unless_read(out: &Path, read: &Path) -> Result<()> {
    if out.canonicalize().is_ok_and(|out| read.canonicalize().is_ok_and(|read| read == out)) {
        bail!("--out: `{}` is what is read: choose another folder", out.display());
    }
    Ok(())
}

/// The folder of the result of one spec.
pub(crate) struct Results {
    folder: ResultFolder,
    quiet: bool,
}

impl Results {
    /// Looks before the work whether the result can be put there.
    pub(crate) fn prepare(path: &Path, spec: &Path, options: &Options) -> Result<Results> {
        unless_read(path, spec)?;
        let folder = ResultFolder::prepare(path, Some(spec), options.force).map_err(|why| match why {
            FolderError::Occupied(why) => {
                anyhow!("--out: {why}: choose another folder, or put the result among them with --force")
            }
            FolderError::Unfit(why) => anyhow!("--out: {why}: choose another folder"),
        })?;
        Ok(Results { folder, quiet: options.quiet })
    }

    /// The path of the folder.
    pub(crate) fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Puts the files there, says where an earlier result is now, and returns where this one is.
    pub(crate) fn put(&self, files: &Folder) -> Result<Option<PathBuf>> {
        let shown = self.path().display();
        let Kept { at, earlier } =
            self.folder.put(files).with_context(|| format!("cannot write `{shown}`{ELSEWHERE}"))?;
        let told = match (&at, &earlier) {
            (Some(_), Some(earlier)) => {
                Some(format!("the earlier result is kept in `{}`", earlier.display()))
            }
            (Some(at), None) if at != self.path() => {
                Some(format!("`{shown}` stays as it was; this result is kept in `{}`", at.display()))
            }
            (Some(_), None) => None,
            (None, _) => Some(format!("`{shown}` keeps its earlier result")),
        };
        told.iter().filter(|_| !self.quiet).for_each(|words| remark(words));
        Ok(at)
    }
}

/// A writable folder whose files are written one by one.
pub(crate) struct OutDir(PathBuf);

impl OutDir {
    /// Creates the folder if it does not exist, and tries to write into it.
    pub(crate) fn create(path: &Path) -> Result<OutDir> {
        fs::create_dir_all(path)
            .with_context(|| format!("cannot make the folder `{}` of --out{ELSEWHERE}", path.display()))?;
        try_to_write(path).with_context(|| {
            format!("cannot write into the folder `{}` of --out{ELSEWHERE}", path.display())
        })?;
        Ok(OutDir(path.to_owned()))
    }

    /// The path of the folder.
    pub(crate) fn path(&self) -> &Path {
        &self.0
    }

    /// Writes a file.
    pub(crate) fn write(&self, name: &str, content: impl AsRef<[u8]>) -> Result<()> {
        replace_file(&self.0.join(name), content)
    }

    /// Refuses a folder with files that are none of these, unless `force`; and links, which lead elsewhere.
    pub(crate) fn only(self, ours: impl Fn(&str) -> bool, force: bool) -> Result<OutDir> {
        let shown = self.0.display();
        if self.0.is_symlink() {
            bail!("--out: `{shown}` is a link: name the folder that it leads to");
        }
        for entry in fs::read_dir(&self.0).into_iter().flatten().flatten() {
            let (name, plain) = (entry.file_name(), entry.file_type().is_ok_and(|kind| kind.is_file()));
            let known = name.to_str().is_some_and(&ours);
            if known && !plain {
                bail!("--out: `{}` in `{shown}` is no plain file: choose another folder", name.display());
            }
            if !known && !force {
                bail!(
                    "--out: the folder `{shown}` holds what is no result: `{}`: choose another folder, or put the result among them with --force",
                    name.display()
                );
            }
        }
        Ok(self)
    }
}

/// Advice if nothing can be written.
const ELSEWHERE: &str =
    " (make room or give yourself the right to write there, or choose another folder with --out)";

/// Refuses to replace a file without `--force`: it may contain hours of edits.
pub(crate) fn unless_there(path: &Path, force: bool) -> Result<()> {
    if path.symlink_metadata().is_ok() && !force {
        bail!(
            "`{}` is there already and is left as it is: choose another name, or replace it with --force",
            path.display()
        );
    }
    Ok(())
}

/// Writes a file, or replaces it.
pub(crate) fn replace_file(path: &Path, content: impl AsRef<[u8]>) -> Result<()> {
    write_whole(path, content.as_ref())
        .with_context(|| format!("cannot write `{}`{ELSEWHERE}", path.display()))
}

/// The place of the result of each spec: `out` for a single spec, else a folder in it named after each spec.
pub(crate) fn places(out: &Path, specs: &[PathBuf], options: &Options) -> Result<Vec<Results>> {
    if let [spec] = specs {
        return Ok(vec![Results::prepare(out, spec, options)?]);
    }
    let places = names(specs).into_iter().zip(specs);
    places.map(|(name, spec)| Results::prepare(&out.join(name), spec, options)).collect()
}

/// The stem of each spec, or `STEM-N` where one before it has that: no two are alike.
fn names(specs: &[PathBuf]) -> Vec<OsString> {
    // The stem of `..ron` is `.`, another folder.
    let stem = |path: &PathBuf| {
        path.file_stem().filter(|s| *s != "." && *s != "..").map_or("spec".into(), OsString::from)
    };
    let stems: Vec<OsString> = specs.iter().map(stem).collect();
    let mut names: Vec<OsString> = Vec::new();
    for (k, stem) in stems.iter().enumerate() {
        let mut name = stem.clone();
        let mut n = 1;
        while stems[..k].contains(&name) || names.contains(&name) || n > 1 && stems.contains(&name) {
            n += 1;
            name.clone_from(stem);
            name.push(format!("-{n}"));
        }
        names.push(name);
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_specs_have_one_folder() {
        let of = |specs: &[&str]| names(&specs.iter().map(PathBuf::from).collect::<Vec<_>>());
        assert_eq!(of(&["d1/a.ron", "d1/a-2.ron", "d2/a.ron"]), ["a", "a-2", "a-3"]);
        assert_eq!(of(&["d1/a.ron", "d2/a.ron", "d1/a-2.ron"]), ["a", "a-3", "a-2"]);
        assert_eq!(of(&["a.ron", "a.ron", "a.ron"]), ["a", "a-2", "a-3"]);
        assert_eq!(of(&["..ron", "...ron", "b.ron"]), ["spec", "spec-2", "b"]);
    }
}
