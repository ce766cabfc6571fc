//! The catalogue of laws on disk: built in, beside a spec, and in a folder that the user names.

use super::folders::open_plain_file;
use super::request::Request;
use crate::laws::{Catalogue, LawError};
use phisindy_expr::Span;
use phisindy_phys::{BUILT_IN, Diagnostic, Law, LawEntry, SourceId, Sources};
use std::fmt;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// Most bytes of a law.
const LONGEST: u64 = 1 << 16;
/// Most laws of a folder.
const MOST: usize = 1000;

/// All laws: built in, then those of each folder, which may replace earlier ones.
///
/// # Errors
/// A folder or one of its files cannot be read, or a file holds no law.
pub fn catalogue(folders: &[&Path]) -> Result<Catalogue, LawFolderError> {
    let mut all = Catalogue::built_in();
    for folder in folders {
        let paths = files_in(folder)
            .map_err(|error| LawFolderError::Folder { folder: folder.to_path_buf(), error })?;
        if paths.len() > MOST {
            return Err(LawFolderError::TooMany { folder: folder.to_path_buf(), laws: paths.len() });
        }
        for path in paths {
            let id = path.file_stem().map_or(String::new(), |s| s.to_string_lossy().into_owned());
            let text = text_of(&path, folder)?;
            all = all.with(&id, &text).map_err(|error| LawFolderError::Law { path, error })?;
        }
    }
    Ok(all)
}

/// The files of a folder of laws.
fn files_in(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let entries = std::fs::read_dir(folder)?;
    let mut paths: Vec<PathBuf> = entries.map(|e| e.map(|e| e.path())).collect::<Result<_, _>>()?;
    paths.retain(|p| p.extension().is_some_and(|e| e == "ron"));
    paths.sort();
    Ok(paths)
}

/// The files of the laws beside a spec and in the folder of the request.
pub fn law_files(spec: &Path, request: &Request) -> Vec<PathBuf> {
    folders(spec, request).iter().flat_map(|folder| files_in(folder).unwrap_or_default()).collect()
}

/// Whether a file holds a law that is built in, as it is.
pub(super) fn is_built_in(file: &Path) -> bool {
    std::fs::read_to_string(file).is_ok_and(|text| BUILT_IN.iter().any(|(_, own)| **own == text))
}

/// The laws that a spec may name: built in, in the folder `laws` beside it, in that of the request.
///
/// # Errors
/// As [`catalogue`].
pub fn beside(spec: &Path, request: &Request) -> Result<Catalogue, LawFolderError> {
    let folders = folders(spec, request);
    catalogue(&folders.iter().map(PathBuf::as_path).collect::<Vec<_>>())
}

/// Warnings about the laws of these folders: laws that they name and the catalogue does not hold, and files that stand
/// for a law that is built in.
pub fn doubts(folders: &[&Path], all: &Catalogue, sources: &mut Sources) -> Vec<Diagnostic> {
    let known: Vec<&str> = all.laws().iter().map(|entry| entry.id.as_str()).collect();
    let own = |entry: &&LawEntry| !BUILT_IN.iter().any(|(_, text)| **text == entry.text);
    let mut found = Vec::new();
    for entry in all.laws().iter().filter(own) {
        let file = folders.iter().map(|f| f.join(format!("{}.ron", entry.id))).find(|path| path.is_file());
        let name = file.map_or_else(|| entry.id.clone(), |path| path.display().to_string());
        let unknown = || Law::unknown_references(&entry.text, SourceId(sources.files.len()), &known);
        let mut warnings = unknown();
        if BUILT_IN.iter().any(|(id, _)| *id == entry.id) {
            let message = format!("`{}` stands for the law of this name that is built in", entry.id);
            let replaced = Diagnostic::warning(message)
                .at(SourceId(sources.files.len()), Span::default(), "this file is tried in its place")
                .help("rename the file if both are to be tried");
            warnings.push(replaced);
        }
        if !warnings.is_empty() {
            sources.add(name, entry.text.clone());
            found.extend(warnings);
        }
    }
    found
}

