//! Folders of results: each appears as a whole, and an earlier one is kept beside it.

use super::folders::open_plain_file;
use super::whole::{folder_of, new_part, remove_parts, sync_folder};
use phisindy_report::Folder;
use std::fmt;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Most names of other files that are told.
const NAMED: usize = 3;

/// A folder that can take a result.
#[derive(Debug)]
pub struct ResultFolder {
    path: PathBuf,
    /// The spec, if it lies in the folder under a name of its own: it stays there.
    spec: Option<PathBuf>,
}

/// Where a result was put.
#[derive(Debug, PartialEq)]
pub struct Kept {
    /// The folder of the result; `None` for a failure beside a result, which is not kept.
    pub at: Option<PathBuf>,
    /// The folder of the earlier result, if the new one took its place.
    pub earlier: Option<PathBuf>,
}

/// Why a folder takes no result.
#[derive(Debug)]
pub enum FolderError {
    /// It holds files that are no result, which a caller may allow.
    Occupied(String),
    /// It is none, or cannot be replaced.
    Unfit(String),
}

impl fmt::Display for FolderError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FolderError::Occupied(why) | FolderError::Unfit(why) => f.write_str(why),
        }
    }
}

impl std::error::Error for FolderError {}

/// How much the files of a result tell. A lesser result takes the place of no better one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Worth {
    /// A report about mistakes or a failure.
    Nothing,
    /// Of work that was stopped.
    Part,
    Whole,
}

impl Worth {
    /// That of a result, by its `result.json`.
    fn of(json: Option<&str>) -> Worth {
        match json.map(serde_json::from_str::<serde_json::Value>) {
            Some(Ok(result)) if result["stopped"] == false => Worth::Whole,
            Some(Ok(_)) => Worth::Part,
            _ => Worth::Nothing,
        }
    }
}

