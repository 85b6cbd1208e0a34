"""Principal logarithm of a small real matrix, by inverse scaling and squaring.

scipy has one; its first call costs 50 ms of imports, a twentieth of the time to a first estimate.
"""

import numpy as np
from numpy.typing import NDArray

Matrix = NDArray[np.float64]

_CLOSE_TO_ONE = 0.25
_MAX_ROOTS = 60
_MAX_NEWTON_STEPS = 60
_ROUND_TRIP_TOLERANCE = 1e-8
# Gauss-Legendre points on [0, 1]: with 8 of them the [8/8] Pade approximant of log(1 + x), good to rounding
# for |x| < 0.25.
_POINTS, _WEIGHTS = (array / 2.0 for array in np.polynomial.legendre.leggauss(8))


def take_logarithm(matrix: Matrix) -> Matrix | None:
    """Return the principal logarithm, or None where it cannot be computed to eight digits.

    Square roots are taken until the matrix is close to one, whose logarithm is a sum of resolvents; each root
    doubles the result. N. J. Higham, Functions of Matrices, 2008, sections 6.3 (product form of the
    Denman-Beavers iteration) and 11.4 to 11.5. Unlike a diagonalisation it needs no distinct eigenvalues.

    Args:
        matrix: real, square, without eigenvalues at zero or on the negative real axis.
    """
    one = np.eye(matrix.shape[0])
    root, doublings = matrix, 0
    try:
        with np.errstate(all="ignore"):
            while np.linalg.norm(root - one, 1) > _CLOSE_TO_ONE and doublings < _MAX_ROOTS:
                root, doublings = _take_square_root(root), doublings + 1
            rest = root - one
            resolvents = [
                w * np.linalg.solve(one + (0.5 + x) * rest, rest)
                for x, w in zip(_POINTS, _WEIGHTS, strict=True)
            ]
    except np.linalg.LinAlgError:
        return None
    logarithm = np.asarray(2.0**doublings * sum(resolvents), dtype=np.float64)
    if not np.all(np.isfinite(logarithm)):
        return None
    missed = np.linalg.norm(raise_exponential(logarithm) - matrix, 1) / np.linalg.norm(matrix, 1)
    return logarithm if missed < _ROUND_TRIP_TOLERANCE else None


def raise_exponential(matrix: Matrix) -> Matrix:
    """Return the exponential by scaling, a Taylor series and squaring; for checking a logarithm."""
    halvings = max(0, int(np.ceil(np.log2(max(float(np.linalg.norm(matrix, 1)), 1e-300)))) + 2)
    small = matrix / 2.0**halvings
    term = total = np.eye(matrix.shape[0])
    for k in range(1, 16):
        term = term @ small / k
        total = total + term
    return np.asarray(np.linalg.matrix_power(total, 2**halvings), dtype=np.float64)


def _take_square_root(matrix: Matrix) -> Matrix:
    one = np.eye(matrix.shape[0])
    root, ratio = matrix, matrix
    for _ in range(_MAX_NEWTON_STEPS):
        inverse = np.linalg.inv(ratio)
        root = 0.5 * root @ (one + inverse)
        ratio = 0.5 * (one + 0.5 * (ratio + inverse))
        if np.linalg.norm(ratio - one, 1) < 1e-15 * matrix.shape[0]:
            break
    return np.asarray(root, dtype=np.float64)
