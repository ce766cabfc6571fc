"""``new`` and ``go``: from data to a spec, and to what a model lacks."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import _native
from ._arguments import number_of, path_of, text_of
from ._case import Case, case_at
from ._errors import DataError
from ._results import Gap
from ._tables import table
from ._work import gap

if TYPE_CHECKING:
    from ._work import Tell

# What a table in memory is called in its spec.
TABLE = "table.csv"


class Draft:
    """A spec for some data, as ``phisindy new`` writes it: a guess to look at, with lines marked EDIT.

    ``text`` is the spec, ``questions`` what the data leave open, ``notes`` what was seen in them.
    """

    def __init__(self, path: Path, text: str, notes: list[str], questions: list[str]) -> None:
        self._path = path
        self.text = text
        self.notes = notes
        self.questions = questions

    @property
    def case(self) -> Case:
        """The spec as a case; its data files are looked for beside the data."""
        return case_at(self._path, self.text)

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Writes the spec into a file, which must not be there yet."""
        file = path_of("path", path)
        try:
            with file.open("x", encoding="utf-8") as out:
                out.write(self.text)
        except FileExistsError as error:
            raise DataError(f"`{file}` is there, and may hold edits: give another name") from error
        except OSError as error:
            raise DataError(f"cannot write `{file}`: {error}") from error
        return file

    def __str__(self) -> str:
        return self.text

    def __repr__(self) -> str:
        return "\n".join([f"Draft of {self._path.name}:", *self.notes])


def new(
    data: Any,
    *,
    sheet: str | None = None,
    rate: float | None = None,
    columns: Sequence[str] | None = None,
    time_unit: str | None = None,
    counts: Mapping[str, str] | str | None = None,
    rig: str | None = None,
) -> Draft:
    """Drafts a spec for data, as ``phisindy new`` does.

    ``data`` is the path of a data file, or a table: a dict of arrays, a table of pandas, polars or pyarrow. Give the
    same table to ``run`` and ``gap`` with the case of the draft. ``rate`` are rows per second, where there are no
    times; ``columns`` are names with units in the place of the headings (``["t (s)", "x (mm)"]``, ``"-"`` for one that
    is not used); ``time_unit`` is that of the times; ``counts`` is what a count is (``"4096/rev"``), or that of some
    columns by their headings; ``rig`` is the kind of rig (``"slider"``, ``"pendulum"``, ``"motor"``,
    ``"base-excited"``, ``"quarter-car"``, ``"tester"``, ``"robot-joint"``, ``"free"``), which else is guessed.
    """
    given = (
        None if sheet is None else text_of("sheet", sheet),
        None if rate is None else number_of("rate", rate),
        [text_of("the name of a column", name) for name in columns or []],
        None if time_unit is None else text_of("time_unit", time_unit),
        _counts(counts),
        None if rig is None else text_of("rig", rig),
    )
    if isinstance(data, (str, os.PathLike)):
        path = path_of("data", data)
        text, notes, questions = _native.draft(path, None, *given)
        return Draft(path.parent / "spec", text, notes, questions)
    text, notes, questions = _native.draft(Path(TABLE), _written(data), *given)
    return Draft(Path("spec"), text, notes, questions)


def go(
    data: Any,
    *,
    sheet: str | None = None,
    rate: float | None = None,
    columns: Sequence[str] | None = None,
    time_unit: str | None = None,
    counts: Mapping[str, str] | str | None = None,
    rig: str | None = None,
    out: str | os.PathLike[str] | None = None,
    jobs: int | None = None,
    progress: bool | Tell = False,
    laws: str | os.PathLike[str] | None = None,
) -> Gap:
    """From data to what a model lacks without a stop, as ``phisindy go`` does: ``new``, ``gap``, and with ``out`` the report.

    Arguments as of ``new`` and ``gap``. Where the data leave a question open, a ``DataError`` asks it.
    """
    draft = new(data, sheet=sheet, rate=rate, columns=columns, time_unit=time_unit, counts=counts, rig=rig)
    if draft.questions:
        raise DataError("\n".join(draft.questions))
    of_file = isinstance(data, (str, os.PathLike))
    found = gap(draft.case, None if of_file else data, jobs=jobs, progress=progress, laws=laws)
    if out is not None:
        found.save(out)
    return found


def _counts(given: Mapping[str, str] | str | None) -> list[tuple[str | None, str]]:
    """What a count is: of all columns, or of some."""
    if given is None:
        return []
    if isinstance(given, str):
        return [(None, text_of("counts", given))]
    if not isinstance(given, Mapping):
        raise DataError(f'counts is no text such as "4096/rev", and no dict of them: {given!r}')
    return [(text_of("a heading", name), text_of("counts", unit)) for name, unit in given.items()]


def _written(data: Any) -> bytes:
    """A table as text that reads back as the same numbers."""
    found = table(data)
    if not found:
        raise DataError("the table has no columns")
    if len({len(values) for _, values in found}) > 1:
        raise DataError("the columns of the table differ in length")
    out = io.StringIO()
    lines = csv.writer(out, lineterminator="\n")
    lines.writerow([name for name, _ in found])
    lines.writerows(zip(*(map(repr, values.tolist()) for _, values in found)))
    return out.getvalue().encode()