impl ResultFolder {
    /// Looks whether a result can be put there, before the work: everything that would refuse it then refuses
    /// it now. Other files in the folder are allowed by `force`; they stay in it.
    ///
    /// # Errors
    /// The folder is a link, a file, a disk of its own or the working folder, holds other files, or cannot be
    /// written.
    pub fn prepare(path: &Path, spec: Option<&Path>, force: bool) -> Result<ResultFolder, FolderError> {
        let shown = path.display();
        let unfit = |why: String| FolderError::Unfit(why);
        // Without a `/` at the end; `.` and `..` by their names.
        let path: PathBuf = match path.file_name() {
            Some(_) => path.components().collect(),
            None => {
                path.canonicalize().map_err(|e| unfit(format!("cannot find the folder `{shown}`: {e}")))?
            }
        };
        let cannot = |e: io::Error| {
            unfit(format!(
                "cannot write the folder `{shown}` beside what is in `{}`, to put it there as a whole: {e}",
                folder_of(&path).display()
            ))
        };
        let mut own = None;
        match path.symlink_metadata() {
            Err(_) => fs::create_dir_all(folder_of(&path)).map_err(cannot)?,
            Ok(data) if data.is_symlink() => {
                let to = fs::read_link(&path).unwrap_or_default();
                return Err(unfit(format!(
                    "`{shown}` is a link to `{}`: name that folder itself",
                    to.display()
                )));
            }
            Ok(data) if !data.is_dir() => return Err(unfit(format!("`{shown}` is a file, and no folder"))),
            Ok(data) if data.permissions().readonly() => {
                return Err(unfit(format!("`{shown}` is read-only")));
            }
            Ok(_) => {
                let inside = |of: &Path| {
                    let (of, path) = (of.canonicalize().ok()?, path.canonicalize().ok()?);
                    of.strip_prefix(path).map(Path::to_owned).ok()
                };
                let here = std::env::current_dir().ok().and_then(|here| inside(&here));
                if here.is_some() || path.parent().is_none() {
                    let what = match here {
                        Some(here) if here.as_os_str().is_empty() => "is",
                        _ => "holds",
                    };
                    return Err(unfit(format!(
                        "`{shown}` {what} the working folder: a result is a folder of its own, as in `found`"
                    )));
                }
                if is_mounted(&path) {
                    return Err(unfit(format!(
                        "`{shown}` is a disk of its own, which cannot be replaced: name a folder in it, `{}`",
                        path.join("found").display()
                    )));
                }
                own = spec.and_then(inside);
                if let Some(spec) = own.as_deref().filter(|spec| is_of_result(spec)) {
                    return Err(unfit(format!(
                        "`{shown}` holds the spec itself, `{}`, which its result would replace",
                        spec.display()
                    )));
                }
                let others = others(&path, own.as_deref());
                if !force && !others.is_empty() {
                    let names: Vec<String> =
                        others.iter().take(NAMED).map(|p| format!("`{}`", p.display())).collect();
                    let more = if others.len() > NAMED { ", ..." } else { "" };
                    return Err(FolderError::Occupied(format!(
                        "the folder `{shown}` holds what is no result: {}{more}",
                        names.join(", ")
                    )));
                }
            }
        }
        remove_parts(&path);
        new_folder(&path).and_then(|(part, _lock)| fs::remove_dir(part)).map_err(cannot)?;
        Ok(ResultFolder { path, spec: own })
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Puts the files of a result there: at every moment the folder holds the earlier result or the new one.
    ///
    /// # Errors
    /// The disk is full, or the folder was made impossible to replace; nothing of the earlier result is lost.
    pub fn put(&self, files: &Folder) -> io::Result<Kept> {
        let spec = self.spec.as_deref();
        let spec =
            spec.map(|spec| Ok::<_, io::Error>((spec, fs::read(self.path.join(spec))?))).transpose()?;
        let (part, _lock) = new_folder(&self.path)?;
        let put = written(files, spec, &part).and_then(|()| self.placed(files, &part));
        put.inspect_err(|_| drop(fs::remove_dir_all(&part)))
    }

    /// Puts what lies in `part` in its place.
    fn placed(&self, files: &Folder, part: &Path) -> io::Result<Kept> {
        let path = &self.path;
        // An empty folder is replaced; one that is not refuses it.
        #[cfg(windows)]
        let _ = fs::remove_dir(path);
        if !path.is_symlink() && fs::rename(part, path).is_ok() {
            sync_folder(folder_of(path));
            return Ok(Kept { at: Some(path.clone()), earlier: None });
        }
        let new =
            Worth::of(files.files.iter().find(|(name, _)| name == RESULT).map(|(_, text)| text.as_str()));
        let old = Worth::of(plain_text(&path.join(RESULT)).ok().as_deref());
        if new < old && new == Worth::Nothing {
            fs::remove_dir_all(part)?;
            return Ok(Kept { at: None, earlier: None });
        }
        let beside = self.beside(part)?;
        if new < old {
            sync_folder(folder_of(path));
            return Ok(Kept { at: Some(beside), earlier: None });
        }
        let Ok(earlier) = exchange(&beside, path).or_else(|_| {
            let earlier = self.beside(path)?;
            fs::rename(&beside, path).inspect_err(|_| drop(fs::rename(&earlier, path))).map(|()| earlier)
        }) else {
            return Ok(Kept { at: Some(beside), earlier: None });
        };
        // Other files stay where they were; what cannot stay is beside.
        for other in others(&earlier, self.spec.as_deref()) {
            let to = path.join(&other);
            if to.symlink_metadata().is_err() {
                let _ = to.parent().map_or(Ok(()), fs::create_dir_all);
                let _ = fs::rename(earlier.join(&other), to);
            }
        }
        let worthless = self.is_worthless(&earlier);
        if worthless {
            fs::rename(&earlier, part)?;
            // Another program may clean up at the same time.
            let _ = fs::remove_dir_all(part);
        }
        sync_folder(folder_of(path));
        Ok(Kept { at: Some(path.clone()), earlier: (!worthless).then_some(earlier) })
    }

    /// Whether a folder holds nothing but the spec and a report of this program about mistakes.
    fn is_worthless(&self, folder: &Path) -> bool {
        let names: Vec<_> =
            fs::read_dir(folder).into_iter().flatten().flatten().map(|e| e.file_name()).collect();
        let spec = self.spec.as_deref().map(Path::as_os_str);
        let report = plain_text(&folder.join(REPORT)).is_ok_and(|page| page.contains(GENERATOR));
        names
            .iter()
            .all(|name| Some(name.as_os_str()) == spec || report && (name == REPORT || name == "figures"))
    }

    /// Renames a folder to the first of `PATH.1`, `PATH.2`, ... that is free.
    fn beside(&self, from: &Path) -> io::Result<PathBuf> {
        renamed(from, |k| {
            let mut to = self.path.clone().into_os_string();
            to.push(format!(".{k}"));
            PathBuf::from(to)
        })
    }
}

/// Puts the files of a result into a new folder as a whole: the first of `path(1)`, `path(2)`, ... that is
/// free.
///
/// # Errors
/// The disk is full, or the folder cannot be written.
pub fn put_new(files: &Folder, path: impl Fn(usize) -> PathBuf) -> io::Result<PathBuf> {
    let first = path(1);
    remove_parts(&first);
    let (part, _lock) = new_folder(&first)?;
    let put = written(files, None, &part).and_then(|()| renamed(&part, path));
    let put = put.inspect_err(|_| drop(fs::remove_dir_all(&part)))?;
    sync_folder(folder_of(&put));
    Ok(put)
}

/// Writes the files of a result, and one more, into `part`.
fn written(files: &Folder, more: Option<(&Path, Vec<u8>)>, part: &Path) -> io::Result<()> {
    let write = |name: &Path, content: &[u8]| -> io::Result<()> {
        let path = part.join(name);
        fs::create_dir_all(folder_of(&path))?;
        let mut file = File::create_new(path)?;
        file.write_all(content)?;
        file.sync_all()
    };
    files.files.iter().try_for_each(|(name, text)| write(Path::new(name), text.as_bytes()))?;
    more.map_or(Ok(()), |(name, content)| write(name, &content))?;
    folders(files).for_each(|inner| sync_folder(&part.join(inner)));
    sync_folder(part);
    Ok(())
}

/// Renames a folder to the first of `path(1)`, `path(2)`, ... that is free.
fn renamed(from: &Path, path: impl Fn(usize) -> PathBuf) -> io::Result<PathBuf> {
    let mut why = io::Error::other("there are too many results beside it");
    for to in (1..10_000).map(path) {
        if to.symlink_metadata().is_err() {
            match fs::rename(from, &to) {
                Ok(()) => return Ok(to),
                // Another program was faster.
                Err(error) if to.exists() => why = error,
                Err(error) => return Err(error),
            }
        }
    }
    Err(why)
}

/// A new folder beside this path, and its lock. Windows opens no folders.
fn new_folder(path: &Path) -> io::Result<(PathBuf, Option<File>)> {
    new_part(path, |part| fs::create_dir(part).map(|()| File::open(part).ok()))
}

/// The file that tells what a result is worth.
const RESULT: &str = "result.json";
/// The file that every folder of this program has.
const REPORT: &str = "report.html";
/// How its head says who wrote it.
const GENERATOR: &str = "<meta name=\"generator\" content=\"phisindy ";

/// The text of a file; a pipe would be waited for.
fn plain_text(path: &Path) -> io::Result<String> {
    io::read_to_string(open_plain_file(path)?)
}

/// The folders in a result.
fn folders(files: &Folder) -> impl Iterator<Item = &str> {
    files.files.iter().filter_map(|(name, _)| Some(name.rsplit_once('/')?.0))
}

/// Whether a result may have a file of this name.
fn is_of_result(path: &Path) -> bool {
    path.to_str().is_some_and(|name| Folder::may_hold(&name.replace('\\', "/")))
}

/// What lies in a folder and is no result, without the spec.
fn others(folder: &Path, spec: Option<&Path>) -> Vec<PathBuf> {
    let names = |of: &Path| {
        let entries = fs::read_dir(folder.join(of)).into_iter().flatten().flatten();
        let mut names: Vec<PathBuf> = entries.map(|entry| of.join(entry.file_name())).collect();
        names.sort();
        names
    };
    let inner = |name: PathBuf| {
        let data = folder.join(&name).symlink_metadata();
        let ours = data.is_ok_and(|data| data.is_dir()) && name.to_str().is_some_and(Folder::may_hold_folder);
        if ours { names(&name) } else { vec![name] }
    };
    let all = names(Path::new("")).into_iter().flat_map(inner);
    let is_file = |name: &Path| folder.join(name).symlink_metadata().is_ok_and(|data| data.is_file());
    all.filter(|name| Some(name.as_path()) != spec && !(is_of_result(name) && is_file(name))).collect()
}

/// Whether another file system begins there.
#[cfg(unix)]
fn is_mounted(path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let disk = |path: &Path| path.metadata().map(|data| data.dev()).ok();
    disk(path) != disk(&path.join(".."))
}

#[cfg(not(unix))]
fn is_mounted(_: &Path) -> bool {
    false
}

/// Exchanges two folders in one step, and returns where the second one is now.
#[cfg(any(target_os = "linux", target_vendor = "apple"))]
fn exchange(new: &Path, old: &Path) -> io::Result<PathBuf> {
    use rustix::fs::{CWD, RenameFlags, renameat_with};
    renameat_with(CWD, new, CWD, old, RenameFlags::EXCHANGE)?;
    Ok(new.to_owned())
}

/// Elsewhere there is no such step: for a moment both lie beside.
#[cfg(not(any(target_os = "linux", target_vendor = "apple")))]
fn exchange(_: &Path, _: &Path) -> io::Result<PathBuf> {
    Err(io::ErrorKind::Unsupported.into())
}

#[cfg(test)]
mod tests;
