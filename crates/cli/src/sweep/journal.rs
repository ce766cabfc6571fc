//! Finished runs, kept in a file line by line, so that a sweep can go on after an interruption.

use super::design::Design;
use anyhow::{Context, Result, anyhow, bail};
use phisindy::files::open_plain_file;
use phisindy_report::sweep::Run;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::Path;

/// The name of the file in the folder of `--out`, where one program does the whole sweep.
pub(crate) const NAME: &str = "sweep.jsonl";

/// The word that a header has for `journal`.
const KIND: &str = "phisindy sweep";

/// First line of the file: which case the runs are of. Another one follows where the sweep became larger.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Header {
    journal: String,
    spec: String,
    version: String,
    fingerprint: String,
    #[serde(default)]
    design: Design,
}

/// A line of the file.
#[derive(Deserialize)]
#[serde(untagged)]
enum Line {
    Header(Header),
    Run(Run),
}

/// What a journal that is only read holds.
pub(crate) struct Kept {
    /// Name of the spec.
    pub(crate) spec: String,
    /// What all runs depend on, in short.
    pub(crate) fingerprint: String,
    /// The whole sweep.
    pub(crate) design: Design,
    /// Finished runs.
    pub(crate) runs: Vec<Run>,
}

impl Kept {
    /// What the bytes of a journal hold; messages call it `shown`.
    ///
    /// # Errors
    /// It is none, or is damaged.
    pub(crate) fn of(text: &[u8], shown: &str) -> Result<Kept> {
        let (header, runs) = lines(&text[..whole(text)], shown)?;
        let Header { spec, fingerprint, design, .. } = header.ok_or_else(|| foreign(shown))?;
        if design == Design::default() {
            bail!("`{shown}` is of an earlier version, which did not keep what a merge needs: sweep again");
        }
        if !design.makes_sense() {
            bail!(
                "the first lines of `{shown}` are damaged: the sweep that they tell of cannot be one; sweep again"
            );
        }
        Ok(Kept { spec, fingerprint, design, runs })
    }
}

/// Finished runs, by cell and seed.
#[derive(Debug, Default)]
pub(crate) struct Journal {
    file: Option<File>,
    runs: HashMap<(String, u64), Run>,
}

impl Journal {
    /// Opens a journal in a folder, or starts one. `what` is all that the runs depend on, except for cell and
    /// seed.
    ///
    /// # Errors
    /// It holds runs of another case, is damaged, is in use, or cannot be read or written.
    pub(crate) fn open(
        folder: &Path,
        name: &str,
        spec: &str,
        what: &[u8],
        design: &Design,
    ) -> Result<Journal> {
        let path = folder.join(name);
        let shown = path.display().to_string();
        let open = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&path);
        let mut file = open.with_context(|| format!("cannot open `{shown}`"))?;
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => {
                bail!("another sweep is writing `{shown}`; give this one another --out")
            }
            // A file system without locks is no reason not to work.
            Err(TryLockError::Error(_)) | Ok(()) => {}
        }
        let mut text = Vec::new();
        file.read_to_end(&mut text).with_context(|| format!("cannot read `{shown}`"))?;
        let header = Header {
            journal: KIND.to_owned(),
            spec: spec.to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            fingerprint: format!(
                "{:016x}",
                fingerprint(&[concat!(env!("CARGO_PKG_VERSION"), "\n").as_bytes(), what].concat())
            ),
            design: design.clone(),
        };
        let whole = whole(&text);
        if whole == 0 {
            // The first line may be torn too; anything else is somebody's file.
            let first = serde_json::to_string(&header)?;
            let start = first.find(',').map_or(first.as_str(), |at| &first[..at]).as_bytes();
            if !(start.starts_with(&text) || text.starts_with(start)) {
                return Err(foreign(&shown));
            }
        }
        let (old, runs) = lines(&text[..whole], &shown)?;
        if let Some(other) = old.as_ref().filter(|other| other.fingerprint != header.fingerprint) {
            bail!(
                "`{shown}` holds runs of another case (spec `{}`, version {}): the spec, its files, its --set, the method or the program changed since; \
                 give another --out, or delete the file to start anew",
                other.spec,
                other.version
            );
        }
        file.set_len(whole as u64)
            .and_then(|()| file.seek(SeekFrom::End(0)))
            .with_context(|| format!("cannot write `{shown}`"))?;
        let runs = runs.into_iter().map(|run| ((run.cell.clone(), run.seed), run)).collect();
        let mut journal = Journal { file: Some(file), runs };
        if old.is_none_or(|old| old.design != header.design) {
            journal.line(&header).with_context(|| format!("cannot write `{shown}`"))?;
        }
        Ok(journal)
    }

    /// What a finished journal holds.
    ///
    /// # Errors
    /// It cannot be read, is none, or is damaged.
    pub(crate) fn read(path: &Path) -> Result<Kept> {
        let shown = path.display().to_string();
        let mut text = Vec::new();
        open_plain_file(path)
            .and_then(|mut file| file.read_to_end(&mut text))
            .with_context(|| format!("cannot read `{shown}`"))?;
        Kept::of(&text, &shown)
    }

    /// Whether a run is finished.
    pub(crate) fn has(&self, cell: &str, seed: u64) -> bool {
        self.runs.contains_key(&(cell.to_owned(), seed))
    }

    /// How many runs are finished.
    pub(crate) fn len(&self) -> usize {
        self.runs.len()
    }

    /// The finished runs of a cell with these seeds, in their order.
    pub(crate) fn runs(&self, cell: &str, seeds: &[u64]) -> Vec<Run> {
        seeds.iter().filter_map(|&seed| self.runs.get(&(cell.to_owned(), seed)).cloned()).collect()
    }

    /// Keeps a run; it is in the file when this returns.
    pub(crate) fn push(&mut self, run: Run) -> Result<()> {
        self.line(&run).with_context(|| format!("cannot write {NAME}"))?;
        self.runs.insert((run.cell.clone(), run.seed), run);
        Ok(())
    }

    fn line(&mut self, value: &impl Serialize) -> Result<()> {
        if let Some(file) = &mut self.file {
            let line = serde_json::to_string(value)? + "\n";
            file.write_all(line.as_bytes())?;
            // A run that took minutes outlasts a power cut.
            file.sync_data()?;
        }
        Ok(())
    }
}

