//! The working folder: files by plain names, read and written as a whole.

use phisindy::files::open_plain_file;
use std::ffi::OsStr;
use std::fs::{self, File};
use std::hash::{BuildHasher, DefaultHasher, Hasher, RandomState};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{LazyLock, Mutex, PoisonError};
use std::time::Duration;

/// Longest name of a file (bytes): systems take 255, and what is written has a longer one until it is whole.
pub(crate) const LONGEST_NAME: usize = 200;
/// Largest spec that is written (bytes): the reader of specs takes no larger one.
pub(crate) const LARGEST_SPEC: u64 = 1 << 20;

/// The folder that the page works in.
pub(crate) struct Working {
    path: PathBuf,
    /// Counts temporary files.
    next: AtomicU64,
    /// Held by who gives a file its name.
    turn: Mutex<()>,
}

impl Working {
    /// An existing folder.
    ///
    /// # Errors
    /// There is no such folder.
    pub(crate) fn open(path: &Path) -> io::Result<Working> {
        let path = path.canonicalize()?;
        clean(&path);
        Ok(Working { path, next: AtomicU64::new(0), turn: Mutex::new(()) })
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
            return Err(format!(
                "`{}` is no name of a file that every system takes: give it another one",
                name.escape_debug()
            ));
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

    /// The version of a file: it changes with the content, whoever changes it. None without a file.
    pub(crate) fn version(&self, name: &str) -> Option<String> {
        version(&self.file(name).ok()?)
    }

    /// Writes a file, as a whole or not at all; its name and version.
    ///
    /// # Errors
    /// In words: the name is not plain, the disk is full, the content breaks off or is longer than `most`
    /// bytes. Or the file has changed.
    pub(crate) fn write(
        &self,
        name: &str,
        content: &mut dyn Read,
        most: u64,
        place: Place<'_>,
    ) -> Result<(String, String), Unwritten> {
        self.file(name).map_err(Unwritten::Because)?;
        let k = self.next.fetch_add(1, Ordering::Relaxed);
        let part = self.path.join(part_name(name, &k.to_string()));
        let because = |why: io::Error| Unwritten::Because(format!("cannot write `{name}`: {why}"));
        let written = copied(content, &part, most).map_err(because).and_then(|()| {
            // Between the look at what is there and the new name nobody else writes.
            let _turn = self.turn.lock().unwrap_or_else(PoisonError::into_inner);
            let new = self.placed(name, &part, place)?;
            let version = version(&part).unwrap_or_default();
            fs::rename(&part, self.path.join(&new)).map_err(because)?;
            Ok((new, version))
        });
        written.inspect_err(|_| drop(fs::remove_file(&part)))
    }

    /// Removes what this program has begun to write and no longer can.
    pub(crate) fn remove_own_parts(&self) {
        let own = |name: &OsStr| name.to_string_lossy().contains(OWN.as_str());
        remove_parts(&self.path, |part| part.file_name().is_some_and(own));
    }

    /// The name for this content.
    fn placed(&self, name: &str, content: &Path, place: Place<'_>) -> Result<String, Unwritten> {
        if let Place::Over(known) | Place::OverOrBeside(known) = place {
            let there = self.version(name);
            if there.as_deref().is_none_or(|there| there == known) || there == version(content) {
                return Ok(name.to_owned());
            }
        }
        if let Place::Over(_) = place {
            return Err(Unwritten::Changed);
        }
        for new in names_like(name) {
            let path = self.file(&new).map_err(Unwritten::Because)?;
            if path.symlink_metadata().is_err() || version(&path) == version(content) {
                return Ok(new);
            }
        }
        Err(Unwritten::Because(format!("there are too many files called `{name}`")))
    }
}

/// Where a file goes.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Place<'a> {
    /// In the place of the one of this version; a file that has gone is written again.
    Over(&'a str),
    /// Under this name, or a name like it where there is one with other content.
    Beside,
    /// In the place of the one of this version; beside it if it has changed.
    OverOrBeside(&'a str),
}

/// Why a file is not written.
#[derive(Debug)]
pub(crate) enum Unwritten {
    /// The file has another version.
    Changed,
    /// In words.
    Because(String),
}

/// What names of files end with that are not whole yet.
const PART: &str = ".part";
/// The part of their names that tells this process: in two containers with one folder programs may have the
/// same number.
static OWN: LazyLock<String> = LazyLock::new(|| {
    format!(".{}-{}-", std::process::id(), RandomState::new().build_hasher().finish() as u32)
});

/// The name of a file or a folder of this process until it is whole.
fn part_name(name: &str, k: &str) -> String {
    format!(".{name}{}{k}{PART}", OWN.as_str())
}

/// Removes what an earlier program, which was ended by force, has left in a folder: nobody takes a day to write
/// a file.
fn clean(folder: &Path) {
    remove_parts(folder, |part| {
        let age = part.symlink_metadata().and_then(|m| m.modified()).ok().and_then(|t| t.elapsed().ok());
        age.is_some_and(|age| age > Duration::from_secs(86_400))
    });
}

/// Removes those of the files and folders that are not whole yet.
fn remove_parts(folder: &Path, due: impl Fn(&Path) -> bool) {
    let is_part = |name: &str| name.starts_with('.') && name.ends_with(PART);
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if entry.file_name().to_str().is_some_and(is_part) && due(&path) {
            let _ = fs::remove_file(&path).or_else(|_| fs::remove_dir_all(&path));
        }
    }
}

/// Names of devices on Windows, with any ending.
const DEVICES: &[&str] = &["con", "prn", "aux", "nul", "conin$", "conout$"];

/// Whether this names a file in a folder, and nothing else on any system.
pub(crate) fn plain(name: &str) -> bool {
    // Marks of direction let a name look like another one.
    let turns = |c| matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    let odd = |c: char| c.is_control() || turns(c) || "/\\:*?\"<>|".contains(c);
    let first = name.split('.').next().unwrap_or_default().trim_end().to_lowercase();
    let port = ["com", "lpt"].iter().find_map(|port| first.strip_prefix(port));
    let device = DEVICES.contains(&first.as_str())
        || port.is_some_and(|k| {
            k.chars().count() == 1 && k.contains(|c: char| c.is_ascii_digit() || "¹²³".contains(c))
        });
    !name.is_empty()
        && name.len() <= LONGEST_NAME
        && !name.starts_with(['.', ' '])
        && !name.ends_with(['.', ' '])
        && !name.contains(odd)
        && !device
}

/// A name and others like it: `a.csv`, `a-2.csv`, `a-3.csv`, ...
pub(crate) fn names_like(name: &str) -> impl Iterator<Item = String> {
    let stem = stem(name);
    let end = name.strip_prefix(stem).unwrap_or_default();
    std::iter::once(name.to_owned()).chain((2..1000).map(move |k| format!("{stem}-{k}{end}")))
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
    let mut file = File::create_new(path)?;
    if io::copy(&mut content.take(most + 1), &mut file)? > most {
        return Err(io::Error::other(format!("it is longer than {most} bytes")));
    }
    file.sync_all()
}

/// What tells the contents of a file; none without a plain file.
fn version(path: &Path) -> Option<String> {
    let (mut file, mut hasher, mut piece) =
        (open_plain_file(path).ok()?, DefaultHasher::new(), vec![0; 1 << 16]);
    loop {
        match file.read(&mut piece).ok()? {
            0 => return Some(format!("\"{:016x}\"", hasher.finish())),
            n => hasher.write(&piece[..n]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_nowhere_else() {
        for name in ["rig.csv", "a b.ron", "Messung 3.xlsx", "x", "console.csv", "com10.ron", "größe.csv"] {
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
            "x ",
            " x",
            "CON",
            "nul.csv",
            "Com1.tar.gz",
            "lpt².ron",
            "aux .csv",
            "a\u{202e}vsc.exe",
            "a?b",
        ] {
            assert!(!plain(name), "{name:?}");
        }
    }

    #[test]
    fn names_have_a_length() {
        assert!(plain(&"x".repeat(LONGEST_NAME)) && !plain(&"x".repeat(LONGEST_NAME + 1)));
    }

    #[test]
    fn nothing_is_replaced_by_other_data() {
        let folder = tempfile::tempdir().unwrap();
        let working = Working::open(folder.path()).unwrap();
        let add = |text: &str| working.write("a.csv", &mut text.as_bytes(), 100, Place::Beside);
        assert_eq!(add("one").unwrap().0, "a.csv");
        assert_eq!(add("one").unwrap().0, "a.csv");
        assert_eq!(add("two").unwrap().0, "a-2.csv");
        assert!(
            matches!(add(&"x".repeat(101)).unwrap_err(), Unwritten::Because(why) if why.contains("longer"))
        );
        assert_eq!(working.names(&["csv"]), ["a-2.csv", "a.csv"]);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2, "no parts are left");
    }

    #[test]
    fn of_two_writers_none_loses_an_edit() {
        let folder = tempfile::tempdir().unwrap();
        let working = Working::open(folder.path()).unwrap();
        let write = |text: &str, place| working.write("a.ron", &mut text.as_bytes(), 100, place);
        let (_, first) = write("one", Place::Over("")).unwrap();
        assert_eq!(working.version("a.ron").as_ref(), Some(&first));
        let (_, second) = write("two", Place::Over(&first)).unwrap();
        assert!(first != second);
        assert!(matches!(write("mine", Place::Over(&first)).unwrap_err(), Unwritten::Changed));
        assert!(matches!(write("mine", Place::Over("")).unwrap_err(), Unwritten::Changed));
        assert_eq!(fs::read_to_string(folder.path().join("a.ron")).unwrap(), "two");
        // The same text is no conflict, and what is kept beside has a name of its own.
        assert_eq!(write("two", Place::Over(&first)).unwrap().1, second);
        assert_eq!(write("mine", Place::OverOrBeside(&first)).unwrap().0, "a-2.ron");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2, "no parts are left");
        fs::remove_file(folder.path().join("a.ron")).unwrap();
        assert_eq!(write("again", Place::Over(&second)).unwrap().0, "a.ron");
    }

    #[cfg(unix)]
    #[test]
    fn links_are_not_followed() {
        let (folder, other) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        fs::write(other.path().join("secret"), "s").unwrap();
        std::os::unix::fs::symlink(other.path().join("secret"), folder.path().join("a.csv")).unwrap();
        let working = Working::open(folder.path()).unwrap();
        assert!(
            working.file("a.csv").is_err()
                && working.write("a.csv", &mut "t".as_bytes(), 9, Place::Over("")).is_err()
        );
        assert_eq!(fs::read_to_string(other.path().join("secret")).unwrap(), "s");
    }

    #[test]
    fn what_an_earlier_program_left_goes_after_a_day() {
        let folder = tempfile::tempdir().unwrap();
        for (name, hours) in
            [(".a.csv.1-2-3.part", 25), (".b.csv.1-2-3.part", 1), (".c.csv", 25), ("d.part", 25)]
        {
            let file = File::create(folder.path().join(name)).unwrap();
            file.set_modified(std::time::SystemTime::now() - Duration::from_secs(3600 * hours)).unwrap();
        }
        Working::open(folder.path()).unwrap();
        let left = fs::read_dir(folder.path()).unwrap().flatten().map(|entry| entry.file_name());
        let mut left: Vec<String> = left.map(|name| name.into_string().unwrap()).collect();
        left.sort();
        assert_eq!(left, [".b.csv.1-2-3.part", ".c.csv", "d.part"]);
    }
}
