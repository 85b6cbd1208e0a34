"""Recursive least squares with exponential forgetting and covariance reset (paper, eq. 2-4)."""

from dataclasses import dataclass

import numpy as np

from estimators.recursive import RecursiveEstimator
from estimators.regressors import Regression
from estimators.settings import IdentifyOptions
from estimators.start import NEAR_ZERO, Start, scale_start
from estimators.weights import Weights

# Without excitation forgetting lets P grow without bound; it pauses where P is this many times the first.
WINDUP_FACTOR = 1e3


@dataclass(frozen=True, slots=True, kw_only=True)
class RlsOptions:
    """Options of RLS and of extended RLS.

    Attributes:
        forgetting: lambda in (0, 1]; a sample that is 1 / (1 - lambda) old weighs 37 %.
        reset_interval: samples after which P returns to its start value, again and again; 0 for never.
        start: theta and P before the first sample.
    """

    forgetting: float = 1.0
    reset_interval: int = 0
    start: Start = Start()

    def __post_init__(self) -> None:
        """Check ranges.

        Raises:
            ValueError: If a value is out of range.
        """
        if not 0.0 < self.forgetting <= 1.0:
            raise ValueError(f"forgetting={self.forgetting} must lie in (0, 1]; use 1.0 for none")
        if self.reset_interval < 0:
            raise ValueError(f"reset_interval={self.reset_interval} must be 0 (never) or a number of samples")


def make_rls(n_phi: int, options: RlsOptions) -> RecursiveEstimator:
    """Return recursive least squares.

        L     = P phi / (lambda + phi' P phi)                      (eq. 3)
        theta = theta + L (y - phi' theta)                         (eq. 2)
        P     = (P - P phi phi' P / (lambda + phi' P phi)) / lambda    (eq. 4)

    computed on the factors of P = U diag(D) U' (Bierman 1977), about 20 ns a sample for 4 parameters.
    After N samples it minimises sum lambda^(N-k) (y(k) - phi(k)' theta)^2 plus the start's pull.

    Do not use it for a model that is to be simulated when the output is noisy: least squares is then biased
    (use `iv`). Do not forget without excitation: forgetting pauses at WINDUP_FACTOR times the first trace of
    P, which keeps the numbers finite, not the estimates good (use `rls_directional`).

    Args:
        n_phi: number of regressors.
        options: forgetting, reset and start.
    """
    p0 = options.start.diagonal(n_phi)
    weights = Weights(
        lam=float(options.forgetting),
        rv=1.0,
        rw=np.zeros(n_phi),
        widen=False,
        directional=False,
        lagged=False,
        p0=p0,
        trace_limit=float(WINDUP_FACTOR * p0.sum()),
        reset_interval=int(options.reset_interval),
    )
    return RecursiveEstimator(
        weights=weights, theta0=options.start.parameters(n_phi), n_phi=n_phi, n_memory=0
    )


def choose_options(regression: Regression, options: IdentifyOptions) -> RlsOptions:
    """Return the options of RLS and extended RLS for these data."""
    start = NEAR_ZERO if options.start_near_zero else scale_start(regression)
    return RlsOptions(forgetting=options.forgetting, reset_interval=options.reset_interval, start=start)


def prepare_rls(regression: Regression, options: IdentifyOptions) -> RecursiveEstimator:
    """Return RLS for these data."""
    return make_rls(regression.structure.n_phi, choose_options(regression, options))
