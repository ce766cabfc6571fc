//! The truth of synthetic data in terms of a dictionary, for the statistics of a sweep.

use crate::errors::{NumericsError, raised};
use crate::fit::{NativeCase, further_data};
use crate::work::worked;
use phisindy::files::Purpose;
use pyo3::prelude::*;

pub(crate) fn add(m: &Bound<'_, PyModule>) -> PyResult<()> {
    m.add_function(wrap_pyfunction!(truth, m)?)
}

/// Names (`STATE:candidate`) and coefficients of the true terms.
#[pyfunction]
fn truth(py: Python<'_>, case: &NativeCase) -> PyResult<Vec<(String, f64)>> {
    let folder = further_data(py);
    let all = worked(py, None, None, None, |_| {
        let loaded = case.loaded(&[], None, Purpose::Run, folder)?;
        let truth = phisindy_learn::project(&loaded.case, &loaded.records);
        Ok((loaded, truth))
    })?;
    let (loaded, truth) = all.map_err(|e| raised(py, e))?;
    let truth = truth.map_err(|e| NumericsError::new_err(format!("{e}: no seed can be right")))?;
    let system = &loaded.case.system;
    let name = |k: usize| {
        let term = &system.terms[k];
        format!("{}:{}", system.states[term.state].name, term.candidate)
    };
    Ok(truth.terms.iter().map(|&k| name(k)).zip(truth.coefficients.iter().copied()).collect())
}
