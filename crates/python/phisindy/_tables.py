"""Tables of any kind as columns of doubles by name, without a copy where that is possible."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from ._arguments import text_of
from ._errors import DataError

Column = npt.NDArray[np.float64]
Columns = list[tuple[str, Column]]


def tables(data: Any, headings: Sequence[str] | None = None) -> list[Columns]:
    """The tables in ``data``: none, one, or a list of them.

    Of ``headings``, if they are given, every column must hold numbers; others may hold anything, and are left out then.
    """
    if data is None:
        return []
    if isinstance(data, Sequence) and not isinstance(data, (str, bytes)):
        if len(data) == 0:
            raise DataError("a list without tables is given: give None for the records of the case itself")
        return [table(one, headings) for one in data]
    return [table(data, headings)]


def records(data: Any, headings: Sequence[str] | None) -> list[Columns]:
    """The tables of records: of ``headings``, or by the names of states, with the time ``t``.

    Of a column that is not there it says that it may be the index of its table.
    """
    found = tables(data, headings)
    given = data if isinstance(data, Sequence) else [data]
    for one, columns in zip(given, found):
        names = [name for name, _ in columns]
        missing = next((name for name in (["t"] if headings is None else headings) if name not in names), None)
        if missing is not None and (remedy := _index_as_column(one, missing)):
            raise DataError(f"there is no column `{missing}`, and the index of a table is no column: give {remedy}")
    return found


def _index_as_column(data: Any, name: str) -> str | None:
    """How the index of a table of pandas becomes this column; ``None`` where it only counts the rows."""
    index = getattr(data, "index", None)
    if not hasattr(data, "iloc") or index is None or (type(index).__name__ == "RangeIndex" and index.name is None):
        return None
    if index.nlevels > 1 or index.name == name:
        return "table.reset_index()"
    return f"table.rename_axis({name!r}).reset_index()"


def table(data: Any, headings: Sequence[str] | None = None) -> Columns:
    """The columns of a dict of arrays, of a pandas, polars or pyarrow table, or of anything with the PyCapsule interface of Arrow."""
    found: Columns = []
    for name, values in _columns(data):
        try:
            found.append((_name(name), column(name, values)))
        except DataError:
            if headings is None or name in headings:
                raise
    return found


def _columns(data: Any) -> list[tuple[Any, Callable[[], Any]]]:
    """Name and values of each column; the values are not looked at."""
    if isinstance(data, Mapping):
        return [(name, partial(data.__getitem__, name)) for name in data]
    if hasattr(data, "iloc") and hasattr(data, "columns"):  # pandas
        return [(name, partial(_of_pandas, data, k)) for k, name in enumerate(data.columns)]
    if hasattr(data, "column_names") and hasattr(data, "column"):  # pyarrow
        # A batch refuses to copy unless told; a table has no other choice.
        return [(name, partial(data.column(k).to_numpy, zero_copy_only=False)) for k, name in enumerate(data.column_names)]
    if hasattr(data, "get_columns"):  # polars
        return [(one.name, one.to_numpy) for one in data.get_columns()]
    if hasattr(data, "__arrow_c_stream__"):
        try:
            import pyarrow
        except ImportError as error:
            raise DataError("a table of Arrow needs the package pyarrow: pip install pyarrow") from error
        try:
            return _columns(pyarrow.table(data))
        except pyarrow.ArrowException as error:
            raise DataError(f"a {type(data).__name__} is no table: {error}") from error
    if isinstance(data, np.ndarray) and data.dtype.names:
        return [(name, partial(data.__getitem__, name)) for name in data.dtype.names]
    raise DataError(
        f"a {type(data).__name__} is no table: give a dict of arrays, or a table of pandas, polars or pyarrow"
    )


def _of_pandas(data: Any, place: int) -> Any:
    """A column, in which what is missing is NaN."""
    values = data.iloc[:, place]
    if getattr(values.dtype, "_is_numeric", False):  # what pandas adds to the types of NumPy
        return values.to_numpy(dtype=np.float64, na_value=np.nan)
    return values.to_numpy()


def column(name: Any, given: Callable[[], Any]) -> Column:
    """The values as contiguous doubles."""
    try:
        values = given()
        # What is masked is missing.
        array = np.ma.filled(values.astype(np.float64), np.nan) if isinstance(values, np.ma.MaskedArray) else np.asarray(values)
        if array.dtype.kind in "mM":
            raise TypeError(f"it holds {array.dtype}: give seconds, as (t - t[0]) / numpy.timedelta64(1, 's') has them")
        if array.dtype.kind not in "biuf":
            raise TypeError(f"it holds {_kind(array)}")
        # What Dask brings to a worker may start at any byte.
        array = np.require(array, np.float64, ["C_CONTIGUOUS", "ALIGNED"])
    except MemoryError:
        raise
    except Exception as error:  # Packages refuse to give an array in ways of their own.
        raise DataError(f"the column `{name}` holds no numbers: {error}") from error
    if array.ndim != 1:
        raise DataError(f"the column `{name}` has {array.ndim} dimensions: give one number for each row")
    return array


def _kind(array: npt.NDArray[Any]) -> str:
    """What an array holds, in words."""
    if array.dtype.kind != "O":
        return f"the type {array.dtype}"
    odd = [one for one in array.flat if isinstance(one, bool) or not isinstance(one, (int, float))]
    if not odd:
        return "objects; give an array of float64"
    first = odd[0]
    if hasattr(first, "tzinfo"):
        return "times with a date; give seconds, as (t - t[0]).dt.total_seconds() of pandas has them"
    return f"objects, among them {first!r:.60}"


def _name(name: Any) -> str:
    if not isinstance(name, str):
        raise DataError(f"the column `{name!r}` has no name: name the columns by texts")
    return text_of("the name of a column", name)
