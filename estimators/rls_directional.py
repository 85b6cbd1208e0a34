"""Recursive least squares that forgets only where new information comes in (directional forgetting)."""

from dataclasses import dataclass

import numpy as np

from estimators.recursive import RecursiveEstimator
from estimators.regressors import Regression
from estimators.rls import WINDUP_FACTOR
from estimators.settings import IdentifyOptions
from estimators.start import NEAR_ZERO, Start, scale_start
from estimators.weights import Weights


@dataclass(frozen=True, slots=True, kw_only=True)
class RlsDirectionalOptions:
    """Options of directional forgetting.

    Attributes:
        forgetting: lambda in (0, 1).
        start: theta and P before the first sample.
    """

    forgetting: float = 0.98
    start: Start = Start()

    def __post_init__(self) -> None:
        """Check ranges.

        Raises:
            ValueError: If a value is out of range.
        """
        if not 0.0 < self.forgetting < 1.0:
            raise ValueError(
                f"directional forgetting={self.forgetting} must lie in (0, 1); for no forgetting use rls"
            )


def make_rls_directional(n_phi: int, options: RlsDirectionalOptions) -> RecursiveEstimator:
    """Return least squares with directional forgetting.

        r     = phi' P phi
        theta = theta + P phi (y - phi' theta) / (1 + r)
        beta  = lambda - (1 - lambda) / r        (1 if r = 0)
        P     = P - P phi phi' P / (1 / beta + r)

    that is, the information matrix gains beta phi phi': it loses a share 1 - lambda, but only along phi.
    Directions that are not excited are not forgotten, so P does not wind up when the input is silent.
    R. Kulhavy, Restricted exponential forgetting in real-time identification, Automatica 23 (1987) 589-600;
    S. Bittanti, P. Bolzern, M. Campi, Automatica 26 (1990) 801-808. Cost as RLS.

    Its standard errors take the weights of exponential forgetting and are a guide only.

    Args:
        n_phi: number of regressors.
        options: forgetting and start.
    """
    p0 = options.start.diagonal(n_phi)
    weights = Weights(
        lam=float(options.forgetting),
        rv=1.0,
        rw=np.zeros(n_phi),
        widen=False,
        directional=True,
        lagged=False,
        p0=p0,
        trace_limit=float(WINDUP_FACTOR * p0.sum()),
        reset_interval=0,
    )
    return RecursiveEstimator(
        weights=weights, theta0=options.start.parameters(n_phi), n_phi=n_phi, n_memory=0
    )


def prepare_rls_directional(regression: Regression, options: IdentifyOptions) -> RecursiveEstimator:
    """Return directional RLS for these data."""
    start = NEAR_ZERO if options.start_near_zero else scale_start(regression)
    chosen = RlsDirectionalOptions(forgetting=options.directional_forgetting, start=start)
    return make_rls_directional(regression.structure.n_phi, chosen)
