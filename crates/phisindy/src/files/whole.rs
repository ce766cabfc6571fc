//! Files that appear as a whole or not at all, whenever the program ends.

use std::ffi::{OsStr, OsString};
use std::fs::{self, File, TryLockError};
use std::hash::{BuildHasher, Hasher, RandomState};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// The ending of what is still being written.
const PART: &str = ".part";

/// Writes a file, first under another name beside it. What a killed program left of this file is removed.
///
/// # Errors
/// The disk is full, or the folder cannot be written.
pub fn write_whole(path: &Path, content: &[u8]) -> io::Result<()> {
    remove_parts(path);
    let (part, mut file) = new_part(path, |part| File::create_new(part))?;
    let written = file.write_all(content).and_then(|()| {
        // Without it a power cut may leave a name of half a file.
        file.sync_all()?;
        fs::rename(&part, path)
    });
    written.inspect_err(|_| drop(fs::remove_file(&part)))?;
    sync_folder(folder_of(path));
    Ok(())
}

/// Tries to write into a folder; what a killed program left of such a trial is removed.
///
/// # Errors
/// The folder cannot be written.
pub fn try_to_write(folder: &Path) -> io::Result<()> {
    let trial = folder.join("trial");
    remove_parts(&trial);
    let (part, _lock) = new_part(&trial, |part| File::create_new(part))?;
    fs::remove_file(&part)
}

/// Begins a file or a folder under a name of its own beside `path`. It is locked as long as what `create`
/// returned lives.
///
/// # Errors
/// The path has no last name, or the folder cannot be written.
pub(super) fn new_part<T: Lock>(
    path: &Path,
    create: impl Fn(&Path) -> io::Result<T>,
) -> io::Result<(PathBuf, T)> {
    let name = path.file_name().ok_or(io::ErrorKind::InvalidInput)?;
    for _ in 0..TRIALS {
        // Programs in two containers may share a folder and have the same number.
        let random = RandomState::new().build_hasher().finish() as u32;
        let mut hidden = hidden(name);
        hidden.push(format!("{}-{random}{PART}", std::process::id()));
        let part = folder_of(path).join(hidden);
        match create(&part) {
            // Another program may have cleaned up between the name and the lock.
            Ok(made) if made.is_taken() || part.symlink_metadata().is_err() => {}
            Ok(made) => return Ok((part, made)),
            Err(why) if why.kind() == io::ErrorKind::AlreadyExists => {}
            Err(why) => return Err(why),
        }
    }
    Err(io::Error::other("another program takes every name"))
}

/// Most names that are tried.
const TRIALS: usize = 100;

/// What can be locked.
pub(super) trait Lock {
    /// Locks it, and returns whether another program holds it. A file system without locks is no reason not to
    /// work.
    fn is_taken(&self) -> bool;
}

impl Lock for File {
    fn is_taken(&self) -> bool {
        matches!(self.try_lock(), Err(TryLockError::WouldBlock))
    }
}

impl Lock for Option<File> {
    fn is_taken(&self) -> bool {
        self.as_ref().is_some_and(File::is_taken)
    }
}

/// Removes what killed programs left of a file or a folder. What a program still writes is locked.
pub(super) fn remove_parts(path: &Path) {
    let Some(start) = path.file_name().map(hidden) else { return };
    for entry in fs::read_dir(folder_of(path)).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let number = name.as_encoded_bytes().strip_prefix(start.as_encoded_bytes());
        let number = number.and_then(|rest| rest.strip_suffix(PART.as_bytes()));
        if number.is_some_and(|n| !n.is_empty() && n.iter().all(|b| b.is_ascii_digit() || *b == b'-'))
            // A pipe would be waited for.
            && entry.file_type().is_ok_and(|kind| kind.is_file() || kind.is_dir())
            // Held while it is removed. Windows opens no folders: there a folder is left where it is.
            && let Ok(lock) = File::open(entry.path())
            && !lock.is_taken()
        {
            let _ = fs::remove_file(entry.path()).or_else(|_| fs::remove_dir_all(entry.path()));
        }
    }
}

/// `.NAME.`
fn hidden(name: &OsStr) -> OsString {
    let mut hidden = OsString::from(".");
    hidden.push(name);
    hidden.push(".");
    hidden
}

/// The folder of a path, which has a name.
pub(super) fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Makes new names in a folder outlast a power cut, where the system can.
pub(super) fn sync_folder(folder: &Path) {
    let _ = File::open(folder).and_then(|folder| folder.sync_all());
}
