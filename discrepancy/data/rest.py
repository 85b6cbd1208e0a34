"""Is anything happening in this signal, or is it noise around a constant?"""

import numpy as np
from numpy.typing import NDArray

from discrepancy.errors import GapInputError

NEARLY_CONSTANT = 0.05
"""A current that is white noise of less than this part of its mean was meant to be constant."""


def check_moving(values: NDArray[np.float64], label: str, name: str) -> None:
    """Refuse a speed or position that never leaves its noise.

    Raises:
        GapInputError: the joint stands still.
    """
    if float(np.std(values)) <= 0.0 or is_white(values):
        raise GapInputError(
            f"{label}: {name} does not change: the motor is at rest. Record with a current that moves the joint"
        )


def check_varying(values: NDArray[np.float64], label: str, name: str) -> None:
    """Refuse an input that is constant, exactly or but for its noise.

    Raises:
        GapInputError: nothing excites the joint.
    """
    size, mean = float(np.std(values)), float(np.mean(values))
    exactly = size <= 1e-6 * max(1e-12, float(np.max(np.abs(values))))
    if exactly or (size < NEARLY_CONSTANT * abs(mean) and is_white(values)):
        noise = "" if exactly else f" with noise of {size:.2g}"
        raise GapInputError(
            f"{label}: {name} is constant ({mean:.4g}{noise}); nothing excites the joint. Record with a varying current"
        )


def is_white(values: NDArray[np.float64]) -> bool:
    """Whether a signal holds nothing but white noise: no part of it persists from one sample to the next few."""
    centred = values - values.mean()
    power = float(centred @ centred)
    if power <= 0.0:
        return True
    lags = [float(centred[k:] @ centred[:-k]) / power for k in (1, 2, 3, 5)]
    return bool(max(lags) < 5.0 / np.sqrt(values.size) + 0.02)
