"""The ends of a record of speed: a derivative that was smoothed without delay is wrong there.

At its first and at its last sample a smoother knows one side only. What it takes the other side to be (position or
speed turned about the end, a constant, nothing) differs between pipelines, and where the joint accelerates, the speed
is off by many times the noise over a few time constants of the smoother. No model of the joint can follow that, but an
end stop that is touched once can be bent to it.
"""

from dataclasses import replace

import numpy as np

from discrepancy.data.series import SPEED, Series, with_starts

END_S = 0.1
"""Five time constants of a smoother with its corner at 8 Hz."""
LARGEST_PART = 1.0 / 50.0
"""Of a short stretch no more than this part is an end."""
ENDS_LEFT_OUT = (
    f"the first and the last {END_S:g} s of each record (less of a short one) were left out: the speed is wrong there, "
    "as a smoothed speed is that knows one side only, and with them the answer would have rested on it"
)


def end_samples(series: Series) -> int:
    """Return how many samples at either end of a record a smoothed speed may be wrong in; 0 without a speed."""
    if not any(one.row == SPEED for one in series.channels):
        return 0
    shorter = min(b - a for a, b in (series.edges[0], series.edges[-1]))
    return round(min(END_S / series.step, LARGEST_PART * shorter))


def without_ends(series: Series) -> Series:
    """Return a record of speed without its first and last moments; any other record as it is."""
    few = end_samples(series)
    if few == 0:
        return series
    kept = slice(few, series.n - few)
    windows = np.where(series.windows >= 0, series.windows - few, series.windows + few)
    windows[0] = -1
    return with_starts(
        replace(
            series,
            time_s=series.time_s[kept] - series.time_s[few],
            input=series.input[kept],
            angle=series.angle[kept],
            channels=tuple(
                replace(one, values=one.values[kept], weight=one.weight[kept]) for one in series.channels
            ),
            windows=windows,
        )
    )
