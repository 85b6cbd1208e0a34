"""The rig's calls against a controller in memory."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import pytest

from daq.driver.options import StreamPlan
from daq.driver.rig import Rig, open_rig
from daq.errors import (
    DeviceFaultError,
    DeviceRefusedError,
    JournalWriteError,
    LinkTimeoutError,
    PortError,
    WireBudgetError,
)
from daq.excitation.spec import Sine
from daq.protocol.codes import LIMIT_PARAMETERS, STATUS_REMEDIES, EventCode, StatusCode
from daq.protocol.commands import Arm, ClearFault, Disarm, Estop, KeepAlive, ParamSet, Run, StreamStart
from daq.protocol.message import Command
from daq.protocol.replies import ClearFaultReply, Refusal
from daq.protocol.reports import Event, Status
from daq.protocol.tick_axis import GapCause

if TYPE_CHECKING:
    from tests.daq.driver.conftest import Bench

OpenStub = Callable[[], Rig]


class ListSink:
    """Keeps what it is given, or refuses it."""

    def __init__(self, *, full: bool = False) -> None:
        self.octets = b""
        self.kinds: list[str] = []
        self.full = full

    def append(self, raw: bytes) -> None:
        """Keep octets."""
        if self.full:
            raise JournalWriteError("disk full")
        self.octets += raw

    def note(self, kind: str, data: Mapping[str, Any]) -> None:  # JSON values
        """Keep the kind of a remark."""
        self.kinds.append(kind)


def refusing(bench: Bench, command: type[Command], status: StatusCode) -> None:
    """Let the controller refuse a command."""
    bench.controller.answers[command] = lambda c: Refusal(command=c.TYPE, status=status)


def status_report(faults: int) -> Status:
    """Return a STATUS with faults."""
    return Status(
        state=5, faults=faults, lease_left_ms=0, credits=512, tick=0, rx_errors=0, tx_drops=0, isr_max_us=0,
        bus_decivolt=0, temperature_decicelsius=0, setpoints_free=0,
    )  # fmt: skip


def test_parameters_are_read_and_written_in_si(open_stub: OpenStub) -> None:
    rig = open_stub()
    assert rig.read_parameter("current_limit_A") == pytest.approx(2.0)
    assert rig.write_parameter("current_limit_A", 1.5) == pytest.approx(1.5)
    assert rig.write_parameter("current_limit_A", 900.0) == pytest.approx(3.0)  # what the stub clamps to
    assert rig.read_parameter("current_limit_A") == pytest.approx(3.0)


def test_parameter_outside_its_range_is_not_sent(bench: Bench, open_stub: OpenStub) -> None:
    rig = open_stub()
    with pytest.raises(ValueError, match=r"current_limit_A=5000 must lie in \[-1000, 1000\] SI"):
        rig.write_parameter("current_limit_A", 5000.0)
    with pytest.raises(KeyError, match="no parameter 'currentlimit'.*current_limit_A"):
        rig.read_parameter("currentlimit")
    assert bench.controller.count(ParamSet) == 0


def test_samples_come_as_blocks_and_reach_the_sink_first(bench: Bench, open_stub: OpenStub) -> None:
    rig, sink = open_stub(), ListSink()
    rig.attach(sink)
    budget = rig.start_stream(StreamPlan())
    bench.port.report(*bench.controller.samples(8))
    blocks = bench.pull(rig, 200)
    assert sum(block.ticks.size for block in blocks) == 200
    assert budget.batch == 25
    # 25 samples of 3 channels: 150 octets of samples, 16 of header, CRC and framing (docs/protocol.md, "Wire budget").
    assert budget.octets_per_s == 166 * 100
    assert len(sink.octets) >= 8 * 166


def test_lost_frame_is_a_gap_and_counted(bench: Bench, open_stub: OpenStub) -> None:
    rig = open_stub()
    rig.start_stream(StreamPlan())
    first, lost, last = bench.controller.samples(3)
    bench.port.report(first)
    bench.controller.link.send(lost)
    bench.controller.link.take_output()  # swallowed by the line
    bench.port.report(last)
    blocks = bench.pull(rig, 50)
    gaps = [gap for block in blocks for gap in block.gaps]
    assert [(gap.missing_samples, gap.cause) for gap in gaps] == [(25, GapCause.LOSS)]


def test_stream_that_does_not_fit_is_refused_with_one_that_does(bench: Bench, open_stub: OpenStub) -> None:
    bench.options = replace(bench.options, baud=115_200)
    rig = open_stub()
    with pytest.raises(
        WireBudgetError, match="144% of 115200 baud, the limit is 80%; use .*divisor 2"
    ) as refusal:
        rig.start_stream(StreamPlan())
    assert refusal.value.line_use == pytest.approx(1.441, abs=1e-3)
    assert bench.controller.count(StreamStart) == 0
    assert rig.start_stream(StreamPlan(divisor=2)).line_use < 0.8


def test_arm_proves_that_the_limits_are_known(bench: Bench, open_stub: OpenStub) -> None:
    rig = open_stub()
    assert rig.arm(lease_ms=300) == 300
    raw = b"".join(bench.controller.raw[p].to_bytes(4, "little", signed=True) for p in LIMIT_PARAMETERS)
    (arm,) = (command for command in bench.controller.seen if isinstance(command, Arm))
    assert arm == Arm(session=7, lease_ms=300, limits_crc=zlib.crc32(raw))
    rig.disarm()
    assert not rig.armed


def test_lease_is_renewed_until_the_disarmed_drive_rests(bench: Bench, open_stub: OpenStub) -> None:
    rig = open_stub()
    rig.arm(lease_ms=2000)
    rig.start_stream(StreamPlan())
    rig.disarm()
    bench.port.report(*bench.controller.samples(50))
    bench.pull(rig, 1250)
    rig.keep_alive()  # the ramp to zero takes its time, and is still under the lease
    rig.read_parameter("current_limit_A")
    assert bench.controller.count(KeepAlive) == 1
    assert not rig.armed


def test_keep_alive_follows_device_time(bench: Bench, open_stub: OpenStub) -> None:
    rig = open_stub()
    rig.arm(lease_ms=2000)
    rig.start_stream(StreamPlan())
    for _ in range(4):  # 4 x 1250 ticks, a quarter of the lease each: far faster than the host's clock
        bench.port.report(*bench.controller.samples(50))
        bench.pull(rig, 1250)
        rig.keep_alive()
        rig.keep_alive()  # nothing new has come: nothing is due
        rig.read_parameter("current_limit_A")  # the keep-alive's reply is in before the next one
    assert bench.controller.count(KeepAlive) == 4


def test_no_keep_alive_without_the_data_task(bench: Bench, open_stub: OpenStub) -> None:
    rig = open_stub()
    rig.arm(lease_ms=50)
    rig.start_stream(StreamPlan())
    bench.port.report(*bench.controller.samples(100))
    bench.pull(rig, 2500)
    assert bench.controller.count(KeepAlive) == 0


def test_refused_lease_is_reported(bench: Bench, open_stub: OpenStub) -> None:
    rig = open_stub()
    rig.arm(lease_ms=50)
    refusing(bench, KeepAlive, StatusCode.WRONG_STATE)
    rig.start_stream(StreamPlan())
    bench.port.report(*bench.controller.samples(10))
    bench.pull(rig, 250)
    rig.keep_alive()
    assert bench.wait_until(lambda: rig.lease_refusal is not None, rig)
    assert not rig.armed


@pytest.mark.parametrize(
    "status", [code for code in StatusCode if code not in (StatusCode.OK, StatusCode.CLAMPED)]
)
def test_every_refusal_has_words_and_values(bench: Bench, open_stub: OpenStub, status: StatusCode) -> None:
    rig = open_stub()
    refusing(bench, Run, status)
    latched = status in (StatusCode.FAULT_LATCHED, StatusCode.ESTOP_LATCHED)
    with pytest.raises(DeviceFaultError if latched else DeviceRefusedError) as refusal:
        rig.run(Sine(amplitude_a=0.5, period_s=5.0, duration_s=10.0))
    if isinstance(refusal.value, DeviceRefusedError):
        assert refusal.value.status == status
        assert STATUS_REMEDIES[status] in str(refusal.value)
        assert "amplitude_ua=500000" in str(refusal.value)
        assert "peak 0.5 A" in str(refusal.value)


def test_latched_fault_is_named_when_arming(bench: Bench, open_stub: OpenStub) -> None:
    rig = open_stub()
    bench.port.report(status_report(faults=0b1))
    assert bench.wait_until(lambda: rig.status is not None, rig)
    refusing(bench, Arm, StatusCode.FAULT_LATCHED)
    with pytest.raises(
        DeviceFaultError, match="over_current: A current was too large. Look for a short."
    ) as fault:
        rig.arm()
    assert fault.value.faults == 1


def test_fault_that_is_still_there_is_named_when_clearing(bench: Bench, open_stub: OpenStub) -> None:
    rig = open_stub()
    bench.controller.answers[ClearFault] = lambda c: ClearFaultReply(
        status=StatusCode.FAULT_LATCHED, faults=0b11
    )
    with pytest.raises(DeviceFaultError, match="over_current: .*fault bit 1, which"):
        rig.clear_fault()


def test_estop_is_sent_three_times_and_gives_up_the_lease(bench: Bench, open_stub: OpenStub) -> None:
    rig = open_stub()
    rig.arm()
    rig.estop()
    assert bench.controller.count(Estop) == 3
    assert not rig.armed


def test_closing_switches_the_drive_off(bench: Bench, open_stub: OpenStub) -> None:
    rig = open_stub()
    rig.arm()
    rig.close()
    assert bench.controller.count(Disarm) == 1
    with pytest.raises(PortError, match="closed"):
        rig.arm()


def test_silent_controller_is_a_timeout(bench: Bench, open_stub: OpenStub) -> None:
    rig = open_stub()
    bench.controller.silent.add(Disarm)
    with pytest.raises(LinkTimeoutError, match="no reply to Disarm after 3 tries"):
        rig.disarm()


def test_events_are_handed_over_once(bench: Bench, open_stub: OpenStub) -> None:
    rig = open_stub()
    event = Event(event=1, code=EventCode.FAULT, tick=5, arg=0)
    bench.port.report(event)
    bench.port.report(event)
    seen: list[Event] = []

    def has_come() -> bool:
        seen.extend(rig.events())
        return bool(seen)

    assert bench.wait_until(has_come, rig)
    rig.read_parameter("current_limit_A")
    assert seen + rig.events() == [event]


def test_full_disk_reaches_the_data_task(bench: Bench, open_stub: OpenStub) -> None:
    rig = open_stub()
    rig.attach(ListSink(full=True))
    with pytest.raises(JournalWriteError, match="disk full"):
        rig.start_stream(StreamPlan())
        rig.next_blocks(0.05)
    rig.detach()
    bench.port.report(*bench.controller.samples(1))
    assert bench.pull(rig, 25)[-1].ticks.size == 25  # the port still works: the drive can be stopped


def test_missing_port_lists_those_that_exist() -> None:
    with pytest.raises(PortError, match="/dev/ttyUSB98 does not exist; (ports found|no serial port)"):
        open_rig("/dev/ttyUSB98")


def test_layout_that_does_not_exist_is_named(open_stub: OpenStub) -> None:
    with pytest.raises(KeyError, match="no layout 'everything'.*control, lean"):
        open_stub().start_stream(StreamPlan(layout="everything"))
