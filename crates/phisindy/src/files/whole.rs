//! Files that appear as a whole or not at all, whenever the program ends.

use std::ffi::{OsStr, OsString};
use std::fs::{self, File, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// The ending of what is still being written.
const PART: &str = ".part";

/// Writes a file, first under another name beside it. What a killed program left of this file is removed.
///
/// # Errors
/// The disk is full, or the folder cannot be written.
pub fn write_whole(path: &Path, content: &[u8]) -> io::Result<()> {
    let part = part_of(path)?;
    remove_parts(path);
    let written = File::create(&part).and_then(|mut file| {
        // A file system without locks is no reason not to work.
        let _ = file.try_lock();
        file.write_all(content)?;
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
    let part = part_of(&trial)?;
    File::create(&part).and_then(|_| fs::remove_file(&part))
}

/// The name under which this process writes a file or a folder until it is whole.
///
/// # Errors
/// The path has no last name.
pub(super) fn part_of(path: &Path) -> io::Result<PathBuf> {
    let name = path.file_name().ok_or(io::ErrorKind::InvalidInput)?;
    let mut hidden = hidden(name);
    hidden.push(format!("{}{PART}", std::process::id()));
    Ok(folder_of(path).join(hidden))
}

/// Removes what killed programs left of a file or a folder. What a program still writes is locked.
pub(super) fn remove_parts(path: &Path) {
    let Some(start) = path.file_name().map(hidden) else { return };
    for entry in fs::read_dir(folder_of(path)).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let digits = name.as_encoded_bytes().strip_prefix(start.as_encoded_bytes());
        let digits = digits.and_then(|rest| rest.strip_suffix(PART.as_bytes()));
        if digits.is_some_and(|d| !d.is_empty() && d.iter().all(u8::is_ascii_digit))
            && unlocked(&entry.path())
        {
            let _ = fs::remove_file(entry.path()).or_else(|_| fs::remove_dir_all(entry.path()));
        }
    }
}

/// Whether no program writes there. Windows opens no folders: there a folder is left where it is.
fn unlocked(part: &Path) -> bool {
    File::open(part).is_ok_and(|file| !matches!(file.try_lock(), Err(TryLockError::WouldBlock)))
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
