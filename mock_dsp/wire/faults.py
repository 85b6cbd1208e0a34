"""Seeded damage to the octets on their way to the host, and the schedule of everything that happens once.

Which fault takes which numbers stands in `mock_dsp.scenario.faults`; device time is counted in ticks since
power-on, restarts of the program included.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from mock_dsp.scenario.faults import FaultName
from mock_dsp.scenario.schema import Fault

Damage = Callable[[bytearray, int, int, int], None]
"""Damages octets at an index; the other two numbers are a random 32-bit one and the fault's size."""


def _flip_bit(octets: bytearray, at: int, draw: int, size: int) -> None:
    octets[at] ^= 1 << draw % 8


def _drop_octet(octets: bytearray, at: int, draw: int, size: int) -> None:
    del octets[at]


def _duplicate_octet(octets: bytearray, at: int, draw: int, size: int) -> None:
    octets.insert(at, octets[at])


def _overwrite_run(octets: bytearray, at: int, draw: int, size: int) -> None:
    end = min(at + size, len(octets))
    octets[at:end] = np.random.default_rng(draw).bytes(end - at)


DAMAGES: Mapping[FaultName, Damage] = {
    FaultName.BIT_FLIPS: _flip_bit,
    FaultName.DROPPED_BYTES: _drop_octet,
    FaultName.DUPLICATED_BYTES: _duplicate_octet,
    FaultName.BURSTS: _overwrite_run,
}
"""What each fault on the wire does at the octet it strikes."""

TIMED = frozenset({FaultName.STALL, FaultName.DISCONNECT, FaultName.REBOOT, FaultName.TICK_JUMP})
"""Faults that happen once, at a time."""


class OctetDamage:
    """One fault on the wire: strikes octets at random, the same ones for the same seed.

    Args:
        fault: its rate, size, time and seed.
        tick_hz: ticks per second.
    """

    def __init__(self, fault: Fault, tick_hz: int) -> None:
        self._damage = DAMAGES[fault.name]
        self._rate = fault.rate or 0.0
        self._size = round(fault.magnitude or 1.0)
        self._first_tick = round((fault.at_s or 0.0) * tick_hz)
        self._end_tick = math.inf
        if fault.duration_s is not None:
            self._end_tick = self._first_tick + round(fault.duration_s * tick_hz)
        self._rng = np.random.default_rng(fault.seed)
        self._spare = self._draw_gap()

    def apply(self, octets: bytearray, tick: int) -> None:
        """Damage the octets that leave at `tick`, in place."""
        if not self._rate or not self._first_tick <= tick < self._end_tick:
            return
        struck = []
        position = self._spare
        while position < len(octets):
            struck.append((position, int(self._rng.integers(2**32))))
            position += 1 + self._draw_gap()
        self._spare = position - len(octets)
        for at, draw in reversed(struck):  # from the end, so that a dropped octet does not move the others
            self._damage(octets, at, draw, self._size)

    def _draw_gap(self) -> int:
        """Return how many octets pass unharmed before the next one is struck."""
        return int(self._rng.geometric(self._rate)) - 1 if self._rate else 0


@dataclass(frozen=True, slots=True, kw_only=True)
class TimedFault:
    """Something that happens once.

    Attributes:
        name: what.
        tick: when.
        ticks: how long, 0 where it has no duration.
        size: size of a tick jump, in ticks.
    """

    name: FaultName
    tick: int
    ticks: int
    size: int


class FaultPlan:
    """A scenario's faults, sorted by who acts on them.

    Args:
        faults: all faults of the scenario; those of the sensors are left to the fast loop.
        tick_hz: ticks per second.
    """

    def __init__(self, faults: Sequence[Fault], tick_hz: int) -> None:
        self._damages = [OctetDamage(fault, tick_hz) for fault in faults if fault.name in DAMAGES]
        timed = [
            TimedFault(
                name=fault.name,
                tick=round((fault.at_s or 0.0) * tick_hz),
                ticks=max(1, round((fault.duration_s or 0.0) * tick_hz)),
                size=round(fault.magnitude or 0.0),
            )
            for fault in faults
            if fault.name in TIMED
        ]
        self._timed = sorted(timed, key=lambda fault: fault.tick)

    def damage(self, octets: bytes, tick: int) -> bytes:
        """Return the octets as they leave the line at `tick`."""
        if not self._damages or not octets:
            return octets
        damaged = bytearray(octets)
        for damage in self._damages:
            damage.apply(damaged, tick)
        return bytes(damaged)

    def ticks_to_next(self, tick: int) -> float:
        """Return the ticks until something happens; infinity if nothing will."""
        return max(0, self._timed[0].tick - tick) if self._timed else math.inf

    def take_due(self, tick: int) -> list[TimedFault]:
        """Return what happens at `tick` or should have before; each is returned once."""
        due = [fault for fault in self._timed if fault.tick <= tick]
        self._timed = self._timed[len(due) :]
        return due
