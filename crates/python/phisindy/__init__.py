"""The missing part of a mechanical model - above all friction, sticking included - from measured motion.

>>> import numpy as np, phisindy
>>> case = phisindy.Case('''(
...     states: { "x": "m", "v": "m/s" }, constants: { "k": (1.0, "1/s^2") },
...     known: { "x": "v", "v": "-k*x" }, contacts: ["v"],
...     unknown: { "v": (factor: "-sgn(v)", candidates: ["1", "|v|"]) })''')
>>> t = np.arange(0.0, 9.0, 0.01)
>>> swing = np.floor(t / np.pi)
>>> x = 0.3 * (-1.0) ** swing + (1.7 - 0.6 * swing) * np.cos(t)   # friction of 0.3 m/s^2
>>> found = phisindy.run(case, {"t": t, "x": x.round(3)})
>>> found.verdict, round(found.terms[0]["coefficient"], 2)
('identified', 0.3)
"""

from ._case import Case
from ._cluster import map, sweep
from ._draft import Draft, go, new
from ._errors import DataError, NumericsError, PhisindyError, SpecError
from ._estimator import PhisindyRegressor
from ._journal import Failed
from ._results import Comparison, Gap, Identified, Motion, NextRun
from ._sweep import Sweep
from ._work import compare, gap, laws, next, run, simulate
from ._native import __version__

__all__ = [
    "Case",
    "Comparison",
    "DataError",
    "Draft",
    "Failed",
    "Gap",
    "Identified",
    "Motion",
    "NextRun",
    "NumericsError",
    "PhisindyError",
    "PhisindyRegressor",
    "SpecError",
    "Sweep",
    "__version__",
    "compare",
    "gap",
    "go",
    "laws",
    "map",
    "new",
    "next",
    "run",
    "simulate",
    "sweep",
]
