"""What the one-step errors of a model still hold: correlation in time, and with the input."""

import math
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np

from estimators.dataset import Vector

_FALSE_ALARM = 0.01
# Two-sided 99 % point of the standard normal distribution.
_BAND_99 = NormalDist().inv_cdf(1 - _FALSE_ALARM / 2)


@dataclass(frozen=True, slots=True, kw_only=True)
class ResidualReport:
    """Correlations of the residual e, with 99 % bands.

    Attributes:
        autocorrelation: of e at lags 1..max_lag; a good model leaves about 1 % outside the band.
        autocorrelation_band: half width of its band.
        ljung_box: portmanteau statistic over all lags.
        ljung_box_p: probability of a larger one if e is white.
        white: whether that probability is at least 1 %.
        cross_correlation: of u(k - lag) and e(k) at lags -max_lag..max_lag; positive lags are dynamics that
            the model lacks, negative ones feedback in the data.
        cross_correlation_band: half width of its band, widened for the correlation of e itself.
        input_explained: whether the lags 0..max_lag all stay in a band that 99 % of such sets do not leave.
    """

    autocorrelation: tuple[float, ...]
    autocorrelation_band: float
    ljung_box: float
    ljung_box_p: float
    white: bool
    cross_correlation: tuple[float, ...]
    cross_correlation_band: float
    input_explained: bool


def analyse_residuals(residual: Vector, u: Vector, bounds: tuple[slice, ...], max_lag: int) -> ResidualReport:
    """Test residuals for whiteness (G. M. Ljung and G. E. P. Box, Biometrika 65 (1978) 297) and against u.

    The band of the cross-correlation follows L. Ljung, System Identification, 2nd ed. 1999, section 16.6:
    variance sum R_e R_u / (R_e(0) R_u(0)) / N.

    Args:
        residual: one-step errors, shape (M,).
        u: input at the same samples, shape (M,).
        bounds: segments; products never reach across them.
        max_lag: largest lag; lowered for short data.
    """
    n = residual.size
    max_lag = max(1, min(max_lag, n // 4))
    e, v = residual - residual.mean(), u - u.mean()
    lags = range(1, max_lag + 1)
    auto = np.array([_correlate(e, e, bounds, lag) for lag in lags])
    input_auto = np.array([_correlate(v, v, bounds, lag) for lag in lags])
    cross = np.array([_correlate(v, e, bounds, lag) for lag in range(-max_lag, max_lag + 1)])
    statistic = float(n * (n + 2) * np.sum(auto**2 / (n - np.arange(1, max_lag + 1))))
    p_value = survive_chi_square(statistic, max_lag)
    spread = max(1.0, 1.0 + 2.0 * float(auto @ input_auto))
    deviation = math.sqrt(spread / n)
    # Bonferroni: holds however correlated the lags are, as they are for a slow input.
    joint_band = NormalDist().inv_cdf(1 - _FALSE_ALARM / 2 / (max_lag + 1)) * deviation
    return ResidualReport(
        autocorrelation=tuple(map(float, auto)),
        autocorrelation_band=_BAND_99 / math.sqrt(n),
        ljung_box=statistic,
        ljung_box_p=p_value,
        white=p_value >= _FALSE_ALARM,
        cross_correlation=tuple(map(float, cross)),
        cross_correlation_band=_BAND_99 * deviation,
        input_explained=bool(np.all(np.abs(cross[max_lag:]) <= joint_band)),
    )


def survive_chi_square(x: float, freedom: int) -> float:
    """Return P(chi^2 > x) for a whole number of degrees of freedom.

    By Q(a + 1, h) = Q(a, h) + h^a exp(-h) / Gamma(a + 1) with h = x / 2, from Q(1/2, h) = erfc(sqrt h) or
    Q(1, h) = exp(-h); all terms are positive, so nothing cancels.
    """
    if not x > 0.0:
        return 1.0 if x <= 0.0 else float("nan")
    half = x / 2.0
    a = 0.5 if freedom % 2 else 1.0
    total = math.erfc(math.sqrt(half)) if freedom % 2 else math.exp(-half)
    while a < freedom / 2.0:
        total += math.exp(a * math.log(half) - half - math.lgamma(a + 1.0))
        a += 1.0
    return min(total, 1.0)


def _correlate(left: Vector, right: Vector, bounds: tuple[slice, ...], lag: int) -> float:
    """Return sum left(k - lag) right(k) over neighbours, relative to the two norms; 0 for a silent series."""
    if lag < 0:
        return _correlate(right, left, bounds, -lag)
    norm = math.sqrt(float(left @ left) * float(right @ right))
    if norm == 0.0:
        return 0.0
    total = 0.0
    for bound in bounds:
        x, y = left[bound], right[bound]
        if y.size > lag:
            total += float(x[: x.size - lag] @ y[lag:])
    return total / norm
