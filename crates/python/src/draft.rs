//! Drafts of specs for data.

use crate::errors::DataError;
use phisindy::files::open_plain_file;
use phisindy_expr::Span;
use phisindy_import::{Answers, CountUnit, DataFile, Draft, Rig, accepted, spec_text, summary, table};
use phisindy_phys::{Diagnostic, Sources};
use pyo3::prelude::*;
use std::io::Cursor;
use std::path::PathBuf;

pub(crate) fn add(m: &Bound<'_, PyModule>) -> PyResult<()> {
    m.add_function(wrap_pyfunction!(draft, m)?)
}

/// The text of the spec, what was seen, and what is asked.
type Drafted = (String, Vec<String>, Vec<String>);

/// A spec for a data file, or for bytes that stand in its place.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "the keywords of `phisindy.new`")]
fn draft(
    py: Python<'_>,
    path: PathBuf,
    bytes: Option<Vec<u8>>,
    sheet: Option<String>,
    rate: Option<f64>,
    columns: Vec<String>,
    time_unit: Option<String>,
    counts: Vec<(Option<String>, String)>,
    rig: Option<String>,
) -> PyResult<Drafted> {
    let counts = counts.into_iter().map(|(heading, said)| {
        let unit = CountUnit::parse(&said).map_err(|why| format!("counts {said:?}: give {why}"))?.unit;
        Ok(CountUnit { heading, unit })
    });
    let counts: Vec<CountUnit> = counts.collect::<Result<_, String>>().map_err(DataError::new_err)?;
    if rate.is_some_and(|rate| !(rate.is_normal() && rate > 0.0)) {
        return Err(DataError::new_err("rate: give a number of rows per second above zero"));
    }
    let refused = |name: &str, why: String| DataError::new_err(format!("{name}: give {why}"));
    let time_unit =
        time_unit.map(|unit| phisindy_import::time_unit(&unit).map_err(|why| refused("time_unit", why)));
    let rig = rig.map(|rig| Rig::parse(&rig).map_err(|why| refused("rig", why)));
    let answers = Answers {
        rate,
        columns,
        time_unit: time_unit.transpose()?,
        counts,
        rig: rig.transpose()?,
        ..Answers::default()
    };
    py.detach(|| drafted(&path, bytes, sheet.as_deref(), &answers)).map_err(DataError::new_err)
}

fn drafted(
    path: &std::path::Path,
    bytes: Option<Vec<u8>>,
    sheet: Option<&str>,
    answers: &Answers,
) -> Result<Drafted, String> {
    let name = path.display().to_string();
    let mut sources = Sources::default();
    let at = (sources.add("data", name.clone()), Span::new(0, name.len()));
    let said = |d: &Diagnostic| {
        let help = d.help.iter().map(|help| format!("; {help}"));
        format!("{}{}", d.message, help.collect::<String>())
    };
    let file = match bytes {
        Some(bytes) => {
            let size = bytes.len() as u64;
            DataFile::new(&name, Cursor::new(bytes), size)
        }
        None => {
            let opened = open_plain_file(path).and_then(|file| Ok((file.metadata()?.len(), file)));
            let (size, file) = opened.map_err(|e| format!("cannot read `{name}`: {e}"))?;
            DataFile::new(&name, file, size)
        }
    };
    let table = table(file, sheet, at, &mut sources).map_err(|d| said(&d))?;
    let draft =
        Draft::with_answers(table, answers, &|_| ()).map_err(|why| said(&why.diagnostic(&name, at)))?;
    let file = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    let text = spec_text(&draft, &file, "spec.ron");
    accepted(&text).map_err(|why| format!("the spec for `{file}` would not be accepted ({why})"))?;
    let questions = draft.questions.iter().map(|q| format!("{q} {}", q.answer())).collect();
    Ok((text, summary(&draft, &file), questions))
}
