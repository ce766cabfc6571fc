"""Results: what the command prints as JSON, as attributes."""

from __future__ import annotations

import html
import json
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _native
from ._arguments import number_of, path_of
from ._case import Case, case_at
from ._errors import DataError
from ._tables import Columns, table

Array = npt.NDArray[np.float64]
# Record, column, unit, times, what was measured, the free run of the model.
Shown = tuple[str, str, str, Array, Array, Array]


class Motion(Mapping[str, Array]):
    """Arrays by name: ``t`` in seconds, then states and outputs in SI. ``record`` is the name of the record."""

    def __init__(self, columns: dict[str, Any]) -> None:
        self.record: str = columns.pop("record")
        self._columns: dict[str, Array] = columns

    def __getitem__(self, name: str) -> Array:
        return self._columns[name]

    def __iter__(self) -> Any:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def __repr__(self) -> str:
        return f"Motion({self.record!r}: {', '.join(self)})"


class Report:
    """What a command says of several models or records: ``sentence`` in short, ``str()`` as it prints it."""

    def __init__(self, text: str, files: list[tuple[str, str]]) -> None:
        self._text = text
        self._files = dict(files)

    @cached_property
    def _json(self) -> dict[str, Any]:
        found: dict[str, Any] = json.loads(self._files["result.json"])
        return found

    @property
    def sentence(self) -> str:
        return str(self._json["sentence"])

    def to_dict(self) -> dict[str, Any]:
        """The JSON of the command."""
        return dict(self._json)

    def save(self, folder: str | os.PathLike[str], *, force: bool = False) -> Path:
        """Writes the folder that ``--out`` of the command writes: report.html with its picture, result.json."""
        path = path_of("folder", folder)
        _native.save(list(self._files.items()), path, force)
        return path

    def __str__(self) -> str:
        return self._text

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.sentence!r})"

    def _repr_html_(self) -> str:
        page = html.escape(self._files["report.html"], quote=True)
        return f'<iframe srcdoc="{page}" style="width:100%;height:40em;border:0"></iframe>'


class Comparison(Report):
    """What changed between two records of a machine, or which of many machines stands out.

    ``sentence`` says it, ``verdict`` is ``"unchanged"``, ``"changed"`` or ``"unexplained"`` of two and ``None`` of more;
    ``to_dict()`` is the JSON of ``phisindy compare``.
    """

    @property
    def verdict(self) -> str | None:
        word: str | None = self._json.get("verdict")
        return word


class NextRun(Report):
    """The run after which most is known: ``sentence`` says which, ``to_dict()`` is the JSON of ``phisindy next``."""

    @property
    def runs(self) -> list[dict[str, Any]]:
        """The best run of each form, the best one first: ``drive``, ``duration``, ``decides``, ``numbers``."""
        return list(self._json["runs"])

    @property
    def drive(self) -> dict[str, list[float]]:
        """The best run as columns: ``t_s``, and each input with its unit in the heading."""
        head, *rows = self._files["drive.csv"].splitlines()
        values = [[float(cell) for cell in row.split(",")] for row in rows]
        return {name: [row[k] for row in values] for k, name in enumerate(head.split(","))}


def _numbers(what: str, given: Any) -> dict[str, Any]:
    """The numbers of an argument by name."""
    if given is not None and not isinstance(given, Mapping):
        raise DataError(f"{what} is a {type(given).__name__}: give a dict of names and values")
    return dict(given or {})


def _columns(what: str, given: Any, kind: str, names: list[str]) -> Columns:
    """The columns of an argument, each called by one of ``names``."""
    found = [] if given is None else table(given)
    for name, _ in found:
        if name not in names:
            raise DataError(f"{what}: `{name}` is no {kind}; there is: {', '.join(names) or 'none'}")
    return found


@dataclass(frozen=True)
class _Kept:
    """The texts of a result, as they travel between processes."""

    texts: dict[str, str]
    folder: list[tuple[str, str]]
    columns: list[Shown]

    @classmethod
    def of(cls, native: Any) -> _Kept:
        """Those of a result of the compiled module, or of one that has travelled."""
        if isinstance(native, cls):
            return native
        texts = {name: getattr(native, name)() for name in ("json", "written", "latex", "model")}
        return cls(texts, native.files(), native.shown())

    def json(self) -> str:
        return self.texts["json"]

    def written(self) -> str:
        return self.texts["written"]

    def latex(self) -> str:
        return self.texts["latex"]

    def model(self) -> str:
        return self.texts["model"]

    def files(self) -> list[tuple[str, str]]:
        return self.folder

    def shown(self) -> list[Shown]:
        return self.columns


