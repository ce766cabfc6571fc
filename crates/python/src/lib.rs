//! `phisindy._native`: what the Python package `phisindy` calls. Classes for users are in `phisindy/*.py`;
//! here are handles, arrays without copies, threads without the interpreter's lock, and exceptions.

mod draft;
mod errors;
mod fit;
mod motion;
mod table;
mod truth;
mod work;

use pyo3::prelude::*;
use std::ffi::OsString;

/// Memory of this library alone, whatever the process of the interpreter was told about its own.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Runs the program `phisindy` with the words of a command line, of which the first is its name.
#[pyfunction]
fn program(py: Python<'_>, line: Vec<OsString>) -> u8 {
    py.detach(|| phisindy_cli::program(line.into_iter()))
}

/// Id, name, what it is, reference, text.
type LawRow = (String, String, String, String, String);

/// The laws of the catalogue as tuples `(id, name, about, reference, text)`; `folder` holds further laws.
#[pyfunction]
#[pyo3(signature = (folder=None))]
fn laws(folder: Option<std::path::PathBuf>) -> PyResult<Vec<LawRow>> {
    let folders: Vec<&std::path::Path> = folder.as_deref().into_iter().collect();
    let all = phisindy::files::catalogue(&folders).map_err(|e| errors::DataError::new_err(e.to_string()))?;
    let row = |e: &phisindy::LawEntry| {
        let law = &e.law;
        (e.id.clone(), law.name.clone(), law.about.clone(), law.reference.clone(), e.text.clone())
    };
    Ok(all.laws().iter().map(row).collect())
}

#[pymodule]
fn _native(m: &Bound<'_, PyModule>) -> PyResult<()> {
    m.add("__version__", env!("CARGO_PKG_VERSION"))?;
    draft::add(m)?;
    errors::add(m)?;
    fit::add(m)?;
    motion::add(m)?;
    truth::add(m)?;
    m.add_class::<work::Stop>()?;
    m.add_function(wrap_pyfunction!(program, m)?)?;
    m.add_function(wrap_pyfunction!(laws, m)?)
}
