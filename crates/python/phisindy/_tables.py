"""Tables of any kind as columns of doubles by name, without a copy where that is possible."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from ._errors import DataError

Column = npt.NDArray[np.float64]
Columns = list[tuple[str, Column]]


def tables(data: Any) -> list[Columns]:
    """The tables in ``data``: none, one, or a list of them."""
    if data is None:
        return []
    if isinstance(data, Sequence) and not isinstance(data, (str, bytes)):
        return [table(one) for one in data]
    return [table(data)]


def table(data: Any) -> Columns:
    """The columns of a dict of arrays, of a pandas, polars or pyarrow table, or of anything with the PyCapsule interface of Arrow."""
    if isinstance(data, Mapping):
        return [(_name(name), column(name, values)) for name, values in data.items()]
    if hasattr(data, "columns") and hasattr(data, "iloc"):  # pandas
        return [(_name(name), column(name, data[name].to_numpy())) for name in data.columns]
    if hasattr(data, "column_names") and hasattr(data, "column"):  # pyarrow
        return [(name, column(name, data.column(name).to_numpy())) for name in data.column_names]
    if hasattr(data, "get_columns"):  # polars
        return [(one.name, column(one.name, one.to_numpy())) for one in data.get_columns()]
    if hasattr(data, "__arrow_c_stream__"):
        try:
            import pyarrow
        except ImportError as error:
            raise DataError("a table of Arrow needs the package pyarrow: pip install pyarrow") from error
        return table(pyarrow.table(data))
    if isinstance(data, np.ndarray) and data.dtype.names:
        return [(name, column(name, data[name])) for name in data.dtype.names]
    raise DataError(
        f"a {type(data).__name__} is no table: give a dict of arrays, or a table of pandas, polars or pyarrow"
    )


def column(name: Any, values: Any) -> Column:
    """The values as contiguous doubles."""
    try:
        array = np.asarray(values)
        if array.dtype.kind not in "biuf":
            raise TypeError(f"its numbers are of the type {array.dtype}")
        # What Dask brings to a worker may start at any byte.
        array = np.require(array, np.float64, ["C_CONTIGUOUS", "ALIGNED"])
    except (TypeError, ValueError) as error:
        raise DataError(f"the column `{name}` holds no numbers: {error}") from error
    if array.ndim != 1:
        raise DataError(f"the column `{name}` has {array.ndim} dimensions: give one number for each row")
    return array


def _name(name: Any) -> str:
    if not isinstance(name, str):
        raise DataError(f"the column `{name!r}` has no name: name the columns by texts")
    return name
