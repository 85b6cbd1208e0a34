"""Where a recursive estimator begins: parameters and covariance before the first sample."""

from dataclasses import dataclass

import numpy as np

from estimators.dataset import Vector
from estimators.regressors import Regression

LARGE_START = 1e8


@dataclass(frozen=True, slots=True, kw_only=True)
class Start:
    """Start values of a recursion.

    Attributes:
        p0: diagonal of P, one number or one per parameter, in units of 1 / regressor squared. Large means
            that nothing is known; the estimate then differs from batch least squares by about
            theta / (p0 * smallest eigenvalue of Phi' Phi).
        theta0: parameters, one number for all or one per parameter.
    """

    p0: float | tuple[float, ...] = 1e6
    theta0: float | tuple[float, ...] = 0.0

    def diagonal(self, n: int) -> Vector:
        """Return the diagonal of P, shape (n,).

        Raises:
            ValueError: If p0 is not positive or has the wrong length.
        """
        values = _spread("p0", self.p0, n)
        if not np.all(values > 0):
            raise ValueError(
                f"p0={self.p0} must be positive; use 1e6 when nothing is known of the parameters"
            )
        return values

    def parameters(self, n: int) -> Vector:
        """Return theta at the start, shape (n,)."""
        return _spread("theta0", self.theta0, n)


# "Initialised with values close to zero" (paper, sections III-A and IV); see docs/estimators.md.
NEAR_ZERO = Start(p0=1e-3, theta0=1e-3)


def scale_start(regression: Regression) -> Start:
    """Return a start that knows nothing in any units: p0 = LARGE_START / mean square of each regressor.

    The residual terms of extended RLS are of the size of the output's one-step changes.
    """
    power = np.mean(regression.phi**2, axis=0)
    n_residuals = regression.structure.nc
    if n_residuals:
        steps = np.mean(np.diff(regression.y) ** 2) if regression.y.size > 1 else power[0]
        power = np.concatenate([power, np.full(n_residuals, steps)])
    # A regressor that never moves says nothing; any finite start will do for it.
    power = np.where(power > 0, power, 1.0)
    return Start(p0=tuple(float(value) for value in LARGE_START / power))


def _spread(name: str, value: float | tuple[float, ...], n: int) -> Vector:
    values = np.atleast_1d(np.asarray(value, dtype=np.float64))
    if values.shape not in ((1,), (n,)) or not np.all(np.isfinite(values)):
        raise ValueError(f"{name}={value} must be one finite number or {n} of them, one per parameter")
    return np.array(np.broadcast_to(values, (n,)))
