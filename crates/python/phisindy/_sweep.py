"""The results of many seeds, and what they say together."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Union

from . import _native
from ._journal import Failed

if TYPE_CHECKING:
    from ._case import Case

Result = Union[dict[str, Any], Failed]


class Sweep(list[Result]):
    """The results of a sweep in the order of its seeds: dicts, or a ``Failed`` where a run raised."""

    def __init__(self, case: Case, results: list[Result]) -> None:
        super().__init__(results)
        self._case = case

    def statistics(self) -> dict[str, Any]:
        """How often the terms are right, and how accurate their numbers are: the keys of ``phisindy sweep --format json``.

        ``runs``, ``exact_support`` (runs with exactly the true terms) and ``coefficients``: for each true term its
        ``truth``, in how many runs it is ``found``, and over these the ``median``, the root mean square error ``rmse``
        and ``coverage95``, the fraction whose 95 % interval holds the truth.
        """
        truth = _native.truth(self._case._native)
        found = [_terms(result) for result in self]
        names = {name for name, _ in truth}
        exact = sum(not isinstance(result, Failed) and set(terms) == names for result, terms in zip(self, found))
        coefficients = {name: _coefficient(value, [t[name] for t in found if name in t]) for name, value in truth}
        return {"runs": len(self), "exact_support": exact, "coefficients": coefficients}


def _terms(result: Result) -> dict[str, dict[str, Any]]:
    if isinstance(result, Failed):
        return {}
    return {f"{one['state']}:{term['candidate']}": term for one in result["equations"] for term in one["terms"]}


def _coefficient(truth: float, terms: list[dict[str, Any]]) -> dict[str, Any]:
    count = len(terms)
    values = sorted(term["coefficient"] for term in terms)
    squares, holds = 0.0, 0
    for term in terms:
        squares += (term["coefficient"] - truth) ** 2
        low, high = term["ci95"]
        # An end that is missing is at infinity.
        holds += (low is None or low <= truth) and (high is None or truth <= high)
    middle = 0.5 * (values[(count - 1) // 2] + values[count // 2]) if count else None
    return {
        "truth": truth,
        "found": count,
        "median": middle,
        "rmse": math.sqrt(squares / count) if count else None,
        "coverage95": holds / count if count else None,
    }
