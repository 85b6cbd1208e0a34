"""Stretches of the training records that were driven by the same input: repeated records, and periods of one record.

Their differences show the noise without any model. Repeats that differ by noise alone are averaged before the search:
half the samples to simulate, and the same information.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from discrepancy.data.series import Series, with_starts

FloatArray = NDArray[np.float64]

REPEAT_TOLERANCE = 0.15
"""Two inputs are repeats if they differ by less than this part of their standard deviation."""
PERIOD_TOLERANCE = 0.05
LEAST_PERIODS = 3
"""The first period holds the transient: noise is read off the later ones."""
MOST_TRAVEL = 0.005
"""Repeats are averaged if their angles differ by at most this part of the travel."""
MOST_UNEVEN = 4.0
"""Repeats are averaged if no stretch differs by more than so many times the median stretch: chance diverges evenly."""
MOST_SAME = 0.5
"""Repeats with noise of their own agree exactly in fewer samples than this part."""
_NEAR = 10
_STRETCHES = 16
_JOINED = " = "


@dataclass(frozen=True, slots=True, kw_only=True)
class Pair:
    """Two stretches of `n` samples with the same input: record `first` from sample `a`, record `second` from `b`."""

    first: int
    second: int
    a: int
    b: int
    n: int

    def difference(self, values: Sequence[FloatArray], factor: int = 1) -> FloatArray:
        """Return what the stretches differ by; `values` holds `factor` samples for each one counted here."""
        one, other = values[self.first], values[self.second]
        a, b, n = self.a * factor, self.b * factor, self.n * factor
        n = min(n, one.size - a, other.size - b)
        return np.asarray(one[a : a + n] - other[b : b + n])


def find_repeats(series: Sequence[Series]) -> list[Pair]:
    """Return pairs of records with the same input, and pairs of periods within a record where no record repeats.

    Repeats that agree to the last digit are none: coarse rounding without noise to dither it errs alike in both.
    """
    pairs = []
    for i, first in enumerate(series):
        for k in range(i + 1, len(series)):
            second = series[k]
            n = min(first.n, second.n)
            if n < 0.9 * max(first.n, second.n):
                continue
            size = float(np.std(first.input))
            far = float(np.std(first.input[:n] - second.input[:n]))
            same_clock = float(np.max(np.abs(first.time_s[:n] - second.time_s[:n]))) < 0.5 * first.step
            if size > 0.0 and far < REPEAT_TOLERANCE * size and same_clock:
                pairs.append(Pair(first=i, second=k, a=0, b=0, n=n))
    found = pairs or [pair for i, one in enumerate(series) for pair in _periods(i, one)]
    return [pair for pair in found if not _rounded_alike(series, pair)]


def _rounded_alike(series: Sequence[Series], pair: Pair) -> bool:
    """Return whether the angle or an output is the same to the last digit in many samples while it moves."""
    signals = [[one.angle for one in series]] if all(one.angle.size for one in series) else []
    signals += [[one.channels[c].values for one in series] for c in range(len(series[0].channels))]
    for values in signals:
        same = pair.difference(values) == 0.0
        own = values[pair.first][pair.a : pair.a + same.size]
        # Coarse steps stand still for a few samples, a joint at rest for many, and a fine signal for none.
        moves = own[2 * _NEAR :] != own[: -2 * _NEAR]
        stands = own[_NEAR:-_NEAR] == own[_NEAR - 1 : -_NEAR - 1]
        if moves.any() and min(np.mean(same[_NEAR:-_NEAR][moves]), np.mean(stands[moves])) > MOST_SAME:
            return True
    return False


def _periods(index: int, one: Series) -> list[Pair]:
    """Return consecutive periods of a record whose input is periodic, without the first period."""
    if len(one.windows) > 1 or one.n < 64:
        return []
    centred = one.input - one.input.mean()
    power = float(centred @ centred)
    if power <= 0.0:
        return []
    size = 1 << (2 * one.n - 1).bit_length()
    correlation = np.fft.irfft(np.abs(np.fft.rfft(centred, size)) ** 2, size)[: one.n // LEAST_PERIODS]
    overlap = 1.0 - np.arange(correlation.size) / one.n
    correlation = correlation / (power * overlap)
    below = np.flatnonzero(correlation < 0.5)
    if below.size == 0:
        return []
    # Differences of squares: 1 - correlation is half the relative mean square of what two periods differ by.
    good = below[0] + np.flatnonzero(1.0 - correlation[below[0] :] < PERIOD_TOLERANCE)
    for period in good[good < one.n // LEAST_PERIODS]:
        far = np.std(one.input[period:] - one.input[:-period])
        if far < PERIOD_TOLERANCE * np.std(one.input):
            starts = range(int(period), one.n - 2 * int(period) + 1, int(period))
            return [Pair(first=index, second=index, a=a, b=a + int(period), n=int(period)) for a in starts]
    return []


def merge_as(series: Sequence[Series], merged: Sequence[Series]) -> tuple[Series, ...]:
    """Return the same records at another rate, averaged in the groups that `merge_repeats` has found."""
    by_label = {one.label: one for one in series}
    groups = [[by_label[name] for name in one.label.split(_JOINED)] for one in merged]
    return tuple(_mean(group) if len(group) > 1 else group[0] for group in groups)


def merge_repeats(series: Sequence[Series], pairs: Sequence[Pair]) -> tuple[Series, ...]:
    """Return the records with repeats averaged where nothing but noise tells them apart.

    A mean of m records carries the weight sqrt(m) on each sample.
    """
    taken: set[int] = set()
    merged = []
    for i, one in enumerate(series):
        if i in taken:
            continue
        partners = [p.second for p in pairs if p.first == i and p.second != i and p.second not in taken]
        group = [k for k in partners if _alike(one, series[k])]
        taken.update(group)
        merged.append(_mean([one, *(series[k] for k in group)]) if group else one)
    return tuple(merged)


def _alike(one: Series, other: Series) -> bool:
    if one.n != other.n or not np.array_equal(one.windows, other.windows):
        return False
    if one.angle.size and other.angle.size:
        apart = float(np.max(np.abs(one.angle - other.angle)))
        if apart > MOST_TRAVEL * max(float(np.ptp(one.angle)), 1e-12):
            return False
    for a, b in zip(one.channels, other.channels, strict=True):
        parts = np.array_split(a.values - b.values, _STRETCHES)
        sizes = np.array([float(np.std(part)) for part in parts])
        if sizes.max() > MOST_UNEVEN * max(float(np.median(sizes)), 1e-300):
            return False
    return True


def _mean(group: Sequence[Series]) -> Series:
    first = group[0]
    channels = []
    for c, channel in enumerate(first.channels):
        squares = np.stack([one.channels[c].weight ** 2 for one in group])
        values = np.stack([one.channels[c].values for one in group])
        total = squares.sum(axis=0)
        mean = np.where(total > 0.0, (values * squares).sum(axis=0) / np.maximum(total, 1e-12), values[0])
        channels.append(replace(channel, values=mean, weight=np.sqrt(total)))
    return with_starts(
        replace(
            first,
            label=_JOINED.join(one.label for one in group),
            input=np.mean([one.input for one in group], axis=0),
            angle=np.mean([one.angle for one in group], axis=0) if first.angle.size else first.angle,
            channels=tuple(channels),
        )
    )
