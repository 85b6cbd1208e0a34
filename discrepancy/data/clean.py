"""Look at a recording before it is believed: time axis, missing values, outliers, excitation."""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter

from discrepancy.errors import GapInputError

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

HOLE_STEPS = 3.0
"""A pause longer than this many nominal steps is a hole: the simulation starts anew behind it."""
OUTLIER_DEVIATIONS = 12.0
"""Distance from the running median, in robust standard deviations, at which a sample is no measurement."""
MIN_SAMPLES = 400


def check_time(time_s: FloatArray, label: str) -> float:
    """Return the nominal step of a time axis.

    Raises:
        GapInputError: too few samples, or time that does not run forwards.
    """
    if time_s.size < MIN_SAMPLES:
        raise GapInputError(
            f"{label}: {time_s.size} samples are too few to name an effect; at least {MIN_SAMPLES} are needed, "
            f"record longer"
        )
    steps = np.diff(time_s)
    if not np.all(np.isfinite(time_s)) or np.any(steps <= 0.0):
        at = int(np.argmax(~(steps > 0.0)))
        raise GapInputError(
            f"{label}: time_s does not rise at row {at + 1} ({time_s[at]} then {time_s[at + 1]} s); sort or "
            f"repair the recording"
        )
    return float(np.median(steps))


def find_holes(time_s: FloatArray, step: float) -> NDArray[np.int64]:
    """Return the rows that come after a hole."""
    return np.asarray(np.flatnonzero(np.diff(time_s) > HOLE_STEPS * step) + 1, dtype=np.int64)


def find_outliers(values: FloatArray) -> BoolArray:
    """Mark samples that are no measurement: not finite, or single spikes far outside all their neighbours."""
    bad: BoolArray = ~np.isfinite(values)
    filled = np.where(bad, np.nanmedian(values) if not bad.all() else 0.0, values)
    # Outside the range of four neighbours on both sides: a step of the signal stays inside, a spike does not.
    above = filled - _highest_neighbour(filled)
    below = -_highest_neighbour(-filled) - filled
    outside = np.maximum(0.0, np.maximum(above, below))
    typical = 1.4826 * float(np.median(np.abs(np.diff(filled))))
    limit = max(OUTLIER_DEVIATIONS * typical, 0.05 * float(np.std(filled)))
    spikes: BoolArray = outside > limit
    # What happens often is not an outlier but the signal (edges of a square wave with ringing).
    return bad | spikes if spikes.mean() < 0.02 else bad


def _highest_neighbour(values: FloatArray) -> FloatArray:
    """Return the largest of the four neighbours before and the four behind each sample."""
    footprint = np.array([1, 1, 1, 1, 0, 1, 1, 1, 1], dtype=np.bool_)
    return np.asarray(maximum_filter(values, footprint=footprint, mode="nearest"))


def repair(time_s: FloatArray, values: FloatArray, bad: BoolArray) -> FloatArray:
    """Replace marked samples by straight lines between their neighbours."""
    if not bad.any() or bad.all():
        return values
    return np.interp(time_s, time_s[~bad], values[~bad])
