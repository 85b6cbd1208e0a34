"""A lost link: the port is found again, the hole is a gap with its cause, and the drive stays off."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import pytest

from daq.driver.options import StreamPlan
from daq.driver.rig import Rig
from daq.errors import DictionaryError, PortError
from daq.protocol.codes import EventCode
from daq.protocol.commands import Arm
from daq.protocol.reports import Event
from daq.protocol.tick_axis import GapCause

if TYPE_CHECKING:
    from tests.daq.driver.conftest import Bench

OpenStub = Callable[[], Rig]


class NoteSink:
    """Keeps the kinds of the remarks it is given."""

    def __init__(self) -> None:
        self.kinds: list[str] = []

    def append(self, raw: bytes) -> None:
        """Take octets."""

    def note(self, kind: str, data: Mapping[str, Any]) -> None:  # JSON values
        """Keep the kind of a remark."""
        self.kinds.append(kind)


def test_pulled_cable_is_found_again_and_leaves_a_gap(bench: Bench, open_stub: OpenStub) -> None:
    rig, sink = open_stub(), NoteSink()
    rig.attach(sink)
    rig.start_stream(StreamPlan())
    rig.arm()
    bench.port.report(*bench.controller.samples(2))
    bench.pull(rig, 50)
    bench.refuse_opening = 2
    bench.port.pull_cable()
    assert bench.wait_until(lambda: rig.link_up and len(bench.ports) == 2, rig)
    bench.controller.samples(4)  # lost while nobody listened
    bench.port.report(*bench.controller.samples(2))
    gaps = [gap for block in bench.pull(rig, 50) for gap in block.gaps]
    assert [(gap.missing_samples, gap.cause) for gap in gaps] == [(100, GapCause.RECONNECT)]
    assert bench.controller.count(Arm) == 1  # never armed again by itself
    assert {"link_lost", "link_found"} <= set(sink.kinds)
    assert bench.wait_until(lambda: rig.link_statistics().reconnects == 1, rig)


def test_restarted_controller_is_noticed_and_not_armed(bench: Bench, open_stub: OpenStub) -> None:
    rig = open_stub()
    rig.arm()
    bench.controller.session = 8
    bench.controller.baud = 115_200
    bench.port.pull_cable()
    assert bench.wait_until(lambda: rig.reboots == 1 and rig.link_up, rig)
    assert rig.hello.session == 8
    assert bench.controller.count(Arm) == 1


def test_boot_event_leads_to_a_new_introduction(bench: Bench, open_stub: OpenStub) -> None:
    rig = open_stub()
    bench.controller.session = 9
    bench.port.report(Event(event=1, code=EventCode.BOOT, tick=0, arg=9))
    assert bench.wait_until(lambda: rig.reboots == 1 and rig.link_up, rig)


def test_port_that_stays_away_is_given_up_with_both_causes(bench: Bench, open_stub: OpenStub) -> None:
    bench.options = replace(bench.options, reconnect_s=0.0)
    rig = open_stub()
    bench.refuse_opening = 1000
    bench.port.pull_cable()
    with pytest.raises(PortError, match="cable pulled.*not found again in 0 s: stub: no such port"):
        for _ in range(100):
            rig.next_blocks(0.05)
    with pytest.raises(PortError, match="not found again"):
        rig.estop()


def test_another_controller_at_the_port_is_refused(bench: Bench, open_stub: OpenStub) -> None:
    rig = open_stub()
    bench.controller.octets = zlib.compress(
        zlib.decompress(bench.controller.octets).replace(b"stub", b"twin")
    )
    bench.port.pull_cable()
    with pytest.raises(DictionaryError, match="another controller, or another program"):
        for _ in range(100):
            rig.next_blocks(0.05)
