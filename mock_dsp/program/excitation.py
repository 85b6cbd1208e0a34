"""A RUN command turned into current references, block by block: amplitude, offset, fade and length."""

import numpy as np
from numpy.typing import NDArray

from daq.protocol.codes import Generator, RunFlag, StatusCode
from daq.protocol.commands import Run
from mock_dsp.program.refusal import RefusedError
from mock_dsp.program.shapes import PREPARERS, USED_FIELDS, Shape
from mock_dsp.program.waves import WaveTables

_OPTIONAL_FIELDS = ("period_ticks", "phase", "p1", "p2", "p3", "p4")
_KNOWN_FLAGS = int(RunFlag.CENTRING | RunFlag.REPEAT)  # int: ~ of a flag keeps to its known bits


class Excitation:
    """The reference that one RUN command stands for.

    Args:
        run: the command.
        tables: uploaded tables, for the generator TABLE.
        tick_hz: ticks per second.
        current_limit_a: what the peak must not exceed.

    Raises:
        RefusedError: the command's numbers are not acceptable; holds the status of the reply.
    """

    def __init__(self, run: Run, tables: WaveTables, tick_hz: int, current_limit_a: float) -> None:
        shape = _prepare_shape(run, tables, tick_hz)
        self._amplitude_a = run.amplitude_ua * 1e-6
        self._offset_a = run.offset_ua * 1e-6
        self._ramp_ticks = run.ramp_ticks
        self._values = shape.values
        ends = [ticks for ticks in (run.duration_ticks or None, shape.natural_ticks) if ticks is not None]
        self.length_ticks: int | None = min(ends, default=None)
        self.centring = bool(run.flags & RunFlag.CENTRING)
        peak_a = abs(self._offset_a) + abs(self._amplitude_a) * shape.peak
        if peak_a > current_limit_a:
            raise RefusedError(StatusCode.OUT_OF_RANGE)
        if self.length_ticks is not None and self.length_ticks < 2 * self._ramp_ticks:
            raise RefusedError(StatusCode.OUT_OF_RANGE)

    def reference(self, first: int, count: int) -> NDArray[np.float64]:
        """Return r(k) in A for k = first .. first + count - 1, shape (count,)."""
        k = np.arange(first, first + count, dtype=np.int64)
        return self.fade(first, count) * (self._offset_a + self._amplitude_a * self._values(k))

    def fade(self, first: int, count: int) -> NDArray[np.float64]:
        """Return w(k) in [0, 1] for the same ticks, shape (count,)."""
        fade = np.ones(count)
        ramp, length = self._ramp_ticks, self.length_ticks
        if not ramp:
            return fade
        k = np.arange(first, first + count, dtype=np.int64)
        if first < ramp:
            fade = np.minimum(fade, k / ramp)
        if length is not None and first + count > length - ramp:
            fade = np.minimum(fade, (length - k) / ramp)
        return fade


def _prepare_shape(run: Run, tables: WaveTables, tick_hz: int) -> Shape:
    if run.generator not in tuple(Generator) or run.flags & ~_KNOWN_FLAGS:
        raise RefusedError(StatusCode.OUT_OF_RANGE)
    generator = Generator(run.generator)
    if any(getattr(run, name) for name in _OPTIONAL_FIELDS if name not in USED_FIELDS[generator]):
        raise RefusedError(StatusCode.OUT_OF_RANGE)
    return PREPARERS[generator](run, tables, tick_hz)
