"""``run``, ``gap``, ``simulate``, ``laws``."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import _native
from ._arguments import jobs_of, method_of, path_of, seed_of
from ._case import Case, case_of
from ._errors import DataError
from ._results import Comparison, Gap, Identified, Motion, NextRun
from ._tables import records

if TYPE_CHECKING:
    from collections.abc import Iterator

Tell = Callable[[float, str], object]


class _Stopping(threading.local):
    """What ends the work of this thread, where another one asks for it."""

    by: _native.Stop | None = None


_stopping = _Stopping()


def stopped_by(stop: _native.Stop) -> None:
    """What this thread works on ends when ``stop`` is set."""
    _stopping.by = stop


def stop_of_thread() -> _native.Stop | None:
    """What ends the work of this thread."""
    return _stopping.by


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
    as the states, outputs and inputs, in the units of the spec, and ``t`` is the time in seconds. Rows must hold finite
    numbers; leave out those with a hole (``DataFrame.dropna``), a gap in time does no harm. Without ``data`` the case's
    own records are used. ``seed`` replaces that of synthetic records, ``method`` is ``"trajectory"`` or
    ``"step"``, ``jobs`` the number of threads, ``laws`` a folder of further laws. ``progress`` is true for a bar, or a
    function of the finished fraction and what is being done.
    """
    native = case_of(case)._native
    given, seed, jobs, folder = records(data, native.headings), seed_of(seed), jobs_of(jobs), _folder(laws)
    method, stop = method_of(method), _stopping.by
    with _heard(progress, "run") as tell:
        found = _native.Run(
            native, given, seed=seed, method_name=method, jobs=jobs, progress=tell, laws=folder, stop=stop
        )
    return Identified(found, case._path)


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
    native = case_of(case)._native
    given, seed, jobs, folder = records(data, native.headings), seed_of(seed), jobs_of(jobs), _folder(laws)
    with _heard(progress, "gap") as tell:
        found = _native.Gap(
            native, given, seed=seed, jobs=jobs, progress=tell, laws=folder, stop=_stopping.by
        )
    return Gap(found, case._path)


def simulate(model: Case | Identified | Gap, data: Any = None, *, seed: int | None = None) -> list[Motion]:
    """The motion along each record: of a model without unknown part its free run, of a synthetic record its truth.

    ``data`` as for ``run``; arrays are in SI.
    """
    native = case_of(model.case if isinstance(model, (Identified, Gap)) else model)._native
    return [Motion(motion) for motion in _native.motions(native, records(data, native.headings), seed_of(seed))]


def compare(
    *paths: str | os.PathLike[str],
    data: str | os.PathLike[str] | None = None,
    laws: str | os.PathLike[str] | None = None,
    client: Any = None,
    jobs: int | None = None,
    progress: bool | Tell = False,
    out: str | os.PathLike[str] | None = None,
) -> Comparison:
    """What changed from an older record to a newer one, or which of many machines stands out: ``phisindy compare``.

    Each path is a spec or the folder of a result (``save``, ``--out``). ``data`` is the folder of data files that do not
    lie beside their specs, ``laws`` one of further laws. Of a fleet each machine may be a task of its own: on the workers
    of ``client``, a ``dask.distributed.Client`` whose workers see the same files, or on ``jobs`` threads with ``out``, a
    file of JSON lines that keeps every machine as it comes: the same call goes on from there. A machine counts as the
    same if the contents of its spec, data and laws are. The numbers are the same to the bit in all of these ways.
    """
    folder = None if data is None else path_of("data", data)
    given, jobs, own = [path_of("path", path) for path in paths], jobs_of(jobs), _folder(laws)
    if client is not None or out is not None:
        from ._fleet import fleet

        return fleet(given, data=folder, laws=own, client=client, jobs=jobs, progress=progress, out=out)
    with _heard(progress, "compare") as tell:
        text, files = _native.compare(
            given, data=folder, laws=own, jobs=jobs, progress=tell, stop=_stopping.by
        )
    return Comparison(text, files)


def next(
    path: str | os.PathLike[str],
    *,
    narrow: str | None = None,
    data: str | os.PathLike[str] | None = None,
    laws: str | os.PathLike[str] | None = None,
    jobs: int | None = None,
    progress: bool | Tell = False,
) -> NextRun:
    """The run that best tells the models apart that a spec or the folder of a result leaves: ``phisindy next``.

    ``narrow`` names the number that a run is to narrow instead. The limits of the rig are ``limits`` of the spec, or what
    its records have shown. ``data`` and ``laws`` as for ``compare``.
    """
    folder = None if data is None else path_of("data", data)
    given, jobs, own = path_of("path", path), jobs_of(jobs), _folder(laws)
    with _heard(progress, "next") as tell:
        text, files = _native.next_run(
            given, narrow=narrow, data=folder, laws=own, jobs=jobs, progress=tell, stop=_stopping.by
        )
    return NextRun(text, files)


def laws(folder: str | os.PathLike[str] | None = None) -> list[dict[str, str]]:
    """The laws of the catalogue: ``id``, ``name``, ``about``, ``reference``, ``text``. ``folder`` holds further ones."""
    keys = ("id", "name", "about", "reference", "text")
    return [dict(zip(keys, law)) for law in _native.laws(_folder(folder))]


def _folder(path: str | os.PathLike[str] | None) -> Path | None:
    return None if path is None else path_of("laws", path)


def teller_of(progress: bool | Tell) -> Tell | None:
    """The function that hears of the progress; none: a bar, or nothing."""
    if isinstance(progress, bool):
        return None
    if not callable(progress):
        raise DataError(f"progress is neither true nor a function: {progress!r}")
    return progress


@contextmanager
def _heard(progress: bool | Tell, what: str) -> Iterator[Tell | None]:
    """What hears of the progress: a function, or a bar of ``tqdm`` where that is installed."""
    own = teller_of(progress)
    made = bars() if own is None and progress else None
    if made is None:
        yield own
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
