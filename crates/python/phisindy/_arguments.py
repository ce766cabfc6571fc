"""Arguments of a wrong kind, refused before any work begins."""

from __future__ import annotations

import operator
import os
from pathlib import Path
from typing import Any

from ._errors import DataError

# Seeds are numbers of 64 bits; the command takes as many threads.
LARGEST_SEED = 2**64 - 1
LARGEST_JOBS = 2**16 - 1


def seed_of(value: Any) -> int | None:
    """A seed, or none."""
    return None if value is None else whole_seed(value)


def jobs_of(value: Any) -> int | None:
    """A number of threads; none: one for each core."""
    return None if value is None else _whole("jobs", value, 1, LARGEST_JOBS)


def number_of(what: str, value: Any) -> float:
    """A real number."""
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError) as error:
        raise DataError(f"{what} is no number: {value!r}") from error


def method_of(value: Any) -> str | None:
    """The name of a method of ``run``; none: the program chooses."""
    if value not in (None, "step", "trajectory"):
        raise DataError(f'there is no method {value!r}: give "step" or "trajectory"')
    found: str | None = value
    return found


def path_of(what: str, value: Any) -> Path:
    """A path, whether something is there or not."""
    try:
        path = Path(value)
        os.fsencode(path)
    except (TypeError, ValueError) as error:
        raise DataError(f"{what} is no path: {value!r}") from error
    return path


def text_of(what: str, value: str) -> str:
    """A text that can be written: halves of characters of UTF-16 (surrogates) cannot."""
    try:
        value.encode()
    except UnicodeEncodeError as error:
        raise DataError(f"{what} is no text in Unicode: {error}") from error
    return value


def whole_seed(value: Any) -> int:
    """A seed."""
    return _whole("seed", value, 0, LARGEST_SEED)


def _whole(what: str, value: Any, least: int, largest: int) -> int:
    try:
        number = operator.index(value)
    except TypeError as error:
        raise DataError(f"{what} is no whole number: {value!r}") from error
    if not least <= number <= largest:
        raise DataError(f"{what} is {number}: give a whole number from {least} to {largest}")
    return number
