"""The recursive estimator: frozen options, explicit state, and one compiled kernel under both calls."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from estimators.dataset import Vector
from estimators.kernels.recursion import N_COUNTERS, advance
from estimators.state import EstimatorState
from estimators.status import Status
from estimators.weights import Weights


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RunTrace:
    """What a batch call saw, one row per sample.

    Attributes:
        prior: prediction before the sample was used, shape (N,).
        posterior: the same regressor times the parameters after the update, shape (N,); NaN where rejected.
        variance: innovation variance in units of the weights, shape (N,).
        rejected: samples whose result was not finite, shape (N,).
        theta: parameters after each sample, shape (N, n); (0, n) if no history was asked for.
    """

    prior: Vector
    posterior: Vector
    variance: Vector
    rejected: NDArray[np.bool_]
    theta: NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RecursiveEstimator:
    """A parameter estimator that learns one sample at a time; holds options only.

    Made by `make_rls`, `make_erls`, `make_rls_kf` and their relatives, one algorithm a file; each says in its
    docstring which equations the weights stand for. Cost per sample is O(n^2), O(n^3) when Rw is positive.

    Attributes:
        weights: as the kernel takes them.
        theta0: parameters at the start, shape (n,).
        n_phi: length of the regressor that `step` takes.
        n_memory: numbers remembered between samples.
    """

    weights: Weights
    theta0: Vector
    n_phi: int
    n_memory: int

    def init(self) -> EstimatorState:
        """Return a fresh state: theta0, and P = diag(p0)."""
        n = self.theta0.size
        return EstimatorState(
            theta=self.theta0.copy(),
            U=np.eye(n),
            D=self.weights.p0.copy(),
            memory=np.zeros(self.n_memory),
            counters=np.zeros(N_COUNTERS),
        )

    def step(self, state: EstimatorState, phi: ArrayLike, y: float) -> Status:
        """Use one sample.

        Args:
            state: advanced in place; if the result is not finite, left as it was but for its count of
                rejections.
            phi: regressor without residual terms, shape (n_phi,).
            y: measured output.

        Returns:
            What happened. Numbers never raise.
        """
        row = np.array(phi, dtype=np.float64, ndmin=2)
        if row.shape != (1, self.n_phi):
            return Status.WRONG_SHAPE
        trace = _new_trace(1, 0, self.theta0.size)
        rejected = self._advance(state, row, np.array([y], dtype=np.float64), trace)
        return Status.NOT_FINITE if rejected else Status.UPDATED

    def run(
        self, state: EstimatorState, phi: NDArray[np.float64], y: Vector, *, keep_history: bool = True
    ) -> RunTrace:
        """Use many samples of one segment: the same numbers as `step` one by one.

        Args:
            state: advanced in place.
            phi: regressors without residual terms, shape (N, n_phi).
            y: measured outputs, shape (N,).
            keep_history: whether to return theta after each sample.

        Raises:
            ValueError: If the shapes do not fit.
        """
        if phi.ndim != 2 or phi.shape[1] != self.n_phi or y.shape != (phi.shape[0],):
            raise ValueError(
                f"phi has shape {phi.shape} and y {y.shape}; this estimator takes (N, {self.n_phi}) and (N,)"
            )
        trace = _new_trace(y.size, y.size if keep_history else 0, self.theta0.size)
        self._advance(state, _as_kernel_array(phi), _as_kernel_array(y), trace)
        return trace

    def _advance(self, state: EstimatorState, phi: NDArray[np.float64], y: Vector, trace: RunTrace) -> int:
        sizes = (0,) * self.n_phi, (0,) * (self.theta0.size - self.n_phi)
        arrays = state.theta, state.U, state.D, state.memory, state.counters
        outputs = trace.prior, trace.posterior, trace.variance, trace.rejected, trace.theta
        # Without compilation numpy's scalars would warn where the compiled kernel yields inf and rejects.
        with np.errstate(all="ignore"):
            return int(advance(sizes, *self.weights, *arrays, phi, y, *outputs))


def _new_trace(n_samples: int, n_history: int, n: int) -> RunTrace:
    return RunTrace(
        prior=np.empty(n_samples),
        posterior=np.empty(n_samples),
        variance=np.empty(n_samples),
        rejected=np.empty(n_samples, dtype=np.bool_),
        theta=np.empty((n_history, n)),
    )


def _as_kernel_array(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a writable C-ordered array: the one layout the kernel is compiled for."""
    return np.require(values, dtype=np.float64, requirements=["C", "W"])