/// The folders of laws of a spec and of a request.
fn folders(spec: &Path, request: &Request) -> Vec<PathBuf> {
    let own = spec.parent().map(|p| p.join("laws")).filter(|p| p.is_dir());
    own.into_iter().chain(request.laws.clone()).collect()
}

/// The laws that a spec may name, as [`beside`]; mistakes are drawn in their files, doubts are added to
/// `found`.
///
/// # Errors
/// A law or its folder cannot be read: all mistakes.
pub(crate) fn checked_beside(
    spec: &Path,
    request: &Request,
    sources: &mut Sources,
    found: &mut Vec<Diagnostic>,
) -> Result<Catalogue, Vec<Diagnostic>> {
    let folders = folders(spec, request);
    let folders: Vec<&Path> = folders.iter().map(PathBuf::as_path).collect();
    let all = catalogue(&folders).map_err(|e| e.diagnostics(sources))?;
    found.extend(doubts(&folders, &all, sources));
    Ok(all)
}

/// The text of a law. The folder may come with somebody else's spec, so nothing is read that is not a file in
/// it.
fn text_of(path: &Path, folder: &Path) -> Result<String, LawFolderError> {
    let unreadable = |error: io::Error| LawFolderError::File { path: path.to_owned(), error };
    let (inside, real) =
        (path.canonicalize().map_err(unreadable)?, folder.canonicalize().map_err(unreadable)?);
    if !inside.starts_with(real) {
        return Err(LawFolderError::LeadsOut(path.to_owned()));
    }
    let mut text = String::new();
    let file = open_plain_file(path).map_err(unreadable)?;
    file.take(LONGEST + 1).read_to_string(&mut text).map_err(unreadable)?;
    if text.len() as u64 > LONGEST {
        return Err(LawFolderError::TooLong(path.to_owned()));
    }
    Ok(text)
}

/// Why there is no catalogue.
#[derive(Debug)]
#[non_exhaustive]
pub enum LawFolderError {
    /// A folder cannot be read.
    Folder {
        /// The folder.
        folder: PathBuf,
        /// Why.
        error: io::Error,
    },
    /// A folder holds more laws than anybody would write.
    TooMany {
        /// The folder.
        folder: PathBuf,
        /// Their number.
        laws: usize,
    },
    /// A file cannot be read.
    File {
        /// The file.
        path: PathBuf,
        /// Why.
        error: io::Error,
    },
    /// A file is a link to something outside of its folder.
    LeadsOut(PathBuf),
    /// A file is too long for a law.
    TooLong(PathBuf),
    /// A file holds no law.
    Law {
        /// The file.
        path: PathBuf,
        /// Why.
        error: LawError,
    },
}

impl fmt::Display for LawFolderError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            LawFolderError::Folder { folder, error } => {
                write!(f, "cannot read the folder of laws `{}`: {error}", folder.display())
            }
            LawFolderError::TooMany { folder, laws } => write!(
                f,
                "the folder of laws `{}` holds {laws} laws (at most {MOST}): take some out",
                folder.display()
            ),
            LawFolderError::File { path, error } => {
                write!(f, "cannot read the law `{}`: {error}", path.display())
            }
            LawFolderError::LeadsOut(path) => write!(
                f,
                "cannot read the law `{}`: it is a link that leads out of the folder of laws: copy the file into the folder",
                path.display()
            ),
            LawFolderError::TooLong(path) => write!(
                f,
                "cannot read the law `{}`: it is longer than {LONGEST} bytes: a law is a few lines of text",
                path.display()
            ),
            LawFolderError::Law { path, error } => {
                let said: Vec<&str> = error.mistakes.iter().map(|d| d.message.as_str()).collect();
                write!(f, "the law `{}` cannot be read: {}", path.display(), said.join("; "))
            }
        }
    }
}

impl LawFolderError {
    /// What is wrong, with the places in the text of a law, which is added to `sources`.
    pub fn diagnostics(&self, sources: &mut Sources) -> Vec<Diagnostic> {
        match self {
            LawFolderError::Law { path, error } => error.shown(&path.display().to_string(), sources),
            other => vec![Diagnostic::error(other.to_string())],
        }
    }
}

impl std::error::Error for LawFolderError {}
