"""The reference that a controller will play, sample by sample, from docs/protocol.md, "Generators".

Written from the document, not from the controller's program: where both agree, the document is right. Used to check an
excitation before it is sent, and to compare a recorded reference with what was asked for. Centring is not
included: it depends on the position that the joint will really have.
"""

from collections.abc import Callable
from typing import Final

import numpy as np
from numpy.typing import NDArray

from daq.excitation.spec import PRBS_TAPS, Excitation, Setpoints, Table
from daq.protocol.codes import CURRENT_COUNT_A, ChirpMode, Generator, RunFlag, StaircaseMode
from daq.protocol.commands import Run

Ticks = NDArray[np.int64]
Floats = NDArray[np.float64]
_GRID = 8192


def sample_reference(excitation: Excitation | Setpoints, ticks: Ticks, tick_hz: int) -> Floats:
    """Return the current reference before centring and limits.

    Args:
        excitation: What is played.
        ticks: Ticks since the first tick of the run, shape (n,), ascending.
        tick_hz: Ticks per second.

    Returns:
        Reference in A, shape (n,); zero outside the run.
    """
    k = np.asarray(ticks, dtype=np.int64)
    if isinstance(excitation, Setpoints):
        return _hold(_as_played(excitation.values_a), excitation.hold_ticks(tick_hz), k)
    run = excitation.to_run_command(tick_hz)
    if isinstance(excitation, Table):
        words = _as_played(excitation.values_a)
        shape = words[(np.maximum(k, 0) // run.p2) % words.size]
    else:
        shape = SHAPES[Generator(run.generator)](run, np.maximum(k, 0), tick_hz)
    level: Floats = run.offset_ua * 1e-6 + run.amplitude_ua * 1e-6 * shape
    return level * _fade(k, run.ramp_ticks, run_length(excitation, tick_hz))


def to_words(values_a: tuple[float, ...]) -> NDArray[np.int16]:
    """Return currents as the words of the wire, 2^-13 A each, rounded half up.

    Raises:
        ValueError: A current is not finite or beyond the +-4 A of a word.
    """
    counts = np.floor(np.asarray(values_a, dtype=np.float64) / CURRENT_COUNT_A + 0.5)
    outside = ~((counts >= -32768) & (counts <= 32767))
    if outside.any():
        first = int(np.argmax(outside))
        raise ValueError(
            f"values_a[{first}]={values_a[first]:g} A must lie in [-4, 4) A, the range of a current word"
        )
    return counts.astype(np.int16)


def _as_played(values_a: tuple[float, ...]) -> Floats:
    return to_words(values_a).astype(np.float64) * CURRENT_COUNT_A


def run_length(excitation: Excitation | Setpoints, tick_hz: int) -> int | None:
    """Return the length of the run in ticks, None when it has no end of its own."""
    if isinstance(excitation, Setpoints):
        return len(excitation.values_a) * excitation.hold_ticks(tick_hz)
    run = excitation.to_run_command(tick_hz)
    natural = None if run.flags & RunFlag.REPEAT else _natural_length(excitation, run)
    lengths = [length for length in (run.duration_ticks or None, natural) if length is not None]
    return min(lengths, default=None)


def _natural_length(excitation: Excitation, run: Run) -> int | None:
    if isinstance(excitation, Table):
        return len(excitation.values_a) * run.p2
    if run.generator == Generator.CHIRP:
        return run.period_ticks
    if run.generator == Generator.STAIRCASE:
        return _staircase_steps(run.p1, run.p3) * run.p2
    return None


def _hold(values: Floats, hold_ticks: int, k: Ticks) -> Floats:
    index = k // hold_ticks
    inside = (index >= 0) & (index < values.size)
    return np.where(inside, values[np.clip(index, 0, values.size - 1)], 0.0)


def _fade(k: Ticks, ramp_ticks: int, length: int | None) -> Floats:
    weight = np.where(k >= 0, 1.0, 0.0)
    if length is not None:
        weight[k >= length] = 0.0
    if ramp_ticks:
        weight = np.minimum(weight, k / ramp_ticks)
        if length is not None:
            weight = np.minimum(weight, (length - k) / ramp_ticks)
    return np.maximum(weight, 0.0)


def _turn(run: Run, k: Ticks) -> Floats:
    """Return the position within the period, in [0, 1), from integers so that it never drifts."""
    period = 65536 * run.period_ticks
    return ((65536 * k + run.phase * run.period_ticks) % period) / period


def _sine(run: Run, k: Ticks, tick_hz: int) -> Floats:
    return np.asarray(np.sin(2 * np.pi * _turn(run, k)))


def _trapezoid(run: Run, k: Ticks, tick_hz: int) -> Floats:
    u = _turn(run, k)
    triangle = np.where(u < 0.25, u, np.where(u < 0.75, 0.5 - u, u - 1.0))
    return np.clip(2.0 * triangle * 65536 / run.p1, -1.0, 1.0)


def _chirp(run: Run, k: Ticks, tick_hz: int) -> Floats:
    t, sweep_s = (k % run.period_ticks) / tick_hz, run.period_ticks / tick_hz
    f0, f1 = run.p1 * 1e-6, run.p2 * 1e-6
    if run.p3 == ChirpMode.LINEAR or run.p1 == run.p2:
        turns = f0 * t + (f1 - f0) * t**2 / (2.0 * sweep_s)
    else:
        turns = f0 * sweep_s / np.log(f1 / f0) * ((f1 / f0) ** (t / sweep_s) - 1.0)
    return np.asarray(np.sin(2 * np.pi * (run.phase / 65536 + turns)))


def _prbs(run: Run, k: Ticks, tick_hz: int) -> Floats:
    bit = k // run.p2
    sequence = _prbs_bits(run.p1, run.p3, int(bit.max(initial=0)) + 1)
    return np.where(sequence[bit % sequence.size] > 0, 1.0, -1.0)


def _prbs_bits(length: int, start: int, count: int) -> NDArray[np.int8]:
    mask, tap = (1 << length) - 1, PRBS_TAPS[length]
    state = start & mask
    bits = np.empty(min(count, mask), dtype=np.int8)
    for j in range(bits.size):
        top = state >> (length - 1) & 1
        bits[j] = top
        state = (state << 1 | (top ^ (state >> (tap - 1) & 1))) & mask
    return bits


def _staircase_steps(levels: int, mode: int) -> int:
    """Return the steps of one pass."""
    # Up and down again takes 2 (N - 1) steps, wherever it starts.
    return levels if mode == StaircaseMode.UP else 2 * (levels - 1)


def _staircase(run: Run, k: Ticks, tick_hz: int) -> Floats:
    levels = run.p1
    steps = _staircase_steps(levels, run.p3)
    j = (k // run.p2) % steps
    if run.p3 == StaircaseMode.FROM_ZERO:
        half = (levels - 1) // 2
        return np.where(j <= half, j, np.where(j <= 3 * half, 2 * half - j, j - 4 * half)) / half
    index = np.where(j < levels, j, steps - j)
    return -1.0 + 2.0 * index / (levels - 1)


def _multisine(run: Run, k: Ticks, tick_hz: int) -> Floats:
    harmonics = run.p3 + run.p4 * np.arange(run.p1)
    phases = _random_turns(run.p2, run.p1)
    peak = np.abs(_sum_of_sines(harmonics, phases, np.arange(_GRID) / _GRID)).max()
    wave: Floats = np.clip(_sum_of_sines(harmonics, phases, _turn(run, k)) / peak, -1.0, 1.0)
    return wave


def _random_turns(seed: int, count: int) -> Floats:
    """Return `count` phases in turns from Marsaglia's xorshift32 (13, 17, 5)."""
    x, phases = seed, np.empty(count)
    for i in range(count):
        x ^= x << 13 & 0xFFFFFFFF
        x ^= x >> 17
        x ^= x << 5 & 0xFFFFFFFF
        phases[i] = x / 2**32
    return phases


def _sum_of_sines(harmonics: NDArray[np.int64], phases: Floats, u: Floats) -> Floats:
    total = np.zeros_like(u)
    for harmonic, phase in zip(harmonics, phases, strict=True):
        total += np.sin(2 * np.pi * (harmonic * u + phase))
    return total


SHAPES: Final[dict[Generator, Callable[[Run, Ticks, int], Floats]]] = {
    Generator.SINE: _sine,
    Generator.TRAPEZOID: _trapezoid,
    Generator.CHIRP: _chirp,
    Generator.PRBS: _prbs,
    Generator.STAIRCASE: _staircase,
    Generator.MULTISINE: _multisine,
}
