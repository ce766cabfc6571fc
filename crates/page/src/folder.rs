//! The working folder: files by plain names, read and written as a whole.

use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// Largest spec that is written (bytes): the reader of specs takes no larger one.
pub(crate) const LARGEST_SPEC: u64 = 1 << 20;

/// The folder that the page works in.
pub(crate) struct Working {
    path: PathBuf,
    /// Counts temporary files.
    next: AtomicU64,
}

impl Working {
    /// An existing folder.
    ///
    /// # Errors
    /// There is no such folder.
    pub(crate) fn open(path: &Path) -> io::Result<Working> {
        Ok(Working { path: path.canonicalize()?, next: AtomicU64::new(0) })
    }

    /// Its path.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// The path of a file in it.
    ///
    /// # Errors
    /// The name is not a plain one, or leads elsewhere by a link.
    pub(crate) fn file(&self, name: &str) -> Result<PathBuf, String> {
        if !plain(name) {
            return Err(format!("`{name}` is no plain name of a file"));
        }
        let path = self.path.join(name);
        match path.symlink_metadata() {
            Ok(data) if data.is_symlink() => {
                Err(format!("`{name}` is a link: only files in this folder are used"))
            }
            _ => Ok(path),
        }
    }

    /// Names of the files with one of these endings (without the point), in order; all but hidden ones for
    /// none.
    pub(crate) fn names(&self, endings: &[&str]) -> Vec<String> {
        let entries = fs::read_dir(&self.path).into_iter().flatten().flatten();
        let files = entries.filter(|e| e.file_type().is_ok_and(|t| t.is_file()));
        let names = files.filter_map(|e| e.file_name().into_string().ok()).filter(|name| plain(name));
        let mut all: Vec<String> = names.filter(|name| endings.contains(&ending(name).as_str())).collect();
        all.sort();
        all
    }

    /// Writes a file as a whole or not at all.
    ///
    /// # Errors
    /// In words: the name is not plain, the disk is full, the content breaks off or is longer than `most`
    /// bytes.
    pub(crate) fn write(&self, name: &str, content: &mut dyn Read, most: u64) -> Result<(), String> {
        let path = self.file(name)?;
        let part = self.part(name);
        let written = copied(content, &part, most).and_then(|()| fs::rename(&part, &path));
        written.map_err(|why| {
            let _ = fs::remove_file(&part);
            format!("cannot write `{name}`: {why}")
        })
    }

    /// Writes a file that is new: under this name, or a name like it where there is one with other content.
    ///
    /// # Errors
    /// As [`Working::write`].
    pub(crate) fn add(&self, name: &str, content: &mut dyn Read, most: u64) -> Result<String, String> {
        self.file(name)?;
        let part = self.part(name);
        let kept = copied(content, &part, most).map_err(|why| why.to_string()).and_then(|()| {
            let new = self.free(name, &part)?;
            fs::rename(&part, self.path.join(&new)).map_err(|why| why.to_string())?;
            Ok(new)
        });
        kept.map_err(|why| {
            let _ = fs::remove_file(&part);
            format!("cannot write `{name}`: {why}")
        })
    }

    /// A name like `name` under which there is no file, or the same one.
    fn free(&self, name: &str, content: &Path) -> Result<String, String> {
        let stem = stem(name);
        let end = name.strip_prefix(stem).unwrap_or_default();
        let names = std::iter::once(name.to_owned()).chain((2..1000).map(|k| format!("{stem}-{k}{end}")));
        for new in names {
            let path = self.file(&new)?;
            if !path.exists() || alike(&path, content) {
                return Ok(new);
            }
        }
        Err(format!("there are too many files called `{name}`"))
    }

    fn part(&self, name: &str) -> PathBuf {
        let k = self.next.fetch_add(1, Ordering::Relaxed);
        self.path.join(format!(".{name}.{}-{k}.part", std::process::id()))
    }
}

/// Whether this names a file in a folder, and nothing else on any system.
pub(crate) fn plain(name: &str) -> bool {
    let odd = |c: char| c.is_control() || "/\\:*?\"<>|".contains(c);
    !name.is_empty()
        && name.len() <= 200
        && !name.starts_with('.')
        && !name.ends_with(['.', ' '])
        && !name.contains(odd)
}

/// A name without its ending.
pub(crate) fn stem(name: &str) -> &str {
    name.rsplit_once('.').map_or(name, |(stem, _)| stem)
}

/// The ending of a name, in lower case.
pub(crate) fn ending(name: &str) -> String {
    name.rsplit_once('.').map(|(_, end)| end.to_lowercase()).unwrap_or_default()
}

fn copied(content: &mut dyn Read, path: &Path, most: u64) -> io::Result<()> {
    let mut file = File::create(path)?;
    if io::copy(&mut content.take(most + 1), &mut file)? > most {
        return Err(io::Error::other(format!("it is longer than {most} bytes")));
    }
    file.flush()?;
    file.sync_all()
}

/// Whether two files have the same content.
fn alike(a: &Path, b: &Path) -> bool {
    let size = |path: &Path| fs::metadata(path).map(|m| m.len()).ok();
    size(a) == size(b) && matches!((fs::read(a), fs::read(b)), (Ok(a), Ok(b)) if a == b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_nowhere_else() {
        for name in ["rig.csv", "a b.ron", "Messung 3.xlsx", "x"] {
            assert!(plain(name), "{name}");
        }
        for name in [
            "",
            ".",
            "..",
            "../rig.csv",
            "/etc/passwd",
            "a/b",
            "a\\b",
            "C:x",
            ".hidden",
            "a\0b",
            "a\nb",
            "x.",
        ] {
            assert!(!plain(name), "{name:?}");
        }
    }

    #[test]
    fn nothing_is_replaced_by_other_data() {
        let folder = tempfile::tempdir().unwrap();
        let working = Working::open(folder.path()).unwrap();
        let add = |text: &str| working.add("a.csv", &mut text.as_bytes(), 100);
        assert_eq!(add("one").unwrap(), "a.csv");
        assert_eq!(add("one").unwrap(), "a.csv");
        assert_eq!(add("two").unwrap(), "a-2.csv");
        assert!(add(&"x".repeat(101)).unwrap_err().contains("longer"));
        assert_eq!(working.names(&["csv"]), ["a-2.csv", "a.csv"]);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2, "no parts are left");
    }

    #[cfg(unix)]
    #[test]
    fn links_are_not_followed() {
        let (folder, other) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        fs::write(other.path().join("secret"), "s").unwrap();
        std::os::unix::fs::symlink(other.path().join("secret"), folder.path().join("a.csv")).unwrap();
        let working = Working::open(folder.path()).unwrap();
        assert!(working.file("a.csv").is_err() && working.write("a.csv", &mut "t".as_bytes(), 9).is_err());
        assert_eq!(fs::read_to_string(other.path().join("secret")).unwrap(), "s");
    }
}
