"""When the drive's lease must be renewed, by device time as well as by host time."""

_NS_PER_MS = 1_000_000


class Lease:
    """One grant of the drive, from ARM until it is given back or lost.

    Device time counts because an emulated controller may run much faster than the host's clock; host time
    counts because a stream may be stopped while the drive is on.

    Args:
        session: The controller's boot session that granted it.
        lease_ms: Length of the grant, ms.
        tick_hz: Controller ticks per second.
        t_ns: Host time of the grant, ns.
    """

    def __init__(self, session: int, lease_ms: int, tick_hz: int, t_ns: int) -> None:
        self.session = session
        self._quarter_ticks = lease_ms * tick_hz // 4000
        self._quarter_ns = lease_ms * _NS_PER_MS // 4
        self._renewed_tick: int | None = None
        self._renewed_ns = t_ns

    def is_due(self, tick: int | None, t_ns: int) -> bool:
        """Tell whether a quarter of the lease is over.

        Args:
            tick: Newest controller tick known, on the 64-bit axis; None before the first sample.
            t_ns: Host time, ns.
        """
        if tick is not None and (
            self._renewed_tick is None or tick - self._renewed_tick >= self._quarter_ticks
        ):
            return True
        return t_ns - self._renewed_ns >= self._quarter_ns

    def renew(self, tick: int | None, t_ns: int) -> None:
        """Take note that a keep-alive has been sent."""
        self._renewed_tick, self._renewed_ns = tick, t_ns
