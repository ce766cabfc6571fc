"""Many runs: on the threads of this machine, or on the workers of a Dask cluster."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ._errors import PhisindyError

if TYPE_CHECKING:
    from ._case import Case

# Tasks handed to the cluster for each of its threads: enough to keep all of them at work until the end.
TASKS_PER_THREAD = 4


@dataclass(frozen=True)
class Failed:
    """A run that raised, in the place of its result; the others go on."""

    error: str
    kind: str


def sweep(
    case: Case,
    seeds: int | Iterable[int],
    *,
    client: Any = None,
    jobs: int | None = None,
    method: str | None = None,
    progress: bool = False,
) -> list[dict[str, Any] | Failed]:
    """Runs a case with synthetic data with many seeds; the results as dicts in the order of the seeds.

    A number of seeds stands for 0, 1, 2, ... Every result is that of ``run(case, seed=seed)`` to the bit, wherever it
    was computed. ``client`` is a ``dask.distributed.Client``; without, ``jobs`` threads of this machine work.
    """
    all_seeds = list(range(seeds) if isinstance(seeds, int) else seeds)
    work = [(case, seed, method) for seed in all_seeds]
    return _gathered(_one_seed, work, client=client, jobs=jobs, progress=progress, what="sweep")


def map(
    function: Callable[..., Any],
    cases: Sequence[Any],
    *,
    client: Any = None,
    jobs: int | None = None,
    progress: bool = False,
) -> list[dict[str, Any] | Failed]:
    """``function`` (``run`` or ``gap``) on many cases; the results as dicts in the order of the cases.

    A case is a ``Case`` or a pair of a ``Case`` and its data. One that fails is a ``Failed`` with the reason, and the
    others go on.
    """
    work = [(function, case) for case in cases]
    return _gathered(_one_case, work, client=client, jobs=jobs, progress=progress, what="map")


def _one_seed(work: tuple[Case, int, str | None]) -> dict[str, Any]:
    from ._work import run

    case, seed, method = work
    return _plain(run(case, seed=seed, method=method, jobs=1).to_dict()) | {"seed": seed}


def _one_case(work: tuple[Callable[..., Any], Any]) -> dict[str, Any]:
    function, case = work
    case, data = case if isinstance(case, tuple) else (case, None)
    return _plain(function(case, data, jobs=1).to_dict())


def _plain(result: dict[str, Any]) -> dict[str, Any]:
    """A result without what differs between two runs of the same: its duration."""
    result.pop("seconds", None)
    return result


def _chunk(task: Callable[[Any], dict[str, Any]], works: list[Any]) -> list[dict[str, Any] | Failed]:
    def done(work: Any) -> dict[str, Any] | Failed:
        try:
            return task(work)
        except PhisindyError as error:
            return Failed(str(error), type(error).__name__)

    return [done(work) for work in works]


def _gathered(
    task: Callable[[Any], dict[str, Any]],
    works: list[Any],
    *,
    client: Any,
    jobs: int | None,
    progress: bool,
    what: str,
) -> list[dict[str, Any] | Failed]:
    results: list[Any] = [None] * len(works)
    for place, chunk in _with_bar(_chunks(task, works, client, jobs), len(works), progress, what):
        results[place : place + len(chunk)] = chunk
    return results


def _chunks(
    task: Callable[[Any], dict[str, Any]], works: list[Any], client: Any, jobs: int | None
) -> Iterator[tuple[int, list[dict[str, Any] | Failed]]]:
    """Chunks of results as they come, each with the place of its first one."""
    if client is None:
        with ThreadPoolExecutor(jobs or os.cpu_count()) as pool:
            futures = {pool.submit(_chunk, task, [work]): place for place, work in enumerate(works)}
            for future in as_completed(futures):
                yield futures[future], future.result()
        return
    from dask.distributed import as_completed as as_dask_completed

    threads = max(1, sum(client.nthreads().values()))
    size = max(1, -(-len(works) // (TASKS_PER_THREAD * threads)))
    # A worker that dies is no mistake of the task: Dask gives it to another one.
    futures = {
        client.submit(_chunk, task, works[place : place + size], pure=False, retries=3): place
        for place in range(0, len(works), size)
    }
    for future, chunk in as_dask_completed(list(futures), with_results=True):
        yield futures[future], chunk


def _with_bar(
    chunks: Iterator[tuple[int, list[Any]]], total: int, progress: bool, what: str
) -> Iterator[tuple[int, list[Any]]]:
    try:
        from tqdm.auto import tqdm
    except ImportError:
        progress = False
    if not progress:
        yield from chunks
        return
    with tqdm(total=total, desc=what) as bar:
        for place, chunk in chunks:
            yield place, chunk
            bar.update(len(chunk))
