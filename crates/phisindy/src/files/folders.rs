//! Finds data files in `--data`, then `PHISINDY_DATA`, then beside the spec, never outside these folders, and
//! opens them.

use super::request::{Naming, Request};
use phisindy_expr::Span;
use phisindy_import::{DataFile, numbers, record, unreadable};
use phisindy_phys::spec::{self, CsvSpec, DataSpec, InputSpec, Text};
use phisindy_phys::{
    Diagnostic, Files, NamedFile, SourceId, Sources, Table, Units, named_files as spec_files,
};
use phisindy_report::spec_text::named_data;
use std::fs::File;
use std::io;
use std::path::{Component, Path, PathBuf};

/// Opens a plain file. Pipes and devices are refused: reading them may block or never end.
///
/// # Errors
/// The path is no plain file, or it cannot be opened.
pub fn open_plain_file(path: &Path) -> io::Result<File> {
    // Checked before opening: opening a pipe waits for a writer.
    let kind = std::fs::metadata(path)?.file_type();
    if kind.is_dir() {
        return Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a folder"));
    }
    if !kind.is_file() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "it is a pipe or a device, not a file"));
    }
    File::open(path)
}

/// Opens a data file for the readers; messages call it `name`, and `at` is where the user named it.
///
/// # Errors
/// As [`open_plain_file`].
pub fn opened<'a>(path: &Path, name: &'a str, at: (SourceId, Span)) -> Result<DataFile<'a>, Box<Diagnostic>> {
    let file = open_plain_file(path).and_then(|file| Ok((file.metadata()?.len(), file)));
    match file {
        Ok((size, file)) => Ok(DataFile::new(name, file, size)),
        Err(e) => Err(Box::new(unreadable(name, at, &e))),
    }
}

/// Reads the columns of the record `csv` from the file at `path`. Returns the table and warnings.
///
/// # Errors
/// As [`open_plain_file`], and as [`record`].
pub(crate) fn read(
    csv: &CsvSpec,
    units: &Units,
    path: &Path,
    spec: SourceId,
    sources: &mut Sources,
) -> Result<(Table, Vec<Diagnostic>), Vec<Diagnostic>> {
    let name = path.display().to_string();
    let file = opened(path, &name, (spec, csv.path.span)).map_err(|d| vec![*d])?;
    record(csv, units, file, spec, sources)
}

/// The data files that a spec names and that are there, in its order, each once: as it names them, and where they are.
/// A result depends on them beside the text.
pub fn named_files(text: &str, path: &Path, request: &Request) -> Vec<(String, PathBuf)> {
    let folders = Folders::new(request, path, text);
    let Ok((spec, _)) = spec::read_without_files(text, SourceId(0)) else { return vec![] };
    let inputs = |record: &DataSpec| -> Vec<Text> {
        match record {
            DataSpec::Csv(csv) => {
                let of_streams = csv.streams.iter().filter_map(|stream| stream.path.clone());
                [csv.path.clone()].into_iter().chain(of_streams).collect()
            }
            DataSpec::Synthetic(made) => made
                .inputs
                .iter()
                .filter_map(|(_, input)| match input {
                    InputSpec::File { path, .. } => Some(path.clone()),
                    _ => None,
                })
                .collect(),
        }
    };
    let mut all: Vec<(String, PathBuf)> = Vec::new();
    let beside = spec_files(text).into_iter().map(|file| Text { value: file.path, span: file.span });
    for name in beside.chain(spec.data.iter().flat_map(inputs)) {
        if all.iter().all(|(other, _)| *other != name.value) {
            let found = folders.find(&name.value, SourceId(0), name.span);
            all.extend(found.ok().map(|path| (name.value, path)));
        }
    }
    all
}

/// The numbers of the files that a spec names beside its records, which lie where its data files do.
///
/// # Errors
/// A file is not found, or holds something else.
pub fn named_numbers(
    text: &str,
    path: &Path,
    request: &Request,
    source: SourceId,
) -> Result<Files, Vec<Diagnostic>> {
    Folders::new(request, path, text).numbers(text, source)
}

