"""The seven excitations' shapes s(k), as docs/protocol.md, "Generators", defines them.

A shape is prepared once from a RUN command (which checks the numbers that only it uses) and then asked for
consecutive blocks of ticks. Amplitude, offset and fade are not here.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from daq.protocol.codes import CURRENT_COUNT_A, ChirpMode, Generator, RunFlag, StaircaseMode, StatusCode
from daq.protocol.commands import Run
from mock_dsp.program.refusal import RefusedError
from mock_dsp.program.waves import WaveTables

Ticks = NDArray[np.int64]
Values = NDArray[np.float64]

_TURN = 65536
_PEAK_GRID = 8192
_MAX_LINES = 64
_MAX_HARMONIC = 1024
_MAX_LEVELS = 1024
_MAX_RISE = 32768
_FEEDBACK_TAPS = MappingProxyType(
    {5: 3, 6: 5, 7: 6, 9: 5, 10: 7, 11: 9, 15: 14, 17: 14, 18: 11, 20: 17, 23: 18, 31: 28}
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Shape:
    """A prepared generator.

    Attributes:
        values: s(k) for consecutive ticks k since the start; called with one block after the other.
        natural_ticks: length after which the shape ends by itself; None if it goes on.
        peak: greatest magnitude of s.
    """

    values: Callable[[Ticks], Values]
    natural_ticks: int | None = None
    peak: float = 1.0


def _require(condition: bool) -> None:
    if not condition:
        raise RefusedError(StatusCode.OUT_OF_RANGE)


def _period_position(run: Run) -> Callable[[Ticks], Values]:
    """Return u(k) in [0, 1), computed in integers so that it never drifts."""
    whole = _TURN * run.period_ticks
    shift = run.phase * run.period_ticks
    return lambda k: ((_TURN * k + shift) % whole) / whole


def _unless_repeated(run: Run, ticks: int) -> int | None:
    return None if run.flags & RunFlag.REPEAT else ticks


def _prepare_sine(run: Run, tables: WaveTables, tick_hz: int) -> Shape:
    _require(run.period_ticks >= 4)
    position = _period_position(run)
    return Shape(values=lambda k: np.sin(2.0 * np.pi * position(k)))


def _prepare_trapezoid(run: Run, tables: WaveTables, tick_hz: int) -> Shape:
    _require(run.period_ticks >= 4 and 1 <= run.p1 <= _MAX_RISE)
    position = _period_position(run)
    slope = 2.0 * _TURN / run.p1

    def values(k: Ticks) -> Values:
        triangle = 0.25 - np.abs((position(k) + 0.25) % 1.0 - 0.5)
        wave: Values = np.clip(slope * triangle, -1.0, 1.0)
        return wave

    return Shape(values=values)


def _prepare_chirp(run: Run, tables: WaveTables, tick_hz: int) -> Shape:
    highest = tick_hz * 1_000_000 // 4
    _require(run.period_ticks >= 16 and 1 <= run.p1 <= highest and 1 <= run.p2 <= highest)
    _require(run.p3 in tuple(ChirpMode))
    sweep_s = run.period_ticks / tick_hz
    first_hz, last_hz = run.p1 * 1e-6, run.p2 * 1e-6
    linear = run.p3 == ChirpMode.LINEAR or run.p1 == run.p2
    log_ratio = math.log(last_hz / first_hz)

    def values(k: Ticks) -> Values:
        t = (k % run.period_ticks) / tick_hz
        if linear:
            turns = first_hz * t + (last_hz - first_hz) * t * t / (2.0 * sweep_s)
        else:
            turns = first_hz * sweep_s / log_ratio * np.expm1(log_ratio * t / sweep_s)
        wave: Values = np.sin(2.0 * np.pi * (run.phase / _TURN + turns))
        return wave

    return Shape(values=values, natural_ticks=_unless_repeated(run, run.period_ticks))


class _ShiftRegister:
    """Fibonacci shift register that is asked for growing bit numbers."""

    def __init__(self, length: int, state: int) -> None:
        self._mask = (1 << length) - 1
        self._top = length - 1
        self._tap = _FEEDBACK_TAPS[length] - 1
        self._state = state & self._mask
        self._index = 0

    def levels(self, first: int, last: int) -> Values:
        """Return +1 or -1 for the bits `first` to `last`; `first` is not before the last call's `last`."""
        levels = []
        while self._index <= last:
            if self._index >= first:
                levels.append(1.0 if self._state >> self._top & 1 else -1.0)
            if self._index == last:
                break
            fed_back = (self._state >> self._top ^ self._state >> self._tap) & 1
            self._state = (self._state << 1 | fed_back) & self._mask
            self._index += 1
        return np.array(levels)


