"""Small parts of the driver: lease, queue, gathering, discovery, set-points, capture."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from daq.driver import discovery
from daq.driver.batch_gathering import BATCH_S, BatchGathering
from daq.driver.capture import CapturePlan, read_capture, start_capture
from daq.driver.discovery import DeviceInfo, describe_devices, list_devices
from daq.driver.frame_queue import FrameQueue
from daq.driver.lease import Lease
from daq.driver.setpoint_feeder import SetpointFeeder
from daq.excitation.spec import Setpoints
from daq.protocol.codes import Trigger
from daq.protocol.commands import CaptureConfig, CaptureRead, Ping, RunAbort, SetpointBegin, SetpointChunk
from daq.protocol.dictionary import Dictionary
from daq.protocol.dictionary_entries import Channel, CountType, Layout, SetpointBuffer
from daq.protocol.message import Command, Reply
from daq.protocol.replies import (
    CaptureArmReply,
    CaptureConfigReply,
    CaptureReadReply,
    PingReply,
    RunAbortReply,
    SetpointBeginReply,
    SetpointChunkReply,
)

MS = 10**6
LAYOUT = Layout(id=1, name="control", channels=("current", "position"))
DICTIONARY = Dictionary(
    device="d",
    firmware="1",
    parameters=(),
    channels=(
        Channel(name="current", column="a", unit="A", type=CountType.I16, scale=1.0, offset=0.0),
        Channel(name="position", column="b", unit="rad", type=CountType.U16, scale=1.0, offset=0.0),
    ),
    layouts=(LAYOUT,),
    faults=(),
    generators=(),
)


@pytest.mark.parametrize(
    ("tick", "t_ms", "due"),
    [
        (1000, 1, False),
        (1155, 1, False),
        (1156, 1, True),  # 250 ms at 2500 Hz: a quarter is 156 ticks
        (1001, 62, False),
        (1001, 63, True),  # ... or 62.5 ms of the host
        (None, 63, True),
    ],
)
def test_lease_is_due_by_either_clock(tick: int | None, t_ms: int, due: bool) -> None:
    lease = Lease(session=1, lease_ms=250, tick_hz=2500, t_ns=0)
    lease.renew(1000, 0)
    assert lease.is_due(tick, t_ms * MS) is due


def test_first_samples_after_arming_renew_the_lease() -> None:
    assert Lease(session=1, lease_ms=250, tick_hz=2500, t_ns=0).is_due(5, 0)


def test_queue_drops_what_does_not_fit_and_counts_it() -> None:
    queue = FrameQueue(max_frames=3)
    queue.put([b"1", b"2"])
    queue.put([b"3", b"4"])
    queue.put([b"5"])
    assert queue.take() == [b"1", b"2", b"5"]
    assert queue.dropped_frames == 2
    assert queue.take() == []


def test_samples_in_real_time_are_gathered_and_faster_ones_are_not() -> None:
    now_s, pauses = [0.0], list[float]()
    gathering = BatchGathering(2500, clock=lambda: now_s[0], sleep=pauses.append)
    gathering.pause()
    assert pauses == []  # the pace is not known yet
    for now_s[0], tick in ((0.3, 750), (0.6, 1500)):
        gathering.note_samples(tick)
    gathering.pause()
    now_s[0] += 0.01
    gathering.pause()
    assert pauses == [pytest.approx(BATCH_S - 0.01)]
    now_s[0] = 10.0
    gathering.note_samples(1501)  # the stream was stopped for a while: no news of the pace
    now_s[0] = 10.5
    gathering.note_samples(250_000)  # 100 s of samples in half a second
    gathering.pause()
    gathering.pause()
    assert len(pauses) == 1


def test_devices_are_listed_with_links_to_pseudo_terminals(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Port:
        device, description, serial_number = "/dev/ttyUSB7", "FT232H", "A1"

    def no_warning(path: str) -> str:
        return f"{path} is slow"

    monkeypatch.setattr("serial.tools.list_ports.comports", lambda: [Port()])
    monkeypatch.setattr(discovery, "latency_timer_warning", no_warning)
    (tmp_path / "joint1").symlink_to("/dev/pts/ptmx")
    (tmp_path / "notes.txt").write_text("no port")
    found = list_devices((tmp_path, tmp_path / "missing"))
    assert found[0] == DeviceInfo(
        url="/dev/ttyUSB7", description="FT232H", serial_number="A1", warning="/dev/ttyUSB7 is slow"
    )
    assert [device.url for device in found[1:]] == [str(tmp_path / "joint1")]
    assert describe_devices(found).startswith("ports found: /dev/ttyUSB7 (FT232H), ")
    assert "no serial port" in describe_devices([])


def feeder_log(values: int, hold_s: float) -> tuple[SetpointFeeder, list[Command]]:
    """Return a feeder on a controller that takes everything, and what it was sent."""
    sent: list[Command] = []

    def ask(command: Command, detail: str) -> Reply:
        sent.append(command)
        replies: dict[type[Command], Callable[[], Reply]] = {
            SetpointBegin: lambda: SetpointBeginReply(status=0, free=512),
            SetpointChunk: lambda: SetpointChunkReply(status=0, free=0, played=0),
            Ping: lambda: PingReply(status=0, cookie=0, tick=(1 << 32) - 10, subtick=0),
            RunAbort: lambda: RunAbortReply(status=0, tick=0),
        }
        return replies[type(command)]()

    points = Setpoints(values_a=tuple(np.linspace(0.0, 1.0, values)), hold_s=hold_s)
    return SetpointFeeder(points, 2500, SetpointBuffer(), ask), sent


def words_sent(sent: list[Command]) -> int:
    """Return how many words the chunks hold; they must follow each other without a hole."""
    total = 0
    for chunk in (command for command in sent if isinstance(command, SetpointChunk)):
        assert chunk.first == total
        assert len(chunk.words) <= 192
        total += len(chunk.words) // 2
    return total


def test_both_halves_are_filled_and_refilled_as_a_half_is_played() -> None:
    feeder, sent = feeder_log(values=2000, hold_s=2 / 2500)
    start = feeder.begin(centring=True)
    assert sent[0] == SetpointBegin(divisor=2, flags=1)
    assert words_sent(sent) == 512
    feeder.feed(start + 2 * 255)  # one word short of a half
    assert words_sent(sent) == 512
    feeder.feed(start + 2 * 256)  # beyond the wrap of the 32-bit tick
    assert words_sent(sent) == 768


def test_stream_ends_in_order_when_all_is_played() -> None:
    feeder, sent = feeder_log(values=300, hold_s=1 / 2500)
    start = feeder.begin(centring=False)
    feeder.feed(start + 299)
    assert not any(isinstance(command, RunAbort) for command in sent)
    feeder.feed(start + 300)
    feeder.feed(start + 301)
    assert sum(isinstance(command, RunAbort) for command in sent) == 1
    assert words_sent(sent) >= 512


def test_capture_is_read_in_pieces_and_split_into_channels() -> None:
    words = np.arange(400, dtype=np.int16) - 100
    sent: list[Command] = []

    def ask(command: Command, detail: str) -> Reply:
        sent.append(command)
        if isinstance(command, CaptureConfig):
            return CaptureConfigReply(status=0, depth=200)
        if isinstance(command, CaptureRead):
            part = words[command.offset : command.offset + command.count].tobytes()
            return CaptureReadReply(status=0, offset=command.offset, total=400, trigger_tick=77, words=part)
        return CaptureArmReply(status=0)

    what = CapturePlan(layout="control", trigger=Trigger.LEVEL, channel="position", level_counts=5)
    assert start_capture(what, DICTIONARY, ask) == 200
    assert isinstance(sent[0], CaptureConfig)
    assert (sent[0].channel, sent[0].level) == (1, 5)
    capture = read_capture(what, DICTIONARY, ask)
    assert capture is not None
    assert capture.trigger_tick == 77
    np.testing.assert_array_equal(capture.counts["current"], words[::2])
    np.testing.assert_array_equal(capture.counts["position"], words[1::2].view(np.uint16))


def test_capture_that_is_not_ready_is_none() -> None:
    def ask(command: Command, detail: str) -> Reply:
        return CaptureReadReply(status=0, offset=0, total=0, trigger_tick=0, words=b"")

    assert read_capture(CapturePlan(layout="control"), DICTIONARY, ask) is None


def test_capture_trigger_outside_the_layout_is_named() -> None:
    def ask(command: Command, detail: str) -> Reply:
        raise AssertionError("nothing may be sent")

    what = CapturePlan(layout="control", trigger=Trigger.LEVEL, channel="speed")
    with pytest.raises(
        ValueError, match="channel='speed' is not in layout 'control'; use one of current, position"
    ):
        start_capture(what, DICTIONARY, ask)
