//! Exceptions: one class for what is wrong with a spec, one for data, one for numerics.

use phisindy::{Error, RecordError};
use pyo3::PyTypeInfo;
use pyo3::create_exception;
use pyo3::exceptions::PyException;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

create_exception!(phisindy, PhisindyError, PyException, "Anything that phisindy refuses.");
create_exception!(phisindy, SpecError, PhisindyError, "A mistake in a spec.");
create_exception!(phisindy, DataError, PhisindyError, "Data that make no sense with the case.");
create_exception!(phisindy, NumericsError, PhisindyError, "A computation that failed.");

pub(crate) fn add(m: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = m.py();
    let all = py.get_type::<PhisindyError>();
    // What is wrong as data, where it stands in a text.
    all.setattr("mistakes", PyTuple::empty(py))?;
    m.add("PhisindyError", all)?;
    m.add("SpecError", py.get_type::<SpecError>())?;
    m.add("DataError", py.get_type::<DataError>())?;
    m.add("NumericsError", py.get_type::<NumericsError>())
}

/// What failed: the case with its records, or the work on them.
pub(crate) enum Failure {
    Loading(Error),
    Working(Error),
}

impl Failure {
    /// The exception. The spec was checked before, so what fails with tables in hand is about the tables.
    pub(crate) fn raised(self, py: Python<'_>, tables: bool) -> PyErr {
        match self {
            Failure::Loading(Error::Spec(spec)) if tables => drawn::<DataError>(py, &spec),
            Failure::Loading(error) | Failure::Working(error) => raised(py, error),
        }
    }
}

/// The exception of an error of the library.
pub(crate) fn raised(py: Python<'_>, error: Error) -> PyErr {
    match error {
        Error::Open => DataError::new_err(
            "the model has an unknown part: identify it first, then simulate what was found",
        ),
        Error::Record(RecordError::NoRecords) => {
            DataError::new_err("there are no records: give a table, or name `data` in the spec")
        }
        Error::Spec(spec) if in_data(&spec) => drawn::<DataError>(py, &spec),
        Error::Spec(spec) => spec_error(py, &spec),
        Error::Record(_) | Error::Set(_) | Error::Law(_) => DataError::new_err(error.to_string()),
        Error::Identify(phisindy::LearnError::Data(_)) | Error::Gap(phisindy::GapError::Data(_)) => {
            DataError::new_err(error.to_string())
        }
        other => {
            let advice = phisindy_report::html::advice(other.diverged());
            NumericsError::new_err(advice.map_or(other.to_string(), |advice| format!("{other}: {advice}")))
        }
    }
}

/// Whether all mistakes are in data files: the spec is the first text that was read.
fn in_data(error: &phisindy::SpecError) -> bool {
    let mut places = error.mistakes().map(|mistake| mistake.labels.iter().find(|l| l.primary));
    places.all(|place| place.is_some_and(|label| label.source.0 > 0))
}

/// The exception of a text with mistakes.
pub(crate) fn spec_error(py: Python<'_>, error: &phisindy::SpecError) -> PyErr {
    drawn::<SpecError>(py, error)
}

/// An exception with the mistakes drawn in their lines; `mistakes` has them as data.
fn drawn<E: PyTypeInfo>(py: Python<'_>, error: &phisindy::SpecError) -> PyErr {
    let raised = PyErr::new::<E, _>(format!("\n{}", phisindy_cli::drawn(error)));
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
