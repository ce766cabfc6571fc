"""Many runs: on the threads of this machine, or on the workers of a Dask cluster."""

from __future__ import annotations

import functools
import inspect
import os
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import closing, contextmanager
from typing import Any

import numpy as np

from . import _native
from ._arguments import jobs_of, method_of, whole_seed
from ._case import Case, case_of
from ._errors import DataError
from ._journal import Failed, Journal
from ._results import Gap, Identified
from ._sweep import Result, Sweep
from ._work import Tell, stopped_by, teller_of
from ._work import bars as _bars

# Tasks handed to the cluster for each of its threads: enough to keep all of them at work until the end.
TASKS_PER_THREAD = 4
# Most runs in a task: what a worker that dies has to do again, and what is kept at once.
LARGEST_TASK = 100


def sweep(
    case: Case,
    seeds: int | Iterable[int],
    *,
    client: Any = None,
    jobs: int | None = None,
    method: str | None = None,
    progress: bool | Tell = False,
    out: str | os.PathLike[str] | None = None,
) -> Sweep:
    """Runs a case with synthetic data with many seeds; the results as dicts in the order of the seeds.

    A number of seeds stands for 0, 1, 2, ... Every result is that of ``run(case, seed=seed)`` to the bit, wherever it
    was computed. ``client`` is a ``dask.distributed.Client``; without, ``jobs`` threads of this machine work.
    ``.statistics()`` of the result says how often the terms are right and how often the intervals hold. ``out`` is a
    file of JSON lines that keeps every finished run: the same call goes on from there. ``progress`` is true for a bar,
    or a function of the finished fraction and what is being done.
    """
    if not case_of(case)._native.synthetic:
        raise DataError("no record of this case is `Synthetic`, so there is no truth to compare with")
    method_of(method)
    all_seeds = _seeds(seeds)
    work = [(case, seed, method) for seed in all_seeds]
    journal = Journal(out, [("sweep", case, None, {"seed": seed, "method": method}) for seed in all_seeds])
    return Sweep(case, gathered(_one_seed, work, journal, client=client, jobs=jobs, progress=progress, what="sweep"))


def map(
    function: Callable[..., Any],
    cases: Iterable[Any],
    *,
    client: Any = None,
    jobs: int | None = None,
    progress: bool | Tell = False,
    out: str | os.PathLike[str] | None = None,
    **options: Any,
) -> list[Result]:
    """``function`` (``run`` or ``gap``) on many cases; the results as dicts in the order of the cases.

    A case is a ``Case`` or a pair of a ``Case`` and its data. One that fails is a ``Failed`` with the reason, and the
    others go on. ``out`` is a file of JSON lines that keeps every result as it comes: the same call goes on from there,
    and tries again what failed. A case counts as the same if its text, its folder, its tables, the contents of the files
    that it names, the laws and ``options`` are. ``options`` go to the function (``method="step"``); ``progress`` as
    of ``sweep``. A function of your own takes what ``run`` takes, and returns what it returns.
    """
    name = _called(function, options)
    if isinstance(cases, Case) or not isinstance(cases, Iterable):
        raise DataError(f"map: a {type(cases).__name__} is given: give a list of cases, or of pairs of a case and its data")
    pairs = [_pair(case) for case in cases]
    work = [(function, case, data, options) for case, data in pairs]
    journal = Journal(out, [(name, case, data, options) for case, data in pairs])
    return gathered(_one_case, work, journal, client=client, jobs=jobs, progress=progress, what="map")


def _seeds(given: int | Iterable[int]) -> list[int]:
    """The seeds of a sweep."""
    if isinstance(given, (int, np.integer)):
        if given < 1:
            raise DataError(f"seeds is {given}: give a number of runs, or the seeds themselves")
        return list(range(int(given)))
    if isinstance(given, (str, bytes)) or not isinstance(given, Iterable):
        raise DataError(f"seeds is {given!r}: give a number of runs, or the seeds themselves")
    return [whole_seed(one) for one in given]


def _called(function: Any, options: dict[str, Any]) -> str:
    """The name of a function that can be called with a case, its data and these options."""
    if not callable(function):
        raise DataError(f"map: {function!r} is no function: give phisindy.run or phisindy.gap")
    name = _name(function)
    try:
        inspect.signature(function).bind(None, None, jobs=1, **options)
    except TypeError as error:
        raise DataError(f"map: {name} cannot be called with a case, its data and these options: {error}") from error
    except ValueError:  # It does not tell what it takes.
        pass
    return name


def _name(function: Any) -> str:
    """A name that differs where the results may."""
    if isinstance(function, functools.partial):
        return f"{_name(function.func)} with {function.args} {sorted(function.keywords.items())}"
    return str(getattr(function, "__name__", type(function).__name__))


def _pair(given: Any) -> tuple[Case, Any]:
    """A case and its data."""
    if isinstance(given, tuple) and len(given) != 2:
        raise DataError(f"map: a tuple of {len(given)} is given: give a pair of a case and its data")
    case, data = given if isinstance(given, tuple) else (given, None)
    return case_of(case), data


