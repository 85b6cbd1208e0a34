"""Link statistics: counting over reconnects, and the cause of trouble in plain words."""

from dataclasses import replace

import pytest

from daq.driver.link_statistics import LinkStatistics, explain_trouble
from daq.driver.monitor import LinkMonitor, clock_note, statistics_note
from daq.protocol.host_link import HostLink
from daq.protocol.replies import LinkStatsReply, PingReply

SECOND_NS = 10**9
QUIET = LinkStatistics(t_ns=0, baud=937_500)


def controller_counts(errors: int, drops: int) -> LinkStatsReply:
    """Return a controller's counters."""
    return LinkStatsReply(
        status=0, rx_frames=0, rx_crc_errors=errors, rx_malformed=0, rx_overruns=0, rx_unknown=0, tx_frames=0,
        tx_octets=0, tx_drops=drops, isr_max_us=40,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("now", "cause"),
    [
        (replace(QUIET, frames=1000), ""),
        (replace(QUIET, stall_s=0.18), "host stalled 180 ms"),
        (replace(QUIET, frames=98, bad_frames=2), "CRC errors 2 %"),
        (replace(QUIET, controller_tx_drops=3), "3 frames dropped by the controller: line too slow"),
        (replace(QUIET, queue_dropped_frames=7), "7 frames dropped: data task too slow"),
        (replace(QUIET, reconnects=1), "port lost and found again (cable or USB adapter)"),
        (
            replace(QUIET, samples_lost=25),
            "25 samples lost without a damaged frame: overrun in the adapter or the controller",
        ),
        (
            replace(QUIET, commands_retried=2, commands_lost=1),
            "1 commands without any reply; 2 commands sent again",
        ),
    ],
)
def test_trouble_is_put_into_words(now: LinkStatistics, cause: str) -> None:
    assert explain_trouble(QUIET, now) == cause


def test_old_trouble_is_not_told_again() -> None:
    troubled = replace(QUIET, bad_frames=5, samples_lost=100, reconnects=1)
    assert explain_trouble(troubled, replace(troubled, frames=1000)) == ""


def test_figures_of_a_lost_link_stay_counted() -> None:
    monitor = LinkMonitor(tick_hz=2500, baud=115_200, t_ns=0)
    old, new = HostLink(), HostLink()
    old.receive(b"\x01\x02\x00", 0)  # a frame that is none
    monitor.count(old)
    monitor.note_reconnect(937_500, rebooted=False)
    new.receive(b"\x01\x02\x00\x01\x02\x00", 0)
    monitor.count(new)
    record = monitor.complete(2 * SECOND_NS, samples_lost=0, queue_dropped_frames=0)
    assert (record.bad_frames, record.octets, record.reconnects, record.baud) == (3, 9, 1, 937_500)
    assert record.octets_per_s == 4.5


def test_controller_counters_from_before_are_not_ours() -> None:
    monitor = LinkMonitor(tick_hz=2500, baud=115_200, t_ns=0)
    monitor.note_controller(controller_counts(errors=1000, drops=50))
    monitor.note_controller(controller_counts(errors=1002, drops=51))
    monitor.note_controller(controller_counts(errors=1, drops=0))  # restarted: counts from zero
    record = monitor.complete(SECOND_NS, samples_lost=0, queue_dropped_frames=0)
    assert (record.controller_rx_errors, record.controller_tx_drops) == (3, 1)


def test_longest_stall_of_the_second_is_kept() -> None:
    monitor = LinkMonitor(tick_hz=2500, baud=115_200, t_ns=0)
    for t_ms in (20, 40, 290, 310):
        monitor.note_turn(t_ms * 10**6)
    record = monitor.complete(SECOND_NS, samples_lost=0, queue_dropped_frames=0)
    assert record.stall_s == pytest.approx(0.25)
    assert record.cause == "host stalled 250 ms"
    assert monitor.complete(2 * SECOND_NS, samples_lost=0, queue_dropped_frames=0).stall_s == 0.0


def test_notes_hold_json_values_and_the_clock_apart() -> None:
    monitor = LinkMonitor(tick_hz=2500, baud=115_200, t_ns=0)
    monitor.note_ping(PingReply(status=0, cookie=0, tick=100, subtick=0), 0, 1_000_000)
    record = monitor.complete(SECOND_NS, samples_lost=0, queue_dropped_frames=0)
    assert "clock" not in statistics_note(record)
    assert record.clock is not None
    assert clock_note(record.clock)["rate_hz"] == 2500
