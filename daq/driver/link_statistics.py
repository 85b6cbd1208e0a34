"""How the link is doing, once a second, and in plain words what went wrong since the last time."""

from dataclasses import dataclass

from daq.clock.fit import ClockFit

_STALL_S = 0.1
"""A reader that was kept from its port for this long is worth a word: a USB adapter's buffer is then half full."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkStatistics:
    """State of the link. Counters start at 0 when the port is opened and only go up.

    Attributes:
        t_ns: Host monotonic time of this record.
        baud: Line rate in use, 1/s.
        octets: Octets received.
        frames: Frames received whole.
        bad_frames: Frames dropped for a wrong CRC, wrong stuffing or wrong length.
        commands_retried: Commands sent again because no reply came in time.
        commands_lost: Commands given up after the last try.
        samples_lost: Samples missing in the stream, from the ticks.
        queue_dropped_frames: Frames that the data task was too slow to take (the journal has them).
        reconnects: Times the port was lost and found again.
        stall_s: Longest time the reader was kept from the port since the last record, s.
        octets_per_s: Octets received per second since the last record.
        controller_rx_errors: Damaged frames that the controller saw.
        controller_tx_drops: Frames that the controller could not send, its ring being full.
        controller_isr_max_us: Longest run of the controller's interrupt, us.
        clock: Fit of ticks to host time, None before the first PING.
        cause: What went wrong since the last record, in plain words; empty when nothing did.
    """

    t_ns: int
    baud: int
    octets: int = 0
    frames: int = 0
    bad_frames: int = 0
    commands_retried: int = 0
    commands_lost: int = 0
    samples_lost: int = 0
    queue_dropped_frames: int = 0
    reconnects: int = 0
    stall_s: float = 0.0
    octets_per_s: float = 0.0
    controller_rx_errors: int = 0
    controller_tx_drops: int = 0
    controller_isr_max_us: int = 0
    clock: ClockFit | None = None
    cause: str = ""


def explain_trouble(before: LinkStatistics, now: LinkStatistics) -> str:
    """Return what went wrong between two records, worst first; empty when nothing did."""
    causes = [
        _reconnected(now.reconnects - before.reconnects),
        _stalled(now.stall_s),
        _damaged(now.bad_frames - before.bad_frames, now.frames - before.frames),
        _counted(
            now.controller_tx_drops - before.controller_tx_drops,
            "frames dropped by the controller: line too slow",
        ),
        _counted(now.controller_rx_errors - before.controller_rx_errors, "of our frames arrived damaged"),
        _counted(
            now.queue_dropped_frames - before.queue_dropped_frames, "frames dropped: data task too slow"
        ),
        _counted(now.commands_lost - before.commands_lost, "commands without any reply"),
        _counted(now.commands_retried - before.commands_retried, "commands sent again"),
        _lost(before, now),
        _jumped(before.clock, now.clock),
    ]
    return "; ".join(cause for cause in causes if cause)


def _reconnected(times: int) -> str:
    return "port lost and found again (cable or USB adapter)" if times else ""


def _stalled(stall_s: float) -> str:
    return f"host stalled {stall_s * 1e3:.0f} ms" if stall_s >= _STALL_S else ""


def _damaged(bad: int, good: int) -> str:
    return f"CRC errors {100.0 * bad / (bad + good):.2g} %" if bad else ""


def _counted(count: int, words: str) -> str:
    return f"{count} {words}" if count > 0 else ""


def _lost(before: LinkStatistics, now: LinkStatistics) -> str:
    lost = now.samples_lost - before.samples_lost
    named = now.bad_frames - before.bad_frames + now.controller_tx_drops - before.controller_tx_drops
    named += now.queue_dropped_frames - before.queue_dropped_frames + now.reconnects - before.reconnects
    if lost <= 0:
        return ""
    return f"{lost} samples lost" + (
        "" if named else " without a damaged frame: overrun in the adapter or the controller"
    )


def _jumped(before: ClockFit | None, now: ClockFit | None) -> str:
    jumps = (now.jumps if now else 0) - (before.jumps if before else 0)
    return "controller's tick jumped against host time" if jumps > 0 else ""
