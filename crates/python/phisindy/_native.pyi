"""Types of the compiled module."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, final

from ._tables import Column, Columns

__all__ = [
    "Case",
    "DataError",
    "Gap",
    "NumericsError",
    "PhisindyError",
    "Run",
    "SpecError",
    "Stop",
    "__version__",
    "compare",
    "fleet_of",
    "machine",
    "machine_files",
    "draft",
    "next_run",
    "laws",
    "motion",
    "motions",
    "program",
    "rates",
    "save",
    "truth",
]

__version__: str

class PhisindyError(Exception):
    """Anything that phisindy refuses: ``mistakes`` has what is wrong in a text as dicts, with file, line and column."""

    mistakes: Sequence[dict[str, Any]]

class SpecError(PhisindyError):
    """A mistake in a spec: the text shows each with its line."""

class DataError(PhisindyError):
    """Data that make no sense with the case."""

class NumericsError(PhisindyError):
    """A computation that failed."""

@final
class Case:
    def __new__(cls, text: str, path: Path) -> Case: ...
    def changed(self, path: str, value: str) -> Case: ...
    def files(self, tables: bool, laws: Path | None) -> list[Path]: ...
    @property
    def text(self) -> str: ...
    @property
    def title(self) -> str: ...
    @property
    def states(self) -> list[str]: ...
    @property
    def inputs(self) -> list[str]: ...
    @property
    def headings(self) -> list[str] | None: ...
    @property
    def factors(self) -> list[tuple[str, float]]: ...
    @property
    def synthetic(self) -> bool: ...
    @property
    def warnings(self) -> list[str]: ...

@final
class Stop:
    def __new__(cls) -> Stop: ...
    def set(self) -> None: ...

@final
class Run:
    def __new__(
        cls,
        case: Case,
        tables: list[Columns],
        *,
        seed: int | None = None,
        method_name: str | None = None,
        jobs: int | None = None,
        progress: Callable[[float, str], object] | None = None,
        laws: Path | None = None,
        stop: Stop | None = None,
    ) -> Run: ...
    def json(self) -> str: ...
    def written(self) -> str: ...
    def latex(self) -> str: ...
    def shown(self) -> list[tuple[str, str, str, Column, Column, Column]]: ...
    def files(self) -> list[tuple[str, str]]: ...
    def model(self) -> str: ...

@final
class Gap:
    def __new__(
        cls,
        case: Case,
        tables: list[Columns],
        *,
        seed: int | None = None,
        jobs: int | None = None,
        progress: Callable[[float, str], object] | None = None,
        laws: Path | None = None,
        stop: Stop | None = None,
    ) -> Gap: ...
    def json(self) -> str: ...
    def written(self) -> str: ...
    def latex(self) -> str: ...
    def shown(self) -> list[tuple[str, str, str, Column, Column, Column]]: ...
    def files(self) -> list[tuple[str, str]]: ...
    def model(self) -> str: ...

def program(line: list[str]) -> int: ...
def laws(folder: Path | None = None) -> list[tuple[str, str, str, str, str]]: ...
def motions(case: Case, tables: list[Columns], seed: int | None = None) -> list[dict[str, Any]]: ...
def motion(case: Case, table: Columns, start: str) -> dict[str, Any]: ...
def rates(case: Case, table: Columns) -> list[tuple[str, Column]]: ...
def truth(case: Case) -> list[tuple[str, float]]: ...
def draft(
    path: Path,
    bytes: bytes | None,
    sheet: str | None,
    rate: float | None,
    columns: list[str],
    time_unit: str | None,
    counts: list[tuple[str | None, str]],
    rig: str | None,
) -> tuple[str, list[str], list[str]]: ...
def compare(
    paths: list[Path],
    *,
    data: Path | None = None,
    laws: Path | None = None,
    jobs: int | None = None,
    progress: Callable[[float, str], object] | None = None,
    stop: Stop | None = None,
) -> tuple[str, list[tuple[str, str]]]: ...
def machine(
    path: Path,
    first: Path,
    *,
    data: Path | None = None,
    laws: Path | None = None,
    jobs: int | None = None,
    stop: Stop | None = None,
) -> str: ...
def machine_files(path: Path, first: Path, *, data: Path | None = None, laws: Path | None = None) -> list[Path]: ...
def fleet_of(machines: list[str]) -> tuple[str, list[tuple[str, str]]]: ...
def next_run(
    path: Path,
    *,
    narrow: str | None = None,
    data: Path | None = None,
    laws: Path | None = None,
    jobs: int | None = None,
    progress: Callable[[float, str], object] | None = None,
    stop: Stop | None = None,
) -> tuple[str, list[tuple[str, str]]]: ...
def save(files: list[tuple[str, str]], folder: Path, force: bool) -> None: ...