def _one_seed(work: tuple[Case, int, str | None]) -> dict[str, Any]:
    from ._work import run

    case, seed, method = work
    return _plain(run(case, seed=seed, method=method, jobs=1).to_dict()) | {"seed": seed}


def _one_case(work: tuple[Callable[..., Any], Case, Any, dict[str, Any]]) -> dict[str, Any]:
    function, case, data, options = work
    found = function(case, data, jobs=1, **options)
    if not isinstance(found, (Gap, Identified)):
        raise DataError(f"map: {_name(function)} returned a {type(found).__name__}, no result of run or gap")
    return _plain(found.to_dict())


def _plain(result: dict[str, Any]) -> dict[str, Any]:
    """A result without what differs between two runs of the same: its duration."""
    result.pop("seconds", None)
    return result


def _chunk(task: Callable[[Any], dict[str, Any]], works: list[Any]) -> list[Result]:
    def done(work: Any) -> Result:
        try:
            return task(work)
        except Exception as error:  # A function of the user may raise anything, and the other cases go on.
            return Failed(str(error), type(error).__name__)

    return [done(work) for work in works]


def _chunk_of_worker(task: Callable[[Any], dict[str, Any]], works: list[Any]) -> list[Result]:
    """A chunk on a worker of Dask, which does not interrupt a task that nobody waits for any more."""
    from dask import distributed

    worker: Any = distributed.get_worker()
    key = worker.get_current_task()
    found: list[Result] = []
    for work in works:
        mine = worker.state.tasks.get(key)
        if mine is None or mine.state == "cancelled":
            # Not the part that is done: if it is wanted again meanwhile, it begins anew.
            raise RuntimeError("cancelled")
        found += _chunk(task, [work])
    return found


def gathered(
    task: Callable[[Any], dict[str, Any]],
    works: list[Any],
    journal: Journal,
    *,
    client: Any,
    jobs: int | None,
    progress: bool | Tell,
    what: str,
) -> list[Result]:
    """The results of all works in their order: those of the journal, and the others as they come."""
    jobs, teller = jobs_of(jobs), teller_of(progress)
    if client is not None and not (hasattr(client, "submit") and hasattr(client, "nthreads")):
        raise DataError(f"client is a {type(client).__name__}: give a dask.distributed.Client")
    results: list[Any] = [journal.kept(place) for place in range(len(works))]
    places = [place for place, found in enumerate(results) if found is None]
    todo = [works[place] for place in places]
    with journal, _counted(teller, bool(progress), len(todo), what) as count:
        # Closed at once, whatever happens: a notebook keeps what Ctrl-C left behind.
        with closing(_chunks(task, todo, client, jobs)) as chunks:
            for start, chunk in chunks:
                for place, found in zip(places[start : start + len(chunk)], chunk):
                    results[place] = found
                    journal.keep(place, found)
                count(len(chunk))
    return results


def _chunks(
    task: Callable[[Any], dict[str, Any]], works: list[Any], client: Any, jobs: int | None
) -> Generator[tuple[int, list[Result]]]:
    """Chunks of results as they come, each with the place of its first one."""
    if not works:
        return
    yield from _on_threads(task, works, jobs) if client is None else _on_cluster(task, works, client)


def _on_threads(
    task: Callable[[Any], dict[str, Any]], works: list[Any], jobs: int | None
) -> Generator[tuple[int, list[Result]]]:
    stop = _native.Stop()
    pool = ThreadPoolExecutor(jobs or os.cpu_count(), initializer=stopped_by, initargs=(stop,))
    try:
        futures = {pool.submit(_chunk, task, [work]): place for place, work in enumerate(works)}
        for future in as_completed(futures):
            # What is done is not needed here any more: of a million results one copy is enough.
            yield futures.pop(future), future.result()
    finally:
        stop.set()
        pool.shutdown(cancel_futures=True)


def _on_cluster(
    task: Callable[[Any], dict[str, Any]], works: list[Any], client: Any
) -> Generator[tuple[int, list[Result]]]:
    from dask import distributed

    finished: Any = distributed.as_completed
    threads = max(1, sum(client.nthreads().values()))
    size = min(LARGEST_TASK, max(1, -(-len(works) // (TASKS_PER_THREAD * threads))))
    # A worker that dies is no mistake of the task: Dask gives it to another one.
    futures = {
        client.submit(_chunk_of_worker, task, works[place : place + size], pure=False, retries=3): place
        for place in range(0, len(works), size)
    }
    try:
        for future, chunk in finished(list(futures), with_results=True):
            yield futures.pop(future), chunk
    finally:
        # After Ctrl-C the workers are to be free for other work.
        client.cancel(list(futures))


@contextmanager
def _counted(
    teller: Tell | None, shown: bool, total: int, what: str
) -> Iterator[Callable[[int], object]]:
    """What counts finished runs: for a function, on a bar, or not at all."""
    done = 0

    def tell(more: int) -> None:
        nonlocal done
        done += more
        if teller is not None:
            teller(done / total, what)

    bars = _bars() if teller is None and shown else None
    if bars is None:
        yield tell
        return
    with bars(total=total, desc=what) as bar:
        yield bar.update