class _Result:
    """What results of ``run`` and ``gap`` share."""

    latex: Any

    def __init__(self, native: Any, path: Path) -> None:
        self._native = native
        # That of the case: data files are looked for beside it.
        self._path = path

    @cached_property
    def _dict(self) -> dict[str, Any]:
        found: dict[str, Any] = json.loads(self._native.json())
        return found

    @cached_property
    def _files(self) -> dict[str, str]:
        return dict(self._native.files())

    @cached_property
    def case(self) -> Case:
        """The completed model as a case without unknown part."""
        return case_at(self._path, self._native.model())

    @property
    def warnings(self) -> list[str]:
        """What a careful reader should know."""
        return list(self._dict["warnings"])

    @property
    def records(self) -> list[dict[str, Any]]:
        """How the model runs along each record."""
        return list(self._dict["records"])

    @property
    def parameters(self) -> list[dict[str, Any]]:
        """Constants and sensors that were fitted: name, value, unit, standard error, 95 % interval."""
        return list(self._dict["parameters"])

    def to_dict(self) -> dict[str, Any]:
        """The JSON of the command."""
        found: dict[str, Any] = json.loads(self._native.json())
        return found

    def save(self, folder: str | os.PathLike[str], *, force: bool = False) -> Path:
        """Writes the folder that ``--out`` of the command writes: report.html, result.json, the model.

        It appears as a whole; an earlier result is kept beside, as ``folder.1``. A folder that holds other files is
        refused; ``force`` puts the result among them.
        """
        path = path_of("folder", folder)
        _native.save(list(self._files.items()), path, force)
        return path

    def simulate(
        self, t: Any, inputs: Any = None, start: Mapping[str, float] | None = None
    ) -> Motion:
        """The motion at the times ``t`` from ``start`` (a value for each state, zero if absent), driven by ``inputs``.

        ``inputs`` is a table (a dict of arrays, a DataFrame) with a column for each input and a row for each time. Times
        in seconds, inputs and start in the units of the spec; the motion is in SI.
        """
        given, states = _numbers("start", start), self.case.states
        unknown = [name for name in given if name not in states]
        if unknown:
            raise DataError(f"start: `{unknown[0]}` is no state; there is: {', '.join(states)}")
        begin = {name: 0.0 for name in states} | {k: number_of(f"the start of `{k}`", v) for k, v in given.items()}
        odd = [name for name, value in begin.items() if not math.isfinite(value)]
        if odd:
            raise DataError(f"the start of `{odd[0]}` is {begin[odd[0]]}: give a finite number")
        text = ", ".join(f"{json.dumps(name)}: {value!r}" for name, value in begin.items())
        columns = table({"t": t}) + _columns("inputs", inputs, "input", self.case.inputs)
        return Motion(_native.motion(self.case._native, columns, f"{{ {text} }}"))

    def rates(self, t: Any, x: Any, u: Any = None) -> dict[str, Array]:
        """The rates of the states at rows of time, states and inputs, in the units of the spec per second.

        ``x`` and ``u`` are tables (a dict of arrays, a DataFrame) with a column for each state and each input.
        """
        case = self.case
        columns = table({"t": t}) + _columns("x", x, "state", case.states) + _columns("u", u, "input", case.inputs)
        return dict(_native.rates(self.case._native, columns))

    def table(self) -> Any:
        """The numbers that were found as a DataFrame, a row for each: where it stands, value, unit, error, 95 % interval.

        It needs pandas.
        """
        try:
            import pandas
        except ImportError as error:
            raise DataError("a table needs the package pandas: pip install pandas") from error
        names = ["of", "name", "value", "unit", "std_error", "low", "high"]
        return pandas.DataFrame([[row[name] for name in names] for row in self._numbers()], columns=names)

    def _numbers(self) -> list[dict[str, Any]]:
        """A row of ``table`` for each number."""
        return [_number("constant", one["name"], one) for one in self.parameters]

    def plot(self, record: str | None = None) -> Any:
        """The figure of what was measured and of the free run of the model, as ``matplotlib`` draws it.

        A panel for each column; ``record`` is the name of one, else the first is shown. It needs matplotlib.
        """
        try:
            from matplotlib import pyplot
        except ImportError as error:
            raise DataError("a plot needs the package matplotlib: pip install matplotlib") from error
        every = self._native.shown()
        names = list(dict.fromkeys(one[0] for one in every))
        wanted = names[0] if record is None and names else record
        columns = [one for one in every if one[0] == wanted]
        if not columns:
            raise DataError(f"there is no record {record!r}; there is: {', '.join(map(repr, names)) or 'none'}")
        figure, axes = pyplot.subplots(
            len(columns), 1, sharex=True, squeeze=False, figsize=(8.0, 1.2 + 2.2 * len(columns)), layout="constrained"
        )
        for axis, (_, name, unit, time, measured, model) in zip(axes[:, 0], columns):
            axis.plot(time, measured, ".", color="0.6", markersize=3, label="measured")
            if len(model) > 0:
                axis.plot(time, model, color="#0072b2", linewidth=1.3, label="model")
            axis.set_ylabel(f"{name} ({unit})" if unit else name)
        axes[0, 0].set_title(f"{wanted}: {self._dict['verdict' if 'verdict' in self._dict else 'status']}")
        axes[0, 0].legend(loc="upper right")
        axes[-1, 0].set_xlabel("time (s)")
        return figure

    def __reduce__(self) -> tuple[Any, ...]:
        return (type(self), (_Kept.of(self._native), self._path))

    def _repr_latex_(self) -> str:
        return "\n".join(f"$\\displaystyle {line}$\n" for line in self.latex.splitlines())

    def _repr_html_(self) -> str:
        page = html.escape(self._files["report.html"])
        return f'<iframe srcdoc="{page}" style="width: 100%; height: 900px; border: 0"></iframe>'


