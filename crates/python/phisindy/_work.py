"""``run``, ``gap``, ``simulate``, ``laws``."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import _native
from ._results import Gap, Identified, Motion
from ._tables import tables

if TYPE_CHECKING:
    from collections.abc import Iterator

    from ._case import Case

Tell = Callable[[float, str], object]


def run(
    case: Case,
    data: Any = None,
    *,
    seed: int | None = None,
    method: str | None = None,
    jobs: int | None = None,
    progress: bool | Tell = False,
    laws: str | os.PathLike[str] | None = None,
) -> Identified:
    """Identifies the unknown part of a case, as ``phisindy run`` does, to the same bits.

    ``data`` is a table or a list of tables: a dict of arrays, or a table of pandas, polars, pyarrow. If the case has
    records with files, each table stands in the place of a file and has its columns; otherwise the columns are called
    as the states, outputs and inputs, in the units of the spec, and ``t`` is the time in seconds. Without ``data`` the
    case's own records are used. ``seed`` replaces that of synthetic records, ``method`` is ``"trajectory"`` or
    ``"step"``, ``jobs`` the number of threads, ``laws`` a folder of further laws. ``progress`` is true for a bar, or a
    function of the finished fraction and what is being done.
    """
    with _heard(progress, "run") as tell:
        found = _native.Run(
            case._native, tables(data), seed=seed, method_name=method, jobs=jobs, progress=tell, laws=_path(laws)
        )
    return Identified(found)


def gap(
    case: Case,
    data: Any = None,
    *,
    seed: int | None = None,
    jobs: int | None = None,
    progress: bool | Tell = False,
    laws: str | os.PathLike[str] | None = None,
) -> Gap:
    """Finds which laws a model lacks, as ``phisindy gap`` does, to the same bits. Arguments as of ``run``."""
    with _heard(progress, "gap") as tell:
        found = _native.Gap(case._native, tables(data), seed=seed, jobs=jobs, progress=tell, laws=_path(laws))
    return Gap(found)


def simulate(model: Case | Identified | Gap, data: Any = None, *, seed: int | None = None) -> list[Motion]:
    """The motion along each record: of a model without unknown part its free run, of a synthetic record its truth.

    ``data`` as for ``run``; arrays are in SI.
    """
    from ._case import Case

    case = model if isinstance(model, Case) else model.case
    return [Motion(motion) for motion in _native.motions(case._native, tables(data), seed)]


def laws(folder: str | os.PathLike[str] | None = None) -> list[dict[str, str]]:
    """The laws of the catalogue: ``id``, ``name``, ``about``, ``reference``, ``text``. ``folder`` holds further ones."""
    keys = ("id", "name", "about", "reference", "text")
    return [dict(zip(keys, law)) for law in _native.laws(_path(folder))]


def _path(path: str | os.PathLike[str] | None) -> Path | None:
    return None if path is None else Path(path)


@contextmanager
def _heard(progress: bool | Tell, what: str) -> Iterator[Tell | None]:
    """What hears of the progress: a function, or a bar of ``tqdm`` where that is installed."""
    if not isinstance(progress, bool):
        yield progress
        return
    made = bars() if progress else None
    if made is None:
        yield None
        return
    with made(total=1000, desc=what, bar_format="{l_bar}{bar}| {elapsed}") as bar:

        def tell(fraction: float, activity: str) -> None:
            bar.n = round(1000 * fraction)
            bar.set_description(activity or what, refresh=False)
            bar.refresh()

        yield tell


def bars() -> Any:
    """The bars of ``tqdm``, or none where that is not installed."""
    try:
        from tqdm.auto import tqdm
    except ImportError:
        return None
    return tqdm
