"""Keeps the link's figures over reconnects, fits the clock, and writes a record of both once a second."""

import logging
from dataclasses import asdict, replace
from typing import Any

from daq.clock.fit import ClockFit, ClockFitOptions, ClockFitter, PingSample
from daq.driver.link_statistics import LinkStatistics, explain_trouble
from daq.protocol.host_link import HostLink
from daq.protocol.replies import LinkStatsReply, PingReply

_LOG = logging.getLogger(__name__)
_NS_PER_S = 1_000_000_000


class LinkMonitor:
    """Collects what the port thread sees; `statistics` is the last complete record.

    Args:
        tick_hz: Ticks per second that the controller announces.
        baud: Rate in use.
        t_ns: Host time now.
    """

    def __init__(self, tick_hz: int, baud: int, t_ns: int) -> None:
        self._fitter = ClockFitter(ClockFitOptions(nominal_hz=tick_hz))
        self._clock = self._fitter.init()
        self._total = LinkStatistics(t_ns=t_ns, baud=baud)
        self._before_reconnect = self._total
        self._controller_seen: tuple[int, int] | None = None  # errors and drops at its last answer
        self._last_turn_ns = t_ns
        self._stall_ns = 0
        self.statistics = self._total

    def note_turn(self, t_ns: int) -> None:
        """Take note that the reader has just come back from its port."""
        self._stall_ns = max(self._stall_ns, t_ns - self._last_turn_ns)
        self._last_turn_ns = t_ns

    def note_ping(self, reply: PingReply, t_sent_ns: int, t_received_ns: int) -> None:
        """Take a PING's round trip into the clock fit."""
        sample = PingSample(
            t_sent_ns=t_sent_ns, t_received_ns=t_received_ns, tick=reply.tick, subtick=reply.subtick
        )
        steady = self._clock.steady
        self._fitter.step(self._clock, sample)
        if steady and not self._clock.steady:
            _LOG.info("the controller's ticks do not follow this host's clock (an emulator at full speed?)")

    def note_controller(self, reply: LinkStatsReply) -> None:
        """Take the controller's own counters, which start anew when it restarts."""
        errors = reply.rx_crc_errors + reply.rx_malformed + reply.rx_overruns
        # What it counted before the first answer belongs to others; after a restart it counts from zero again.
        before_errors, before_drops = self._controller_seen or (errors, reply.tx_drops)
        if errors < before_errors or reply.tx_drops < before_drops:
            before_errors, before_drops = 0, 0
        self._controller_seen = (errors, reply.tx_drops)
        self._total = replace(
            self._total,
            controller_rx_errors=self._total.controller_rx_errors + errors - before_errors,
            controller_tx_drops=self._total.controller_tx_drops + reply.tx_drops - before_drops,
            controller_isr_max_us=reply.isr_max_us,
        )

    def note_reconnect(self, baud: int, *, rebooted: bool) -> None:
        """Take note that a new link has taken over from the lost one, whose last figures stay counted."""
        self._total = replace(self._total, baud=baud, reconnects=self._total.reconnects + 1)
        self._before_reconnect = self._total
        if rebooted:
            self._clock = self._fitter.init()
            self._controller_seen = (0, 0)

    def count(self, link: HostLink) -> None:
        """Take over the counters of the link in use."""
        base, counters, decoder = self._before_reconnect, link.counters, link.decoder.counters
        self._total = replace(
            self._total,
            octets=base.octets + decoder.octets,
            frames=base.frames + decoder.frames,
            bad_frames=base.bad_frames + decoder.dropped + counters.malformed,
            commands_retried=base.commands_retried + counters.retries,
            commands_lost=base.commands_lost + counters.timeouts,
        )

    def complete(self, t_ns: int, *, samples_lost: int, queue_dropped_frames: int) -> LinkStatistics:
        """Finish the record of the last second and begin the next."""
        before = self.statistics
        elapsed_s = max(t_ns - before.t_ns, 1) / _NS_PER_S
        now = replace(
            self._total,
            t_ns=t_ns,
            samples_lost=samples_lost,
            queue_dropped_frames=queue_dropped_frames,
            stall_s=self._stall_ns / _NS_PER_S,
            octets_per_s=(self._total.octets - before.octets) / elapsed_s,
            clock=self._clock.fit,
        )
        self.statistics = replace(now, cause=explain_trouble(before, now))
        self._stall_ns = 0
        return self.statistics


def statistics_note(statistics: LinkStatistics) -> dict[str, Any]:  # JSON values
    """Return the journal's `link_statistics` note; the clock fit has a note of its own."""
    note = asdict(statistics)
    del note["clock"]
    return note


def clock_note(fit: ClockFit) -> dict[str, Any]:  # JSON values
    """Return the journal's `clock_fit` note."""
    return asdict(fit)
