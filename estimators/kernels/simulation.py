"""Compiled simulation of a linear difference equation; also used as an all-pole filter."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

Vector = NDArray[np.float64]


@njit(cache=True, error_model="numpy", fastmath={"contract"})
def simulate_difference_equation(
    a: Vector, b: Vector, delay: int, u: Vector, first: int, out: Vector
) -> None:
    """Fill out[first:] with out(k) = -a_1 out(k-1) - ... + b_0 u(k-delay) + b_1 u(k-delay-1) + ...

    Terms before the first sample count as zero. With b = [1] and delay = 0 this filters u by 1/A.

    Args:
        a: coefficients a_1..a_na, shape (na,).
        b: coefficients b_0..b_(nb-1), shape (nb,).
        delay: samples between u and its first effect, >= 0.
        u: input, shape (N,).
        first: samples at the start of `out` that are given (initial conditions).
        out: output, shape (N,); its first `first` values are read, the others written.
    """
    for k in range(first, u.shape[0]):
        total = 0.0
        for i in range(min(a.shape[0], k)):
            total -= a[i] * out[k - 1 - i]
        for j in range(min(b.shape[0], k - delay + 1)):
            total += b[j] * u[k - delay - j]
        out[k] = total
