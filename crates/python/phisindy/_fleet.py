"""A fleet: each machine is judged by a task of its own, and then all are compared in one place."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from . import _native
from ._cluster import gathered
from ._errors import DataError
from ._journal import Failed, Journal
from ._results import Comparison
from ._work import Tell, stop_of_thread


@dataclass(frozen=True)
class _Machine:
    """A machine by the path of its spec or result, and where its data and laws are."""

    path: Path
    first: Path
    data: Path | None
    laws: Path | None
    text: str = ""

    @property
    def folder(self) -> Path:
        return self.path

    def _files(self, tables: bool, laws: Path | None) -> list[Path]:
        try:
            return _native.machine_files(self.path, self.first, data=self.data, laws=self.laws)
        except DataError:  # The machine itself will say so.
            return []


def fleet(
    paths: list[Path],
    *,
    data: Path | None,
    laws: Path | None,
    client: Any,
    jobs: int | None,
    progress: bool | Tell,
    out: Any,
) -> Comparison:
    """Many machines, on the threads of this machine or the workers of a cluster."""
    if len(paths) < 3:
        raise DataError(f"compare: {len(paths)} paths are given: `client` and `out` are for a fleet of three or more")
    works = [_Machine(path, paths[0], data, laws) for path in paths]
    journal = Journal(out, [("compare", work, None, {}) for work in works])
    found = gathered(_judged, works, journal, client=client, jobs=jobs, progress=progress, what="compare")
    failed = [(path, one) for path, one in zip(paths, found) if isinstance(one, Failed)]
    if failed:
        path, why = failed[0]
        raise DataError(
            f"{len(failed)} of {len(paths)} machines cannot be judged, the first is `{path}`: {why.error}: "
            "mend or leave them out; with `out` the others are kept"
        )
    return Comparison(*_native.fleet_of([one["machine"] for one in found if not isinstance(one, Failed)]))


def _judged(work: _Machine) -> dict[str, Any]:
    line = _native.machine(
        work.path, work.first, data=work.data, laws=work.laws, jobs=1, stop=stop_of_thread()
    )
    return {"machine": line}
