"""What a recursive estimator has learnt: an explicit object that can be copied, compared, saved and replayed."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import cast

import numpy as np
from numpy.typing import NDArray

from estimators.dataset import Vector
from estimators.kernels.recursion import ACCEPTED, LOSS, REJECTED, WEIGHT, WEIGHT_SQUARED


@dataclass(slots=True, kw_only=True, eq=False)
class EstimatorState:
    """Everything an estimator has learnt; `step` changes it in place, nothing else does.

    Attributes:
        theta: parameters, shape (n,).
        U: unit upper triangular factor of P = U diag(D) U', shape (n, n).
        D: diagonal factor of P, shape (n,), never negative.
        memory: past residuals (extended RLS) or the previous regressor (literal Algorithm 1).
        counters: accepted and rejected samples, sums of weights and of squared weights, weighted loss.
    """

    theta: Vector
    U: NDArray[np.float64]
    D: Vector
    memory: Vector
    counters: Vector

    @property
    def accepted(self) -> int:
        """Samples used so far."""
        return int(self.counters[ACCEPTED])

    @property
    def rejected(self) -> int:
        """Samples refused so far."""
        return int(self.counters[REJECTED])

    def copy(self) -> "EstimatorState":
        """Return an independent copy."""
        return EstimatorState(**{field.name: getattr(self, field.name).copy() for field in fields(self)})

    def __eq__(self, other: object) -> bool:
        """Compare number for number."""
        if not isinstance(other, EstimatorState):
            return NotImplemented
        return all(np.array_equal(getattr(self, f.name), getattr(other, f.name)) for f in fields(self))

    __hash__ = None  # type: ignore[assignment]  # mutable, so not hashable

    def to_dict(self) -> dict[str, object]:
        """Return a JSON-ready copy; `from_dict` restores it bit for bit."""
        return {field.name: getattr(self, field.name).tolist() for field in fields(self)}

    @staticmethod
    def from_dict(data: Mapping[str, object]) -> "EstimatorState":
        """Restore what `to_dict` saved."""
        n = len(cast(Sequence[float], data["theta"]))
        arrays = {f.name: np.array(data[f.name], dtype=np.float64) for f in fields(EstimatorState)}
        arrays["U"] = arrays["U"].reshape(n, n)
        return EstimatorState(**arrays)

    def covariance_factor(self) -> NDArray[np.float64]:
        """Return P = U diag(D) U', shape (n, n), in units of the weights."""
        return (self.U * self.D) @ self.U.T

    def noise_variance(self) -> float:
        """Return the variance of the equation error in units of Rv (of y squared for least squares).

        The weighted loss sum(e_prior e_posterior) over the effective number of samples less the effective
        number of parameters; both reduce to N and n without forgetting. NaN until there are enough samples.
        """
        weight, squared = self.counters[WEIGHT], self.counters[WEIGHT_SQUARED]
        freedom = weight - self.theta.size * squared / weight if weight > 0 else 0.0
        return float(self.counters[LOSS] / freedom) if freedom > 0 else float("nan")

    def covariance(self) -> NDArray[np.float64]:
        """Return the covariance of theta, shape (n, n).

        With forgetting, sigma2 P overstates it: an estimate that weighs samples by lambda^j has the
        covariance sigma2 P (sum lambda^2j phi phi') P, about sigma2 P times the sum of squared weights over
        the sum of weights.
        """
        weight, squared = self.counters[WEIGHT], self.counters[WEIGHT_SQUARED]
        ratio = squared / weight if weight > 0 else 1.0
        return self.covariance_factor() * (self.noise_variance() * ratio)

    def standard_errors(self) -> Vector:
        """Return the standard error of each parameter, shape (n,)."""
        return cast(Vector, np.sqrt(np.diag(self.covariance())))

    def begin_segment(self) -> None:
        """Forget past samples, not the parameters: what comes next is not a neighbour in time."""
        self.memory[:] = 0.0
