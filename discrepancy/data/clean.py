"""Look at a recording before it is believed: time axis, missing values, outliers, excitation."""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import rank_filter

from discrepancy.errors import GapInputError

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

HOLE_STEPS = 3.0
"""A pause longer than this many nominal steps is a hole: the simulation starts anew behind it."""
OUTLIER_DEVIATIONS = 12.0
"""Distance from the running median, in robust standard deviations, at which a sample is no measurement."""
PAIR_FACTOR = 3.0
"""How many times larger a spike must be if one of its neighbours may be a spike as well."""
SPAN_SHARE = 0.5
"""A spike goes there and back: it stands out by more than this part of what its neighbours span. The first sample after
a step from which the signal decays stands out too, by little against the step."""
MOST_SPIKES = 0.02
MOST_MISSING = 0.2
MIN_SAMPLES = 400
"""What naming an effect takes; below it no held-out block is longer than the noise."""
LEAST_TO_SIMULATE = 4


def check_time(time_s: FloatArray, label: str, least: int = MIN_SAMPLES) -> float:
    """Return the nominal step of a time axis.

    Args:
        time_s: s, shape (n,).
        label: what messages call the recording.
        least: samples that the purpose needs.

    Raises:
        GapInputError: too few samples, or time that does not run forwards.
    """
    if time_s.size < least:
        purpose = "to name an effect" if least == MIN_SAMPLES else "to simulate"
        raise GapInputError(
            f"{label}: {time_s.size} samples are too few {purpose}; at least {least} are needed, record longer"
        )
    wrong = np.flatnonzero(~np.isfinite(time_s))
    if wrong.size:
        raise GapInputError(
            f"{label}: time_s is no number at row {wrong[0]} ({time_s[wrong[0]]}), {wrong.size} rows in all; "
            "repair the recording"
        )
    steps = np.diff(time_s)
    _check_steps(time_s, steps, label)
    return float(np.median(steps))


def _check_steps(time_s: FloatArray, steps: FloatArray, label: str) -> None:
    wrong = np.flatnonzero(steps <= 0.0)
    if not wrong.size:
        return
    at, back = int(wrong[0]), np.flatnonzero(steps < 0.0)
    if back.size:
        at = int(back[0])
        why = f"it runs backwards {back.size} times; sort or repair the recording, or cut it there into two"
    else:
        why = f"{wrong.size} rows repeat the time before them; keep one row of each time"
    raise GapInputError(
        f"{label}: time_s does not rise at row {at + 1} ({time_s[at]} then {time_s[at + 1]} s): {why}"
    )


def find_holes(time_s: FloatArray, step: float) -> NDArray[np.int64]:
    """Return the rows that come after a hole."""
    return np.asarray(np.flatnonzero(np.diff(time_s) > HOLE_STEPS * step) + 1, dtype=np.int64)


def find_outliers(values: FloatArray) -> BoolArray:
    """Mark samples that are no measurement: not finite, or single spikes far outside all their neighbours."""
    bad: BoolArray = ~np.isfinite(values)
    filled = np.where(bad, np.median(values[~bad]) if not bad.all() else 0.0, values)
    # Outside the range of four neighbours on both sides: a step of the signal stays inside, a spike does not.
    typical = 1.4826 * float(np.median(np.abs(np.diff(filled))))
    limit = max(OUTLIER_DEVIATIONS * typical, 0.05 * float(np.std(filled)))
    # A spike hides another one near it: large ones may have one such neighbour.
    spikes: BoolArray = _spikes(filled, 1, limit) | _spikes(filled, 2, PAIR_FACTOR * limit)
    # What happens often is not an outlier but the signal (edges of a square wave with ringing).
    return bad | spikes if spikes.mean() < MOST_SPIKES else bad


def _spikes(values: FloatArray, rank: int, limit: float) -> BoolArray:
    """Mark samples outside the range of their neighbours, the `rank - 1` outermost of these left out on both sides."""
    high, low = _high_neighbour(values, rank), -_high_neighbour(-values, rank)
    outside = np.maximum(values - high, low - values)
    return np.asarray(outside > np.maximum(limit, SPAN_SHARE * (high - low)))


def _high_neighbour(values: FloatArray, rank: int) -> FloatArray:
    """Return the largest (2: second largest) of the four neighbours before and the four behind each sample."""
    footprint = np.array([1, 1, 1, 1, 0, 1, 1, 1, 1], dtype=np.bool_)
    return np.asarray(rank_filter(values, rank=-rank, footprint=footprint, mode="nearest"))


def check_share(bad: BoolArray, label: str, name: str) -> None:
    """Refuse a column that is mostly not measured.

    Raises:
        GapInputError: more than a fifth of the samples do not count.
    """
    share = float(bad.mean())
    if share > MOST_MISSING:
        raise GapInputError(
            f"{label}: {share:.0%} of {name} is no measurement (NaN, infinite or spikes), more than the "
            f"{MOST_MISSING:.0%} that can be bridged; repair the sensor or leave the record out"
        )


def repair(time_s: FloatArray, values: FloatArray, bad: BoolArray) -> FloatArray:
    """Replace marked samples by straight lines between their neighbours."""
    if not bad.any() or bad.all():
        return values
    return np.interp(time_s, time_s[~bad], values[~bad])