/// The length of all lines with an end. A line without one was torn when the program was killed: its run is
/// done again.
fn whole(text: &[u8]) -> usize {
    text.iter().rposition(|&b| b == b'\n').map_or(0, |at| at + 1)
}

fn foreign(shown: &str) -> anyhow::Error {
    anyhow!("`{shown}` is no journal of a sweep; give another --out, or delete it")
}

/// The last header of a journal, and its runs.
fn lines(text: &[u8], shown: &str) -> Result<(Option<Header>, Vec<Run>)> {
    let text = std::str::from_utf8(text).with_context(|| format!("`{shown}` is not UTF-8 text"))?;
    let (mut header, mut runs) = (None, Vec::new());
    for (k, line) in text.lines().enumerate() {
        match serde_json::from_str(line) {
            Ok(Line::Header(found)) if found.journal == KIND => header = Some(found),
            Ok(Line::Run(run)) if header.is_some() => runs.push(run),
            _ if header.is_none() => return Err(foreign(shown)),
            _ => bail!("line {} of `{shown}` is damaged; delete that line to do its run again", k + 1),
        }
    }
    Ok((header, runs))
}

/// FNV-1a, 64 bits: the same in every version and on every machine.
fn fingerprint(text: &[u8]) -> u64 {
    text.iter().fold(0xcbf2_9ce4_8422_2325, |h, b| (h ^ u64::from(*b)).wrapping_mul(0x0100_0000_01b3))
}

#[cfg(test)]
mod tests {
    use super::*;
    use phisindy_report::sweep::Found;

    #[test]
    fn the_fingerprint_is_that_of_the_standard() {
        assert_eq!(fingerprint(b""), 0xcbf2_9ce4_8422_2325);
        assert_eq!(fingerprint(b"foobar"), 0x8594_4171_f739_67e8);
    }

    #[test]
    fn numbers_come_back_to_the_bit() {
        let found = Found { value: 0.1 + 0.2, low: Some(1.0 / 3.0), high: None };
        let run = Run { found: vec![Some(found), None], bound: vec![Some(1e-300), None], ..Run::default() };
        let line = serde_json::to_string(&run).expect("JSON");
        assert_eq!(serde_json::from_str::<Run>(&line).expect("a run"), run);
    }
}