/// Folders of data files, in the order in which they are searched.
pub(crate) struct Folders {
    folders: Vec<(PathBuf, &'static str)>,
    /// Whether the user named one.
    pub(crate) given: bool,
    naming: Naming,
}

impl Folders {
    /// The folders for a spec, last those that its head names if this program wrote it.
    pub(crate) fn new(request: &Request, spec: &Path, text: &str) -> Folders {
        let mut folders = Vec::new();
        folders.extend(request.data.iter().map(|d| (d.clone(), "--data")));
        folders.extend(request.further_data.iter().map(|d| (d.clone(), "PHISINDY_DATA")));
        let given = !folders.is_empty();
        let beside = spec.parent().map(Path::to_owned).unwrap_or_default();
        folders.push((beside.clone(), "beside the spec"));
        let named = match &request.named_data {
            Some(named) => named.iter().map(String::as_str).collect(),
            None => named_data(text),
        };
        folders
            .extend(named.into_iter().map(|folder| (beside.join(folder), "named in the head of the spec")));
        Folders { folders, given, naming: request.naming }
    }

    /// The numbers of the files that a spec names beside its records.
    ///
    /// # Errors
    /// A file is not found, or holds something else.
    pub(crate) fn numbers(&self, text: &str, source: SourceId) -> Result<Files, Vec<Diagnostic>> {
        let read = |file: NamedFile| {
            let found = self.find(&file.path, source, file.span).map_err(Missing::diagnostic)?;
            let opened = opened(&found, &file.path, (source, file.span)).map_err(|d| *d)?;
            let numbers = numbers(opened, file.array.as_deref(), (source, file.span)).map_err(|d| *d)?;
            Ok((file, numbers))
        };
        let (mut all, mut wrong) = (vec![], vec![]);
        for found in spec_files(text).into_iter().map(read) {
            match found {
                Ok(found) => all.push(found),
                Err(why) => wrong.push(why),
            }
        }
        if wrong.is_empty() { Ok(all.into_iter().collect()) } else { Err(wrong) }
    }

    /// The file of this name, which stands at `at` in the spec.
    ///
    /// # Errors
    /// It is in none of the folders (`Missing::Nowhere`), or it leads out of its folder.
    pub(crate) fn find(&self, name: &str, spec: SourceId, at: Span) -> Result<PathBuf, Missing> {
        let plain =
            Path::new(name).components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir));
        if !plain {
            let d = Diagnostic::error(format!("`{name}` leads out of the data folder")).at(spec, at, "");
            return Err(Missing::Refused(
                d.help(format!("name the file alone, and its folder {}", self.naming.how())),
            ));
        }
        for (folder, _) in &self.folders {
            let Some(path) = data_file(folder, name) else { continue };
            let root = if folder.as_os_str().is_empty() { Path::new(".") } else { folder.as_path() };
            match (root.canonicalize(), path.canonicalize()) {
                (Ok(root), Ok(real)) if real.starts_with(&root) => return Ok(path),
                _ => {
                    let d = Diagnostic::error(format!(
                        "`{}` is a link that leads out of the data folder",
                        path.display()
                    ));
                    let d = d.at(spec, at, "asked for here");
                    return Err(Missing::Refused(d.help(format!(
                        "copy the file into the folder, or name its real folder {}",
                        self.naming.how()
                    ))));
                }
            }
        }
        let mut d =
            Diagnostic::error(format!("there is no data file `{name}`")).at(spec, at, "asked for here");
        for (folder, why) in &self.folders {
            let shown = if folder.as_os_str().is_empty() { ".".into() } else { folder.display().to_string() };
            let missing =
                if folder.as_os_str().is_empty() || folder.is_dir() { "" } else { ", which is no folder" };
            d = d.help(format!("looked in `{shown}` ({why}{missing})"));
        }
        Err(Missing::Nowhere(d.help(self.naming.help())))
    }
}

/// The file of this name in a folder. A spec is UTF-8 text: of a name that is not, it holds the readable part.
pub fn data_file(folder: &Path, name: &str) -> Option<PathBuf> {
    let path = folder.join(name);
    if path.exists() || !name.contains(char::REPLACEMENT_CHARACTER) {
        return path.exists().then_some(path);
    }
    let entries = std::fs::read_dir(super::whole::folder_of(&path)).ok()?.flatten();
    let shown = path.file_name()?;
    entries.map(|entry| entry.path()).find(|p| p.file_name().is_some_and(|n| *n.to_string_lossy() == *shown))
}

/// Why there is no file.
pub(crate) enum Missing {
    /// Looked for and not found.
    Nowhere(Diagnostic),
    /// Not allowed.
    Refused(Diagnostic),
}

impl Missing {
    /// What to tell the user.
    pub(crate) fn diagnostic(self) -> Diagnostic {
        match self {
            Missing::Nowhere(d) | Missing::Refused(d) => d,
        }
    }
}
