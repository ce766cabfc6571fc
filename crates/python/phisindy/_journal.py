"""Finished runs, kept in a file line by line, so that many of them can go on after an interruption."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from types import TracebackType
from typing import IO, Any, Protocol

from . import _native
from ._arguments import path_of
from ._errors import DataError, PhisindyError
from ._tables import tables


class Source(Protocol):
    """What a run is of: a case, or a machine of a fleet."""

    @property
    def text(self) -> str: ...

    @property
    def folder(self) -> Path: ...

    def _files(self, tables: bool, laws: Path | None) -> list[Path]: ...


# What is run: the name of the function, what it is of, its tables, and how.
Work = tuple[str, Source, Any, dict[str, Any]]


@dataclass(frozen=True)
class Failed:
    """A run that raised, in the place of its result; the others go on."""

    error: str
    kind: str


class Journal:
    """The runs that a file holds, or none. A line has the key of its run, and ``result`` or ``failed``."""

    def __init__(self, path: str | os.PathLike[str] | None, works: Sequence[Work]) -> None:
        self._path = None if path is None else path_of("out", path)
        self._file: IO[str] | None = None
        contents: dict[Path, bytes] = {}
        self._keys = [] if path is None else [_key(work, contents) for work in works]
        self._results = {} if self._path is None else _read(self._path)

    def kept(self, place: int) -> dict[str, Any] | None:
        """The result that the file has for a run."""
        return self._results.get(self._keys[place]) if self._results else None

    def keep(self, place: int, found: dict[str, Any] | Failed) -> None:
        """Writes a result; it is in the file when this returns."""
        if self._file is None:
            return
        what = {"failed": asdict(found)} if isinstance(found, Failed) else {"result": found}
        try:
            self._file.write(json.dumps({"key": self._keys[place], **what}) + "\n")
            self._file.flush()
        except OSError as error:
            raise DataError(f"cannot write `{self._path}`: {error}") from error

    def __enter__(self) -> Journal:
        if self._path is not None:
            try:
                self._path.parent.mkdir(parents=True, exist_ok=True)
                self._file = open(self._path, "a", encoding="utf-8")
            except OSError as error:
                raise DataError(f"cannot write `{self._path}`: {error}") from error
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._file is None:
            return
        try:
            self._file.close()
        except OSError:
            # What could not be written at the end of a full disk was refused by `keep`.
            pass


def _key(work: Work, contents: dict[Path, bytes]) -> str:
    """A name for all that a result depends on; ``contents`` are those of files that were read before."""
    name, case, data, options = work
    digest = hashlib.sha256()

    def add(text: str) -> None:
        digest.update(f"{len(text)} {text}".encode())

    for text in (_native.__version__, name, case.text, str(case.folder), json.dumps(options, sort_keys=True, default=str)):
        add(text)
    laws = options.get("laws")
    for file in case._files(data is not None, None if laws is None else path_of("laws", laws)):
        if file not in contents:
            contents[file] = _content(file)
        digest.update(contents[file])
    try:
        for columns in tables(data):
            add(str(len(columns)))
            for column, values in columns:
                add(f"{column} {len(values)}")
                digest.update(values.data)
    except PhisindyError as error:
        # A table that is none has no columns: the run itself will say so.
        add(str(error))
    return digest.hexdigest()


def _content(path: Path) -> bytes:
    """A digest of a file; of one that cannot be read, nothing: the run itself will say so."""
    digest = hashlib.sha256()
    try:
        with open(path, "rb") as file:
            while block := file.read(1 << 20):
                digest.update(block)
    except OSError:
        return b""
    return digest.digest()


def _read(path: Path) -> dict[str, dict[str, Any]]:
    """Results by key. A last line without end was torn when the program was killed: it is cut off."""
    if not path.is_file():  # A device may have no end.
        return {}
    number = 1
    try:
        content = path.read_bytes()
        whole = content.rfind(b"\n") + 1
        found = {}
        for number, text in enumerate(content[:whole].splitlines(), 1):
            line = json.loads(text)
            if "result" in line or "failed" not in line:
                found[line["key"]] = line["result"]
        if whole < len(content):
            if whole == 0 and not content.startswith(b'{"key"'[: len(content)]):
                raise ValueError("there is none")
            os.truncate(path, whole)
        return found
    except OSError as error:
        raise DataError(f"cannot read `{path}`: {error}") from error
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise DataError(
            f"`{path}` holds no results of `map` or `sweep` (line {number}: {error}): remove that line, or give another file"
        ) from error
