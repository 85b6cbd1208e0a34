"""RLS-KF with Rw and Rv estimated from the data: maximum likelihood of the innovations."""

from dataclasses import dataclass

import numpy as np

from estimators.recursive import RecursiveEstimator
from estimators.regressors import Regression
from estimators.rls_kf import RlsKfOptions, make_rls_kf
from estimators.settings import IdentifyOptions
from estimators.start import scale_start

# Drift per sample, relative to the noise, in units in which every regressor has mean square one. Below the
# first value the parameters drift by less than their standard error over any recording; above the last one
# the filter follows single samples.
_LOG_RATIOS = np.linspace(-14.0, 2.0, 17)
_GOLDEN = (np.sqrt(5.0) - 1.0) / 2.0
_REFINEMENTS = 14


@dataclass(frozen=True, slots=True, kw_only=True)
class NoiseEstimate:
    """Variances that make the innovations most likely.

    Attributes:
        options: RLS-KF options with these variances and a start that knows nothing.
        log_likelihood: of the innovations after the first few, at the optimum.
        log_likelihood_constant: the same with Rw = 0, parameters that do not drift.
    """

    options: RlsKfOptions
    log_likelihood: float
    log_likelihood_constant: float


def estimate_noise(regression: Regression) -> NoiseEstimate:
    """Maximise the likelihood of the innovations over Rw and Rv.

    Innovations of a Kalman filter are independent and normal, so the log likelihood is
    -1/2 sum(log(2 pi s(k)) + e(k)^2 / s(k)) (A. C. Harvey, Forecasting, Structural Time Series Models and the
    Kalman Filter, 1989, section 3.4). Rv is concentrated out: with Rw = q Rv S, s = Rv s0(q) and the best Rv
    is mean(e^2 / s0). S = diag(1 / mean square of each regressor) makes the search free of units. The rest, a
    search over log q, is a grid and golden-section steps around its best point; q = 0 competes as well.
    The first n innovations only reflect the unknown start and are left out of the sum (diffuse likelihood).
    """
    scale = 1.0 / np.maximum(np.mean(regression.phi**2, axis=0), np.finfo(float).tiny)
    constant = _profile(regression, np.zeros_like(scale))
    best = max((_profile(regression, 10.0**log_q * scale)[0], log_q) for log_q in _LOG_RATIOS)[1]
    log_q = _refine(regression, scale, float(best))
    drifting = _profile(regression, 10.0**log_q * scale)
    value, rv = max(constant, drifting)
    ratio = np.zeros_like(scale) if (value, rv) == constant else 10.0**log_q * scale
    start = scale_start(regression)
    p0 = tuple(float(p) * rv for p in start.diagonal(scale.size))
    options = RlsKfOptions(
        rw=tuple(float(r) for r in ratio * rv), rv=rv, start=type(start)(p0=p0, theta0=start.theta0)
    )
    return NoiseEstimate(options=options, log_likelihood=value, log_likelihood_constant=constant[0])


def prepare_rls_kf_ml(regression: Regression, options: IdentifyOptions) -> RecursiveEstimator:
    """Return RLS-KF with variances estimated from these data; `options` has nothing to add."""
    del options
    return make_rls_kf(regression.structure.n_phi, estimate_noise(regression).options)


def _refine(regression: Regression, scale: np.ndarray, best: float) -> float:
    """Return log10 q by golden-section search within one grid step of the best grid point."""
    width = float(_LOG_RATIOS[1] - _LOG_RATIOS[0])
    low, high = best - width, best + width
    left, right = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
    value_left = _profile(regression, 10.0**left * scale)[0]
    value_right = _profile(regression, 10.0**right * scale)[0]
    for _ in range(_REFINEMENTS):
        if value_left > value_right:
            high, right, value_right = right, left, value_left
            left = high - _GOLDEN * (high - low)
            value_left = _profile(regression, 10.0**left * scale)[0]
        else:
            low, left, value_left = left, right, value_right
            right = low + _GOLDEN * (high - low)
            value_right = _profile(regression, 10.0**right * scale)[0]
    return (low + high) / 2.0


def _profile(regression: Regression, ratio: np.ndarray) -> tuple[float, float]:
    """Return the log likelihood at the best Rv, and that Rv, for Rw = ratio * Rv."""
    start = scale_start(regression)
    options = RlsKfOptions(rw=tuple(float(r) for r in ratio), rv=1.0, start=start)
    estimator = make_rls_kf(ratio.size, options)
    state = estimator.init()
    trace = estimator.run(state, regression.phi, regression.y, keep_history=False)
    burn_in = ratio.size
    innovation = (regression.y - trace.prior)[burn_in:]
    variance = trace.variance[burn_in:]
    rv = max(float(np.mean(innovation**2 / variance)), np.finfo(float).tiny)
    log_likelihood = -0.5 * (innovation.size * (np.log(2 * np.pi * rv) + 1.0) + np.sum(np.log(variance)))
    return float(log_likelihood), rv
