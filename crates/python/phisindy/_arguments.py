"""Arguments of a wrong kind, refused before any work begins."""

from __future__ import annotations

import operator
from typing import TYPE_CHECKING, Any

from ._errors import DataError

if TYPE_CHECKING:
    from ._case import Case

# Seeds are numbers of 64 bits; the command takes as many threads.
LARGEST_SEED = 2**64 - 1
LARGEST_JOBS = 2**16 - 1


def seed_of(value: Any) -> int | None:
    """A seed, or none."""
    return None if value is None else _whole("seed", value, 0, LARGEST_SEED)


def jobs_of(value: Any) -> int | None:
    """A number of threads; none: one for each core."""
    return None if value is None else _whole("jobs", value, 1, LARGEST_JOBS)


def case_of(value: Any) -> Case:
    """A case."""
    from ._case import Case

    if not isinstance(value, Case):
        hint = "phisindy.Case.from_file(path) reads one" if isinstance(value, str) else "give a phisindy.Case"
        raise DataError(f"a {type(value).__name__} is no case: {hint}")
    return value


def number_of(what: str, value: Any) -> float:
    """A real number."""
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError) as error:
        raise DataError(f"{what} is no number: {value!r}") from error


def _whole(what: str, value: Any, least: int, largest: int) -> int:
    try:
        number = operator.index(value)
    except TypeError as error:
        raise DataError(f"{what} is no whole number: {value!r}") from error
    if not least <= number <= largest:
        raise DataError(f"{what} is {number}: give a whole number from {least} to {largest}")
    return number
