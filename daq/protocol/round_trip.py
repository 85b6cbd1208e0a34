"""How long to wait for a reply, from the replies seen so far (RFC 6298, with this protocol's bounds)."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkOptions:
    """Options of the host's side of the link; the defaults are those of docs/protocol.md.

    Attributes:
        tries: How often a command is sent before it is given up.
        rto_initial_ns: Wait for the first reply, while no round trip is known, ns.
        rto_min_ns: Shortest wait, ns; raise it where the controller or the adapter may pause longer.
        rto_max_ns: Longest wait, ns.
        first_seq: Sequence number of the first command, 0 to 255.
    """

    tries: int = 3
    rto_initial_ns: int = 250_000_000
    rto_min_ns: int = 25_000_000
    rto_max_ns: int = 1_000_000_000
    first_seq: int = 0

    def __post_init__(self) -> None:
        if self.tries < 1:
            raise ValueError(f"tries={self.tries} must be at least 1")
        if not 0 < self.rto_min_ns <= self.rto_initial_ns <= self.rto_max_ns:
            raise ValueError(
                f"rto_min_ns={self.rto_min_ns}, rto_initial_ns={self.rto_initial_ns}, "
                f"rto_max_ns={self.rto_max_ns} must be positive and in ascending order"
            )
        if not 0 <= self.first_seq <= 255:
            raise ValueError(f"first_seq={self.first_seq} must lie in 0 to 255")


class RoundTripTimer:
    """Smoothed round trip and the waiting time that follows from it: clamp(srtt + 4 rttvar, min, max)."""

    def __init__(self, options: LinkOptions) -> None:
        self._options = options
        self._srtt_ns: float | None = None
        self._rttvar_ns = 0.0

    @property
    def srtt_ns(self) -> float | None:
        """Smoothed round trip, ns; None before the first reply."""
        return self._srtt_ns

    def observe(self, rtt_ns: int) -> None:
        """Take in one round trip of a command that was sent once (Karn: a repeated one is ambiguous)."""
        if self._srtt_ns is None:
            self._srtt_ns, self._rttvar_ns = float(rtt_ns), rtt_ns / 2.0
            return
        self._rttvar_ns += 0.25 * (abs(rtt_ns - self._srtt_ns) - self._rttvar_ns)
        self._srtt_ns += 0.125 * (rtt_ns - self._srtt_ns)

    def wait_ns(self, tries: int) -> int:
        """Waiting time after the `tries`-th sending: doubled each time, never above the maximum."""
        base = self._options.rto_initial_ns
        if self._srtt_ns is not None:
            base = max(round(self._srtt_ns + 4.0 * self._rttvar_ns), self._options.rto_min_ns)
        return min(base << (tries - 1), self._options.rto_max_ns)
