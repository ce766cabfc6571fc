//! Many machines of one kind: each is judged by its own model, alone or where there is room, and then all are set beside
//! each other.
//!
//! ```text
//! path --machine--> a line of JSON --+
//! path --machine--> a line of JSON --+--fleet_of--> Fleet: spread, who stands out
//! ```

use super::folders::named_files;
use super::judged::judged;
use super::laws::law_files;
use super::request::Request;
use super::source::{Source, part};
use crate::options::Options;
use phisindy_compare::{Estimates, Fleet, Unit, population};
use phisindy_report::CompareReport;
use std::path::{Path, PathBuf};

/// Fewest machines of a fleet: two are an older and a newer record.
const FEWEST: usize = 3;

/// Many machines of one kind, each by its own spec or result.
pub(super) fn fleet(paths: &[PathBuf], request: &Request, options: &Options<'_>) -> Result<Fleet, String> {
    let share = |k: usize| k as f64 / paths.len() as f64;
    let of = |(k, path): (usize, &PathBuf)| {
        part(options, (share(k), share(k + 1)), |options| unit_of(path, request, options))
    };
    Ok(beside(paths.iter().enumerate().map(of).collect::<Result<_, _>>()?))
}

fn unit_of(path: &Path, request: &Request, options: &Options<'_>) -> Result<Unit, String> {
    Ok(judged(&Source::completed(path)?, request, options)?.unit)
}

fn beside(units: Vec<Unit>) -> Fleet {
    let all: Vec<Estimates> = units.iter().map(|unit| unit.estimates.clone()).collect();
    Fleet { population: population(&all), units }
}

/// A machine of a fleet by its own spec or result, as a line of JSON for [`fleet_of`]. `first` is the first machine of the
/// fleet, whose laws count for all.
///
/// # Errors
/// As of [`compare`](super::compare).
pub fn machine(
    path: &Path,
    first: &Path,
    request: &Request,
    options: &Options<'_>,
) -> Result<String, String> {
    let laws = Source::completed(first)?.laws(request)?;
    let options = &Options { laws: options.laws.or(Some(&laws)), ..*options };
    let unit = unit_of(path, request, options)?;
    serde_json::to_string(&unit).map_err(|why| format!("`{}` cannot be written: {why}", path.display()))
}

/// The files that the line of a machine depends on: its spec, its data, the laws of the first machine.
///
/// # Errors
/// In words: there is neither a spec nor the folder of a result.
pub fn machine_files(path: &Path, first: &Path, request: &Request) -> Result<Vec<PathBuf>, String> {
    let (own, first) = (Source::completed(path)?, Source::completed(first)?);
    let data = named_files(&own.text, own.file(), request).into_iter().map(|(_, path)| path);
    Ok([own.file().to_owned()].into_iter().chain(data).chain(law_files(first.file(), request)).collect())
}

/// Sets machines beside each other that [`machine`] has judged.
///
/// # Errors
/// In words: there are fewer than three, or a line is none of [`machine`].
pub fn fleet_of<'a>(machines: impl IntoIterator<Item = &'a str>) -> Result<CompareReport, String> {
    let read = |(k, line): (usize, &str)| {
        serde_json::from_str::<Unit>(line)
            .map_err(|why| format!("machine {} is no line of this version: {why}: judge it again", k + 1))
    };
    let units: Vec<Unit> = machines.into_iter().enumerate().map(read).collect::<Result<_, _>>()?;
    if units.len() < FEWEST {
        return Err(format!("a fleet has {FEWEST} machines or more, and {} are given", units.len()));
    }
    Ok(CompareReport::Fleet(beside(units)))
}