def _prepare_prbs(run: Run, tables: WaveTables, tick_hz: int) -> Shape:
    _require(run.p1 in _FEEDBACK_TAPS and run.p2 >= 1 and run.p3 & ((1 << run.p1) - 1) != 0)
    register = _ShiftRegister(run.p1, run.p3)

    def values(k: Ticks) -> Values:
        bits = k // run.p2
        levels: Values = register.levels(int(bits[0]), int(bits[-1]))[bits - bits[0]]
        return levels

    return Shape(values=values)


def _staircase_levels(levels: int, mode: int) -> list[float]:
    if mode == StaircaseMode.FROM_ZERO:
        half = (levels - 1) // 2
        rise = [j / half for j in range(half + 1)]
        fall = [(2 * half - j) / half for j in range(half + 1, 3 * half + 1)]
        return rise + fall + [(j - 4 * half) / half for j in range(3 * half + 1, 4 * half)]
    up = [-1.0 + 2.0 * j / (levels - 1) for j in range(levels)]
    return up if mode == StaircaseMode.UP else up + up[-2:0:-1]


def _prepare_staircase(run: Run, tables: WaveTables, tick_hz: int) -> Shape:
    _require(2 <= run.p1 <= _MAX_LEVELS and run.p2 >= 1 and run.p3 in tuple(StaircaseMode))
    _require(run.p3 != StaircaseMode.FROM_ZERO or (run.p1 >= 3 and run.p1 % 2 == 1))
    steps = np.array(_staircase_levels(run.p1, run.p3))
    return Shape(
        values=lambda k: steps[(k // run.p2) % len(steps)],
        natural_ticks=_unless_repeated(run, len(steps) * run.p2),
    )


def _xorshift_phases(seed: int, count: int) -> Values:
    """Return phases in turns from Marsaglia's xorshift32 (shifts 13, 17, 5), one step before each."""
    phases = []
    x = seed
    for _ in range(count):
        x ^= x << 13 & 0xFFFFFFFF
        x ^= x >> 17
        x ^= x << 5 & 0xFFFFFFFF
        phases.append(x / 2.0**32)
    return np.array(phases)


def _prepare_multisine(run: Run, tables: WaveTables, tick_hz: int) -> Shape:
    lines, seed, lowest, step = run.p1, run.p2, run.p3, run.p4
    _require(1 <= lines <= _MAX_LINES and seed != 0 and lowest >= 1 and step >= 1)
    highest = lowest + (lines - 1) * step
    _require(highest <= _MAX_HARMONIC and 4 * highest <= run.period_ticks)
    harmonics = (lowest + step * np.arange(lines, dtype=np.float64))[:, np.newaxis]
    phases = _xorshift_phases(seed, lines)[:, np.newaxis]
    position = _period_position(run)

    def sum_lines(u: Values) -> Values:
        total: Values = np.sin(2.0 * np.pi * (harmonics * u + phases)).sum(axis=0)
        return total

    peak = float(np.abs(sum_lines(np.arange(_PEAK_GRID) / _PEAK_GRID)).max())
    return Shape(values=lambda k: np.clip(sum_lines(position(k)) / peak, -1.0, 1.0))


def _prepare_table(run: Run, tables: WaveTables, tick_hz: int) -> Shape:
    _require(run.p2 >= 1)
    words = tables.words(run.p1)
    if words is None:
        raise RefusedError(StatusCode.NO_DATA)
    values: Values = words * np.float64(CURRENT_COUNT_A)
    return Shape(
        values=lambda k: values[(k // run.p2) % len(values)],
        natural_ticks=_unless_repeated(run, len(values) * run.p2),
        peak=float(np.abs(values).max()),
    )


PREPARERS: MappingProxyType[Generator, Callable[[Run, WaveTables, int], Shape]] = MappingProxyType(
    {
        Generator.SINE: _prepare_sine,
        Generator.TRAPEZOID: _prepare_trapezoid,
        Generator.CHIRP: _prepare_chirp,
        Generator.PRBS: _prepare_prbs,
        Generator.STAIRCASE: _prepare_staircase,
        Generator.MULTISINE: _prepare_multisine,
        Generator.TABLE: _prepare_table,
    }
)

USED_FIELDS: MappingProxyType[Generator, frozenset[str]] = MappingProxyType(
    {
        Generator.SINE: frozenset({"period_ticks", "phase"}),
        Generator.TRAPEZOID: frozenset({"period_ticks", "phase", "p1"}),
        Generator.CHIRP: frozenset({"period_ticks", "phase", "p1", "p2", "p3"}),
        Generator.PRBS: frozenset({"p1", "p2", "p3"}),
        Generator.STAIRCASE: frozenset({"p1", "p2", "p3"}),
        Generator.MULTISINE: frozenset({"period_ticks", "phase", "p1", "p2", "p3", "p4"}),
        Generator.TABLE: frozenset({"p1", "p2"}),
    }
)
"""Fields that a generator reads besides those that all share; the others must be 0."""
