"""The weights that make one recursion RLS, extended RLS or RLS-KF, in the order in which the kernel takes them."""

from typing import NamedTuple

from estimators.dataset import Vector


class Weights(NamedTuple):
    """Weights of the recursion of `estimators.kernels.recursion`; constant during a run.

    lam: forgetting factor lambda, in (0, 1].
    rv: variance of the measurement noise; 1 turns the filter into least squares.
    rw: variance added to each parameter every sample, shape (n,).
    widen: whether any rw is positive.
    directional: forget only along the regressor.
    lagged: predict with the regressor of the previous sample (literal Algorithm 1).
    p0: start value of the diagonal of P, shape (n,), also used by a covariance reset.
    trace_limit: forgetting pauses while the trace of P is above it.
    reset_interval: samples between covariance resets; 0 for never.
    """

    lam: float
    rv: float
    rw: Vector
    widen: bool
    directional: bool
    lagged: bool
    p0: Vector
    trace_limit: float
    reset_interval: int
