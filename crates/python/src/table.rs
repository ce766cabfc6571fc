//! Tables from Python: columns by name, as contiguous arrays of doubles.

use crate::errors::DataError;
use numpy::PyReadonlyArray1;
use phisindy::files::Columns;
use pyo3::prelude::*;

/// The columns of a table.
pub(crate) type Table<'py> = Vec<(String, PyReadonlyArray1<'py, f64>)>;

/// The same where no interpreter is needed.
pub(crate) type Slices<'t> = Vec<(&'t str, &'t [f64])>;

/// The columns as slices.
pub(crate) fn slices<'t>(table: &'t Table<'_>) -> PyResult<Slices<'t>> {
    let slice = |(name, array): &'t (String, PyReadonlyArray1<'_, f64>)| {
        let values = array.as_slice().map_err(|_| {
            DataError::new_err(format!("the column `{name}` is not contiguous: a mistake of this package"))
        })?;
        Ok((name.as_str(), values))
    };
    table.iter().map(slice).collect()
}

/// The columns in the place of a file. They are copied once.
pub(crate) fn columns(table: &Slices<'_>) -> Columns {
    Columns(table.iter().map(|&(name, values)| (name.to_owned(), values.to_vec())).collect())
}
