//! Exceptions: one class for what is wrong with a spec, one for data, one for numerics.

use phisindy::Error;
use pyo3::create_exception;
use pyo3::exceptions::PyException;
use pyo3::prelude::*;
use pyo3::types::PyDict;

create_exception!(phisindy, PhisindyError, PyException, "Anything that phisindy refuses.");
create_exception!(phisindy, SpecError, PhisindyError, "A mistake in a spec.");
create_exception!(phisindy, DataError, PhisindyError, "Data that make no sense with the case.");
create_exception!(phisindy, NumericsError, PhisindyError, "A computation that failed.");

pub(crate) fn add(m: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = m.py();
    m.add("PhisindyError", py.get_type::<PhisindyError>())?;
    m.add("SpecError", py.get_type::<SpecError>())?;
    m.add("DataError", py.get_type::<DataError>())?;
    m.add("NumericsError", py.get_type::<NumericsError>())
}

/// The exception of an error of the library.
pub(crate) fn raised(py: Python<'_>, error: Error) -> PyErr {
    match error {
        Error::Spec(spec) => spec_error(py, &spec),
        Error::Record(_) | Error::Set(_) | Error::Law(_) | Error::Open => {
            DataError::new_err(error.to_string())
        }
        Error::Identify(phisindy::LearnError::Data(_)) | Error::Gap(phisindy::GapError::Data(_)) => {
            DataError::new_err(error.to_string())
        }
        other => {
            let advice = phisindy_report::html::advice(other.diverged());
            NumericsError::new_err(advice.map_or(other.to_string(), |advice| format!("{other}: {advice}")))
        }
    }
}

/// The mistakes of a spec, drawn with their lines; `mistakes` has them as data.
pub(crate) fn spec_error(py: Python<'_>, error: &phisindy::SpecError) -> PyErr {
    let raised = SpecError::new_err(format!("\n{}", phisindy_cli::drawn(error)));
    let mistakes: PyResult<Vec<Py<PyDict>>> = error
        .mistakes()
        .map(|mistake| {
            let dict = PyDict::new(py);
            dict.set_item("message", &mistake.message)?;
            dict.set_item("help", &mistake.help)?;
            let place = mistake.labels.iter().find(|l| l.primary);
            if let Some(label) = place
                && let Some(source) = error.sources().files.get(label.source.0)
            {
                let (line, column) = source.line_and_column(label.span.start);
                dict.set_item("file", &source.name)?;
                dict.set_item("line", line)?;
                dict.set_item("column", column)?;
                dict.set_item("text", source.text.get(label.span.range()))?;
            }
            Ok(dict.unbind())
        })
        .collect();
    match mistakes.and_then(|all| raised.value(py).setattr("mistakes", all)) {
        Ok(()) => raised,
        Err(other) => other,
    }
}
