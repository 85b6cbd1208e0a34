"""Recursive estimators on rows that come in pieces; the same numbers whatever the pieces are.

Theory of operation. An estimator is prepared from data: its start values are scaled by the mean square of the
regressors. An identification takes the whole training record for that; here the record is not over, so each estimator
is prepared anew, and run again from the first row, whenever the number of rows has doubled. That costs about two runs
in all, and makes the state after n rows a function of those n rows alone: a replay gives it back to the last digit.
"""

import copy
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.dataset import Dataset
from estimators.metrics import adjust_r2
from estimators.recursive import RecursiveEstimator
from estimators.regressors import build_regression, build_rows
from estimators.settings import IdentifyOptions
from estimators.state import EstimatorState
from estimators.table import BatchSpec, RecursiveSpec, find_estimator
from server.services.live.pipeline import Rows

_FIRST_ROWS = 16
Json = dict[str, Any]  # JSON values


class RowStore:
    """All rows so far; grows by doubling.

    Args:
        sample_time_s: time between rows.
    """

    def __init__(self, sample_time_s: float) -> None:
        self.sample_time_s = sample_time_s
        self.n = 0
        self.starts: list[int] = []
        self._u = np.empty(1024)
        self._y = np.empty(1024)

    def append(self, rows: Rows) -> None:
        """Add rows."""
        if rows.begins:
            self.starts.append(self.n)
        while self.n + rows.u.size > self._u.size:
            self._u, self._y = np.resize(self._u, 2 * self._u.size), np.resize(self._y, 2 * self._y.size)
        self._u[self.n : self.n + rows.u.size] = rows.u
        self._y[self.n : self.n + rows.u.size] = rows.y
        self.n += rows.u.size

    def forget_after(self, n: int) -> None:
        """Take back all rows from row n on."""
        self.n = n
        self.starts = [start for start in self.starts if start < n]

    def dataset(self, stop: int, first: int = 0) -> Dataset:
        """Return rows first..stop-1 as a data set."""
        inner = tuple(start - first for start in self.starts if first < start < stop)
        return Dataset(
            u=self._u[first:stop],
            y=self._y[first:stop],
            sample_time_s=self.sample_time_s,
            starts=(0, *inner),
        )


@dataclass(slots=True)
class _Sums:
    """Running sums of outputs and prediction errors, added one by one so that pieces do not matter."""

    n: int = 0
    offset: float = 0.0
    y: float = 0.0
    y_squared: float = 0.0
    error_squared: float = 0.0

    def add(self, y: NDArray[np.float64], prior: NDArray[np.float64]) -> None:
        if self.n == 0 and y.size:
            self.offset = float(y[0])
        moved, missed = y - self.offset, y - prior
        self.n += y.size
        self.y = _add_up(self.y, moved)
        self.y_squared = _add_up(self.y_squared, moved**2)
        self.error_squared = _add_up(self.error_squared, missed**2)

    def r2_adjusted(self, p: int) -> float:
        total = self.y_squared - self.y**2 / self.n if self.n else 0.0
        return adjust_r2(1.0 - self.error_squared / total, self.n, p) if total > 0.0 else math.nan


class LiveFit:
    """One recursive estimator while it learns.

    Args:
        name: in the table of estimators.
        spec: its entry.
        options: of the identification.
    """

    def __init__(self, name: str, spec: RecursiveSpec, options: IdentifyOptions) -> None:
        self.name = name
        self._spec = spec
        self._options = options
        self._estimator: RecursiveEstimator | None = None
        self._state: EstimatorState | None = None
        self._sums = _Sums()
        self._done = 0
        self._prepare_at = _FIRST_ROWS
        self._last = (math.nan, math.nan)

    def advance(self, store: RowStore) -> None:
        """Use all rows that were not used yet."""
        while True:
            if store.n >= self._prepare_at:
                self._prepare(store)
                continue
            if self._estimator is not None and store.n > self._done:
                self._run(store, store.n)
            return

    def look_ahead(self, store: RowStore) -> Json:
        """Return what `to_json` would be with all rows of the store used; nothing changes.

        The start is not scaled anew by rows that may still change.
        """
        ahead = copy.copy(self)
        if self._state is not None:
            ahead._state, ahead._sums = self._state.copy(), replace(self._sums)
            ahead._run(store, store.n)
        return ahead.to_json()

    def finish(self, store: RowStore) -> None:
        """Scale the start by all rows and run once more, as an identification of the whole record does."""
        self._prepare_at = store.n
        self._prepare(store)

    def to_json(self) -> Json:
        """Return parameters with standard errors, the newest prediction and its error, and the fit so far."""
        if self._estimator is None or self._state is None:
            return {"title": self._spec.title, "parameters": []}
        structure = replace(self._options.structure, nc=self._estimator.theta0.size - self._estimator.n_phi)
        errors, (y, prior) = self._state.standard_errors(), self._last
        return {
            "title": self._spec.title,
            "parameters": [
                {"name": name, "value": _finite(value), "std": _finite(std)}
                for name, value, std in zip(structure.parameter_names, self._state.theta, errors, strict=True)
            ],
            "prediction": _finite(prior),
            "residual": _finite(y - prior),
            "r2_adjusted": _finite(self._sums.r2_adjusted(structure.n_parameters)),
            "rejected": self._state.rejected,
        }

    def _prepare(self, store: RowStore) -> None:
        """Scale the start by the rows so far and run over them again."""
        stop = self._prepare_at
        self._prepare_at *= 2
        try:
            regression = build_regression(store.dataset(stop), self._options.structure)
            self._estimator = self._spec.prepare(regression, self._options)
        except ValueError:  # too few rows for this structure yet
            return
        self._state, self._sums, self._done = self._estimator.init(), _Sums(), 0
        self._run(store, stop)

    def _run(self, store: RowStore, stop: int) -> None:
        estimator, state = self._estimator, self._state
        if estimator is None or state is None:
            return
        first = max(0, self._done - self._options.structure.reach)
        dataset = store.dataset(stop, first)
        regression = build_rows(dataset, self._options.structure, self._done - first)
        begins = {start - first for start in store.starts}
        for bound in regression.bounds:
            rows = regression.rows[bound]
            if int(rows[0]) - self._options.structure.reach in begins:
                state.begin_segment()
            trace = estimator.run(state, regression.phi[bound], regression.y[bound], keep_history=False)
            self._sums.add(regression.y[bound], trace.prior)
            self._last = float(regression.y[bound][-1]), float(trace.prior[-1])
        self._done = stop


def make_fits(methods: Sequence[str], options: IdentifyOptions) -> Mapping[str, LiveFit | None]:
    """Return the live fit of each method; None for those that take all samples at once, at the end."""
    fits: dict[str, LiveFit | None] = {}
    for name in methods:
        spec = find_estimator(name)
        fits[name] = None if isinstance(spec, BatchSpec) else LiveFit(name, spec, options)
    return fits


def _add_up(total: float, values: NDArray[np.float64]) -> float:
    """Add values one after the other (numpy's own sum adds in pairs, which depends on how many there are)."""
    return float(np.cumsum(np.concatenate([[total], values]))[-1])


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
