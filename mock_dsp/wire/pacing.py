"""How fast the controller's time may pass: with the wall clock, or as fast as the host does its duties.

Theory of operation. The controller's program counts ticks and knows nothing of a clock. At 1x and N x the
ticks follow the wall clock; when this process was held up for longer than `MAX_LAG_NS`, the ticks in
between are given up instead of being caught up in one go, because the keep-alives that the host sent
meanwhile would all be read before them and the lease would expire for no fault of the host.
At any speed beyond 1x the time must not outrun the host: as soon as less than half is left of
something that the host owes (the lease, the next set-points), time stands still until the host has sent it,
or until the whole duration of that duty has passed on the wall clock. Then time goes on and the drive trips,
as it would on a real rig whose host has died.
"""

import math
from collections.abc import Sequence

from mock_dsp.program.controller import HostDuty

MAX_LAG_NS = 100_000_000
_NS_PER_S = 1_000_000_000


class WallPace:
    """Ticks that follow the wall clock.

    Args:
        ticks_per_s: tick rate times the speed factor.
        t_ns: wall clock now.
    """

    def __init__(self, ticks_per_s: float, t_ns: int) -> None:
        self._ticks_per_s = ticks_per_s
        self._origin_ns = t_ns
        self._granted = 0

    def due_ticks(self, t_ns: int) -> int:
        """Return how many ticks are due now."""
        due = math.floor((t_ns - self._origin_ns) * self._ticks_per_s / _NS_PER_S) - self._granted
        excess = due - math.floor(MAX_LAG_NS * self._ticks_per_s / _NS_PER_S)
        if excess <= 0:
            return max(0, due)
        self._origin_ns += math.ceil(excess * _NS_PER_S / self._ticks_per_s)
        return due - excess

    def grant(self, ticks: int) -> None:
        """Count ticks that have passed."""
        self._granted += ticks

    def restart(self, t_ns: int) -> None:
        """Let the wall clock count from now, after a time in which something else set the pace."""
        self._origin_ns = t_ns
        self._granted = 0


class DutyGate:
    """Hold the time while the host is behind with a duty.

    Args:
        tick_hz: ticks per second of the controller.
    """

    def __init__(self, tick_hz: int) -> None:
        self._tick_hz = tick_hz
        self._held_since_ns: int | None = None

    def allow(self, duties: Sequence[HostDuty], t_ns: int) -> float:
        """Return how many ticks may pass now: 0 while time is held, infinity if nothing limits them."""
        margins = [duty.left_ticks - duty.full_ticks // 2 for duty in duties]
        if all(margin > 0 for margin in margins):
            self._held_since_ns = None
            return min(margins, default=math.inf)
        if self._held_since_ns is None:
            self._held_since_ns = t_ns
        patience_ticks = min(
            duty.full_ticks for duty, margin in zip(duties, margins, strict=True) if margin <= 0
        )
        held_ns = t_ns - self._held_since_ns
        return 0 if held_ns * self._tick_hz < patience_ticks * _NS_PER_S else math.inf
