"""A case: the text of a spec."""

from __future__ import annotations

import math
import operator
import os
from pathlib import Path
from typing import Any

import numpy as np

from . import _native
from ._arguments import number_of, path_of, text_of
from ._errors import DataError


class Case:
    """A checked spec (see the reference: states, known rates, what is unknown).

    ``text`` is the spec in RON. Data files that it names are looked for in the folder that the environment variable
    ``PHISINDY_DATA`` names, then in ``folder``.
    Raises ``SpecError`` with all mistakes, each with its line.
    """

    def __init__(self, text: str, *, folder: str | os.PathLike[str] = "") -> None:
        if not isinstance(text, str):
            raise DataError(f"a {type(text).__name__} is no text of a spec: Case.from_file(path) reads a file")
        if "\n" not in text and text.strip().endswith(".ron"):
            raise DataError(f"`{text}` is a path, not the text of a spec: Case.from_file(path) reads a file")
        self._path = path_of("folder", folder) / "spec"
        self._native = _native.Case(text_of("the spec", text), self._path)

    @classmethod
    def from_file(cls, path: str | os.PathLike[str]) -> Case:
        """The case in a file; its data files are looked for beside it."""
        try:
            path = Path(path)
            text = path.read_text(encoding="utf-8-sig")
        except (OSError, UnicodeDecodeError, TypeError, ValueError) as error:
            raise DataError(f"cannot read the spec `{path}`: {error}") from error
        return case_at(path, text)

    def set(self, path: str, value: str | float | bool) -> Case:
        """The case with one field changed or added, as ``--set`` of the command does.

        ``path`` is made of fields, keys and indices (``"data.0.noise"``); ``value`` is RON (``"Additive(0.02)"``)
        or a number. This case stays as it is.
        """
        if not isinstance(path, str):
            raise DataError(f"a {type(path).__name__} is no path of a field: give a text such as \"data.0.noise\"")
        other = Case.__new__(Case)
        other._path = self._path
        value = text_of("the value of a field", value) if isinstance(value, str) else _ron(value)
        other._native = self._native.changed(text_of("the path of a field", path), value)
        return other

    def check(self) -> list[str]:
        """What is odd about the text, with its place. Mistakes are raised when a case is made."""
        return self._native.warnings

    @property
    def text(self) -> str:
        """The spec."""
        return self._native.text

    @property
    def title(self) -> str:
        """Its title."""
        return self._native.title

    @property
    def folder(self) -> Path:
        """Where its data files are looked for."""
        return self._path.parent

    def _files(self, tables: bool, laws: Path | None) -> list[Path]:
        """The files that a result depends on: data unless tables stand in their place, and laws."""
        return self._native.files(tables, laws)

    @property
    def states(self) -> list[str]:
        """Names of the states."""
        return self._native.states

    @property
    def inputs(self) -> list[str]:
        """Names of the inputs."""
        return self._native.inputs

    def __repr__(self) -> str:
        title = f"{self.title!r}, " if self.title else ""
        return f"Case({title}states {', '.join(self.states)})"

    def __reduce__(self) -> tuple[object, ...]:
        return (case_at, (self._path, self.text))


def case_of(value: Any) -> Case:
    """An argument that must be a case."""
    if not isinstance(value, Case):
        hint = "phisindy.Case.from_file(path) reads one" if isinstance(value, str) else "give a phisindy.Case"
        raise DataError(f"a {type(value).__name__} is no case: {hint}")
    return value


def _ron(value: Any) -> str:
    """A number or a truth value in RON."""
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    try:
        return str(operator.index(value))
    except TypeError:
        number = number_of("the value of a field", value)
    if not math.isfinite(number):
        raise DataError(f"the value of a field is {number}: give a finite number, or a text in RON")
    return repr(number)


def case_at(path: Path, text: str) -> Case:
    """A case as if its text stood in a file there."""
    case = Case.__new__(Case)
    case._path = path
    case._native = _native.Case(text, path)
    return case
