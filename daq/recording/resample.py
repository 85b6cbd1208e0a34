"""Decimation by a whole factor, without phase and without aliases.

The anti-alias filter is a linear-phase FIR (Kaiser window) evaluated only at the samples that are kept,
centred on each, so that it delays nothing. Its pass band reaches to 0.7 of the new Nyquist frequency (ripple
below 0.01 dB) and its stop band begins *at* the new Nyquist frequency with at least 60 dB, so what folds back
is below a thousandth at every frequency. Input and output of a system must go through the same filter: then
the relation between them is that of the system, whatever the filter does near its edge.

At both ends the data are continued by turning them about the end point, which is taken from a line fitted to
half a new sample time: turning about the last sample itself would move the end by twice that sample's noise.
On white noise the first value is then three times as noisy as the rest, on a 5 s sine decimated to 0.2 s it
is wrong by 0.1 %.
"""

import math
from collections.abc import Iterable
from dataclasses import replace
from functools import lru_cache
from typing import Final

import numpy as np
import numpy.typing as npt

from daq.recording.recording import TIME, FloatArray, Recording, recording_from_columns

PASS_BAND: Final = 0.7  # of the new Nyquist frequency
STOP_BAND_DB: Final = 70.0  # asked of the window's formula, good to a few dB; 60 dB are tested

_PIECE: Final = 512  # output samples computed at a time: small enough for BLAS not to start threads


@lru_cache(maxsize=16)
def design_antialias(factor: int) -> FloatArray:
    """Return the anti-alias filter for a decimation: odd length, symmetric, gain 1 at frequency 0.

    Length and window follow Kaiser's formulas (Oppenheim and Schafer, Discrete-Time Signal Processing,
    7.5.3).

    Raises:
        ValueError: the factor is not a whole number of at least 1.
    """
    if factor < 1:
        raise ValueError(f"decimation factor {factor} must be at least 1")
    if factor == 1:
        return np.ones(1)
    transition = math.pi / factor * (1.0 - PASS_BAND)
    half = math.ceil((STOP_BAND_DB - 7.95) / (2.285 * transition) / 2.0)
    cutoff = (1.0 + PASS_BAND) / 2.0 / factor
    beta = 0.1102 * (STOP_BAND_DB - 8.7)
    taps: FloatArray = np.sinc(cutoff * np.arange(-half, half + 1)) * np.kaiser(2 * half + 1, beta)
    taps /= taps.sum()
    taps.flags.writeable = False
    return taps


def decimate(values: FloatArray, factor: int) -> FloatArray:
    """Keep every factor-th sample of a gap-free signal, low-pass filtered without delay.

    Args:
        values: uniform samples, shape (n,).
        factor: how many samples become one.

    Returns:
        Filtered values at samples 0, factor, 2*factor, ..., shape (ceil(n/factor),).
    """
    taps = design_antialias(factor)
    extended = extend_ends(values, len(taps) // 2, fitted=max(1, factor // 2))
    kept, phases = math.ceil(len(values) / factor), math.ceil(len(taps) / factor)
    # Rows of `factor` samples times columns of as many taps, then sums over the anti-diagonals, in pieces
    # that fit the cache: as fast as scipy.signal.upfirdn, whose import takes longer than an estimate may.
    rows = np.zeros((kept + phases - 1, factor))
    count = min(rows.size, len(extended))
    rows.reshape(-1)[:count] = extended[:count]
    columns = np.zeros((phases, factor))
    columns.reshape(-1)[: len(taps)] = taps
    total = np.zeros(kept)
    for start in range(0, kept, _PIECE):
        piece = total[start : start + _PIECE]
        products = columns @ rows[start : start + len(piece) + phases - 1].T
        for phase in range(phases):
            piece += products[phase, phase : phase + len(piece)]
    return total


def extend_ends(values: FloatArray, count: int, fitted: int) -> FloatArray:
    """Continue a signal by `count` samples at both ends, turned by half a turn about its fitted end points.

    Args:
        values: shape (n,).
        count: samples to add at each end.
        fitted: samples over which a least-squares line gives the end point.

    Returns:
        The longer signal, shape (n + 2 count,).
    """
    extended = np.pad(values, count, mode="reflect", reflect_type="odd")
    extended[:count] += 2.0 * (_fitted_end(values[:fitted]) - values[0])
    extended[count + len(values) :] += 2.0 * (_fitted_end(values[::-1][:fitted]) - values[-1])
    return extended


def _fitted_end(values: FloatArray) -> float:
    """Return the value at the first sample of a least-squares line through all of them."""
    centred = np.arange(len(values)) - (len(values) - 1) / 2.0
    spread = float(centred @ centred)
    slope = float(centred @ values) / spread if spread > 0.0 else 0.0
    return float(values.mean()) + slope * float(centred[0])


def decimate_recording(recording: Recording, factor: int, columns: Iterable[str] | None = None) -> Recording:
    """Decimate every column of a recording, each run without holes by itself.

    Each run starts on its own first sample, so holes stay where they were; runs shorter than the new sample
    time give one sample.

    Args:
        recording: a uniform time base (see `daq.recording.timebase`) with or without holes.
        factor: how many samples become one.
        columns: columns to keep, all by default; `time_s` is always kept.

    Returns:
        A recording in memory; its metadata say what was done.
    """
    names = [name for name in (columns or recording.columns) if name != TIME]
    segments = recording.segments()
    decimated = {
        name: np.concatenate([decimate(recording.column(name)[run], factor) for run in segments])
        for name in names
    }
    decimated[TIME] = np.concatenate([recording.time_s[run][::factor] for run in segments])
    starts = np.cumsum([0, *(math.ceil((run.stop - run.start) / factor) for run in segments[:-1])])
    new_row = {run.start: int(start) for run, start in zip(segments, starts, strict=True)}
    new_row[recording.n] = len(decimated[TIME])
    gaps = tuple(
        replace(span, row=new_row[span.row], missing_samples=round(span.missing_samples / factor))
        for span in recording.gaps
    )
    return recording_from_columns(
        decimated,
        sample_time_s=recording.sample_time_s * factor,
        gaps=gaps,
        units=recording.units,
        metadata={**recording.metadata, "decimation": describe_decimation(factor, recording.sample_time_s)},
    )


def describe_decimation(factor: int, sample_time_s: float) -> dict[str, float | int | str]:
    """State the filter of a decimation for a recording's metadata."""
    nyquist_hz = 0.5 / (factor * sample_time_s)
    return {
        "factor": factor,
        "filter": "zero-phase FIR, Kaiser window",
        "taps": len(design_antialias(factor)),
        "pass_band_hz": PASS_BAND * nyquist_hz,
        "stop_band_hz": nyquist_hz,
        "stop_band_db": 60.0,
    }


def frequency_response(taps: npt.ArrayLike, frequency: npt.ArrayLike) -> FloatArray:
    """Return the real, zero-phase response of symmetric taps at frequencies in cycles per sample."""
    coefficients = np.asarray(taps, dtype=np.float64)
    lag = np.arange(len(coefficients)) - len(coefficients) // 2
    response: FloatArray = np.cos(2.0 * np.pi * np.outer(np.atleast_1d(frequency), lag)) @ coefficients
    return response
