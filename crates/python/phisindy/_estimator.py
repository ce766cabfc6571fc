"""An estimator in the manner of scikit-learn: it predicts the motion from the inputs."""

from __future__ import annotations

import reprlib
from typing import Any

import numpy as np
import numpy.typing as npt

from ._case import Case
from ._errors import DataError
from ._results import Identified
from ._work import run

Array = npt.NDArray[np.float64]


class PhisindyRegressor:
    """Identifies a model on one record and predicts the motion on another one.

    ``spec`` is a ``Case`` or the text of one. ``X`` has a column for the time in seconds, then one for each input of the
    case; ``y`` has a column for each name in ``columns`` (default: the first state). Units are those of the spec.
    ``predict`` starts at ``start_`` - the state at which the fit starts - unless ``start`` gives another one, and takes
    the rows of ``X`` as one record.

    Works with ``cross_val_score`` and ``GridSearchCV`` where folds are runs of neighbouring rows
    (``KFold(shuffle=False)``, ``TimeSeriesSplit``): a motion cannot be shuffled. ``score`` is the coefficient of
    determination, with the start state of the scored rows fitted on their first tenth.
    """

    def __init__(
        self,
        spec: str | Case = "",
        columns: tuple[str, ...] | list[str] | None = None,
        method: str | None = None,
        start: dict[str, float] | None = None,
        jobs: int | None = None,
    ) -> None:
        self.spec = spec
        self.columns = columns
        self.method = method
        self.start = start
        self.jobs = jobs

    def get_params(self, deep: bool = True) -> dict[str, Any]:
        """The arguments of the constructor."""
        return {name: getattr(self, name) for name in ("spec", "columns", "method", "start", "jobs")}

    def set_params(self, **params: Any) -> PhisindyRegressor:
        """Changes arguments of the constructor."""
        for name, value in params.items():
            if name not in self.get_params():
                raise ValueError(f"there is no parameter `{name}`: there is {', '.join(self.get_params())}")
            setattr(self, name, value)
        return self

    def __sklearn_tags__(self) -> Any:
        from sklearn.utils import InputTags, RegressorTags, Tags, TargetTags

        return Tags(
            estimator_type="regressor",
            target_tags=TargetTags(required=True),
            regressor_tags=RegressorTags(),
            input_tags=InputTags(),
        )

    def __repr__(self) -> str:
        given = {name: value for name, value in self.get_params().items() if value not in (None, "")}
        return f"PhisindyRegressor({', '.join(f'{name}={reprlib.repr(value)}' for name, value in given.items())})"

    def fit(self, X: Any, y: Any) -> PhisindyRegressor:
        """Identifies the unknown part."""
        self.case_ = self.spec if isinstance(self.spec, Case) else Case(self.spec)
        self.result_: Identified = run(self.case_, self._table(X, y), method=self.method, jobs=self.jobs)
        self.n_features_in_ = 1 + len(self.case_.inputs)
        first = self.result_.records[0].get("start") or {}
        # Results are in SI, a start is in the units of the spec.
        factors = dict(self.case_._native.factors)
        self.start_ = {name: value / factors[name] for name, value in first.items()}
        return self

    def predict(self, X: Any) -> Array:
        """The motion at the rows of ``X``, a column for each name."""
        result, rows = self._fitted(), self._rows(X)
        inputs = {name: rows[:, 1 + k] for k, name in enumerate(self.case_.inputs)}
        motion, factors = result.simulate(rows[:, 0], inputs, self.start or self.start_), dict(self.case_._native.factors)
        shown = np.column_stack([motion[name] / factors[name] for name in self._columns()])
        return shown[:, 0] if shown.shape[1] == 1 else shown

    def score(self, X: Any, y: Any) -> float:
        """The coefficient of determination of the free run along these rows, the mean over the columns."""
        model, rows = self._fitted().case, self._rows(X)
        data = self._table(rows, y)
        again = run(model, data, method=self.method, jobs=self.jobs)
        errors = again.records[0]["nrmse"].values()
        return float(np.mean([1.0 - error**2 for error in errors]))

    def _fitted(self) -> Identified:
        if not hasattr(self, "result_"):
            raise DataError("the estimator is not fitted yet: call fit(X, y) first")
        return self.result_

    def _columns(self) -> list[str]:
        return list(self.columns) if self.columns else self.case_.states[:1]

    def _rows(self, X: Any) -> Array:
        rows = _numbers("X", X)
        if rows.ndim != 2 or rows.shape[1] != 1 + len(self.case_.inputs):
            raise DataError(
                f"X has the shape {rows.shape}: give the time and {len(self.case_.inputs)} inputs as columns"
            )
        return rows

    def _table(self, X: Any, y: Any) -> dict[str, Any]:
        rows, shown = self._rows(X), _numbers("y", y)
        shown = shown.reshape(len(shown), -1) if shown.size else shown.reshape(0, len(self._columns()))
        names = self._columns()
        if shown.shape[1] != len(names):
            raise DataError(f"y has {shown.shape[1]} columns for {len(names)} names: {', '.join(names)}")
        table: dict[str, Any] = {"t": rows[:, 0]}
        table |= {name: rows[:, 1 + k] for k, name in enumerate(self.case_.inputs)}
        return table | {name: shown[:, k] for k, name in enumerate(names)}


def _numbers(what: str, values: Any) -> Array:
    """The values as doubles."""
    try:
        array: Array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise DataError(f"{what} holds no numbers: {error}") from error
    if array.ndim == 0:
        raise DataError(f"{what} is a single number: give one for each row")
    return array
