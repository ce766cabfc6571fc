//! Motions and rates of a model without unknown part.

use crate::errors::{Failure, raised};
use crate::fit::{NativeCase, further_data};
use crate::table::{Table, slices};
use crate::work::worked;
use numpy::{PyArray1, ToPyArray};
use phisindy::files::Purpose;
use phisindy::{Motion, simulate};
use pyo3::prelude::*;
use pyo3::types::PyDict;

pub(crate) fn add(m: &Bound<'_, PyModule>) -> PyResult<()> {
    m.add_function(wrap_pyfunction!(motions, m)?)?;
    m.add_function(wrap_pyfunction!(motion, m)?)?;
    m.add_function(wrap_pyfunction!(rates, m)?)
}

/// The motion along each record: a dict of arrays each, with `t` and `record`.
#[pyfunction]
#[pyo3(signature = (case, tables, seed=None))]
fn motions(
    py: Python<'_>,
    case: &NativeCase,
    tables: Vec<Table<'_>>,
    seed: Option<u64>,
) -> PyResult<Vec<Py<PyDict>>> {
    let slices = tables.iter().map(slices).collect::<PyResult<Vec<_>>>()?;
    let folder = further_data(py);
    let all = worked(py, Some(1), None, None, |_| {
        let loaded = case.loaded(&slices, seed, Purpose::Simulate, folder).map_err(Failure::Loading)?;
        loaded.simulate().map_err(Failure::Working)
    })?;
    let all = all.map_err(|failure| failure.raised(py, !tables.is_empty()))?;
    all.iter().map(|motion| dict(py, motion)).collect()
}

/// The motion from a start (in the language of specs), driven by the inputs of a table with the time `t`.
#[pyfunction]
fn motion(py: Python<'_>, case: &NativeCase, table: Table<'_>, start: &str) -> PyResult<Py<PyDict>> {
    let slices = slices(&table)?;
    let all = worked(py, Some(1), None, None, |_| {
        let record = case.case().record(&slices)?.with("start", start);
        simulate(case.case(), &[record])
    })?;
    let all = all.map_err(|e| Failure::Loading(e).raised(py, true))?;
    dict(py, &all[0])
}

/// The rates of the states at rows of time, states and inputs; the table has a column for each.
#[pyfunction]
fn rates<'py>(
    py: Python<'py>,
    case: &NativeCase,
    table: Table<'_>,
) -> PyResult<Vec<(String, Bound<'py, PyArray1<f64>>)>> {
    let slices = slices(&table)?;
    let all = py.detach(|| case.case().rates(&slices)).map_err(|e| raised(py, e))?;
    Ok(all.into_iter().map(|(name, values)| (name, values.to_pyarray(py))).collect())
}

fn dict(py: Python<'_>, motion: &Motion) -> PyResult<Py<PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("record", &motion.record)?;
    dict.set_item("t", motion.time.to_pyarray(py))?;
    for (name, values) in &motion.columns {
        dict.set_item(name, values.to_pyarray(py))?;
    }
    Ok(dict.unbind())
}
