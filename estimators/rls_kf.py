"""RLS-KF: a Kalman filter for parameters that drift as a random walk (paper, eq. 10-17 and Algorithm 1)."""

from dataclasses import dataclass

import numpy as np

from estimators.dataset import Vector
from estimators.recursive import RecursiveEstimator
from estimators.regressors import Regression
from estimators.settings import IdentifyOptions
from estimators.start import NEAR_ZERO, Start, scale_start
from estimators.weights import Weights


@dataclass(frozen=True, slots=True, kw_only=True)
class RlsKfOptions:
    """Options of RLS-KF; the defaults are the paper's (eq. 16 and 17).

    Attributes:
        rw: diagonal of Rw, the variance by which each parameter drifts in one sample: one number or one per
            parameter, in units of the parameter squared.
        rv: variance Rv of the measurement noise, in units of y squared.
        start: theta and P before the first sample.
    """

    rw: float | tuple[float, ...] = 0.99
    rv: float = 0.99
    start: Start = Start()

    def __post_init__(self) -> None:
        """Check ranges.

        Raises:
            ValueError: If a variance is out of range.
        """
        drift = np.atleast_1d(np.asarray(self.rw, dtype=np.float64))
        if not (np.all(np.isfinite(drift)) and np.all(drift >= 0)):
            raise ValueError(f"rw={self.rw} must be zero (no drift, as RLS) or a positive variance")
        if not (np.isfinite(self.rv) and self.rv > 0):
            raise ValueError(f"rv={self.rv} must be a positive variance")

    def drift(self, n: int) -> Vector:
        """Return the diagonal of Rw, shape (n,).

        Raises:
            ValueError: If the number of values does not fit.
        """
        values = np.atleast_1d(np.asarray(self.rw, dtype=np.float64))
        if values.size not in (1, n):
            raise ValueError(f"rw has {values.size} values; give one, or {n}, one per parameter")
        return np.array(np.broadcast_to(values, (n,)))


def make_rls_kf(n_phi: int, options: RlsKfOptions) -> RecursiveEstimator:
    """Return RLS-KF in the standard reading.

        P     = P + Rw                                     (eq. 13 with A = I)
        K     = P phi / (Rv + phi' P phi)                  (eq. 14)
        theta = theta + K (y - phi' theta)
        P     = (I - K phi') P                             (eq. 15)

    This is the ordinary Kalman filter for random-walk parameters; there is no second RLS behind it. Rw = 0
    gives RLS without forgetting. Rw and Rv carry units: the same data in other units are another filter, and
    with the paper's 0.99 the filter forgets within a few samples. Its parameters at the last sample are then
    a snapshot, not a model (docs/estimators.md). `rls_kf_ml` has Rw and Rv estimated from the data. About
    45 ns a sample for 4 parameters.

    Args:
        n_phi: number of regressors.
        options: variances and start.
    """
    return RecursiveEstimator(
        weights=make_weights(n_phi, options, lagged=False),
        theta0=options.start.parameters(n_phi),
        n_phi=n_phi,
        n_memory=0,
    )


def make_weights(n: int, options: RlsKfOptions, *, lagged: bool) -> Weights:
    """Return the kernel's weights for the Kalman form."""
    rw = options.drift(n)
    return Weights(
        lam=1.0,
        rv=float(options.rv),
        rw=rw,
        widen=bool(np.any(rw > 0)),
        directional=False,
        lagged=lagged,
        p0=options.start.diagonal(n),
        trace_limit=float("inf"),
        reset_interval=0,
    )


def choose_options(regression: Regression, options: IdentifyOptions) -> RlsKfOptions:
    """Return the options of both readings of RLS-KF for these data."""
    start = NEAR_ZERO if options.start_near_zero else scale_start(regression)
    return RlsKfOptions(rw=options.rw, rv=options.rv, start=start)


def prepare_rls_kf(regression: Regression, options: IdentifyOptions) -> RecursiveEstimator:
    """Return RLS-KF for these data."""
    return make_rls_kf(regression.structure.n_phi, choose_options(regression, options))