def _number(of: str, name: str, given: Mapping[str, Any], value: str = "value") -> dict[str, Any]:
    """A row of a table of numbers."""
    low, high = given.get("ci95") or (None, None)
    return {
        "of": of,
        "name": name,
        "value": given.get(value),
        "unit": given.get("unit"),
        "std_error": given.get("std_error"),
        "low": low,
        "high": high,
    }


class Identified(_Result):
    """What ``run`` found."""

    @property
    def verdict(self) -> str:
        """``identified`` or ``rejected``."""
        return str(self._dict["verdict"])

    @property
    def status(self) -> str:
        """The same as ``verdict``."""
        return self.verdict

    @cached_property
    def latex(self) -> str:
        """The equations in LaTeX, a line for each."""
        return str(self._native.latex())

    @property
    def equations(self) -> list[dict[str, Any]]:
        """The equations with their terms."""
        return list(self._dict["equations"])

    @property
    def terms(self) -> list[dict[str, Any]]:
        """The terms of all equations: state, candidate, coefficient, unit, standard error, 95 % interval."""
        return [{"state": one["state"], **term} for one in self.equations for term in one["terms"]]

    @property
    def steps(self) -> list[dict[str, Any]]:
        """Laws that were added: none, ``run`` adds no laws."""
        return []

    def _numbers(self) -> list[dict[str, Any]]:
        terms = [_number(one["state"], one["candidate"], one, "coefficient") for one in self.terms]
        return terms + super()._numbers()

    def __repr__(self) -> str:
        return str(self._native.written())


class Gap(_Result):
    """What ``gap`` found."""

    @property
    def status(self) -> str:
        """``explained``, ``described``, ``named``, ``nothing-missing``, ``undetermined`` or ``unexplained``."""
        return str(self._dict["status"])

    @property
    def verdict(self) -> str:
        """The same as ``status``."""
        return self.status

    @property
    def steps(self) -> list[dict[str, Any]]:
        """The laws that were added, in their order."""
        return list(self._dict["steps"])

    @property
    def terms(self) -> list[dict[str, Any]]:
        """The same as ``steps``."""
        return self.steps

    @property
    def equations(self) -> list[dict[str, Any]]:
        """The forces that were added."""
        keys = ("law", "at", "expression")
        return [{key: step.get(key) for key in keys} for step in self.steps]

    @cached_property
    def latex(self) -> str:
        """The equations of the completed model in LaTeX, a line for each."""
        return str(self._native.latex())

    def _numbers(self) -> list[dict[str, Any]]:
        laws = [
            _number(f"{step['law']} at {step['at']}", name, one)
            for step in self.steps
            for name, one in step["parameters"].items()
        ]
        return laws + super()._numbers()

    def __repr__(self) -> str:
        return str(self._native.written())
