"""Stream frames to samples: none is invented, every lost one is counted, whatever the line does."""

from dataclasses import fields

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from daq.protocol.codes import StatusCode
from daq.protocol.dictionary import Dictionary
from daq.protocol.dictionary_entries import Channel, CountType, Layout
from daq.protocol.framing import FrameDecoder, encode_frame
from daq.protocol.message import Reply
from daq.protocol.messages import encode_message
from daq.protocol.replies import HelloReply, StreamConfigReply, StreamStartReply, StreamStopReply
from daq.protocol.reports import Status, Stream
from daq.protocol.stream import SampleBlock, StreamAssembler
from daq.protocol.tick_axis import Gap, GapCause

DICTIONARY = Dictionary(
    device="test",
    firmware="1",
    parameters=(),
    channels=(
        Channel(name="current", column="current_A", unit="A", type=CountType.I16, scale=2.0**-13, offset=0.0),
        Channel(
            name="position", column="position_rad", unit="rad", type=CountType.U16, scale=1e-3, offset=32768.0
        ),
    ),
    layouts=(
        Layout(id=1, name="both", channels=("current", "position")),
        Layout(id=2, name="one", channels=("current",)),
    ),
    faults=(),
    generators=(),
)
BATCH = 5


def current_at(tick: int) -> int:
    return (tick * 7919 + 13) % 65536 - 32768


def position_at(tick: int) -> int:
    return (tick * 104729) % 65536


def frame_at(seq: int, tick0: int, *, batch: int = BATCH, divisor: int = 1, status: int = 2) -> bytes:
    """One stream frame whose samples tell the tick at which they were taken."""
    ticks = [(tick0 + k * divisor) % 2**32 for k in range(batch)]
    words = np.array([[current_at(t) % 65536, position_at(t)] for t in ticks], dtype="<u2")
    samples = words.tobytes()
    return encode_message(
        seq & 0xFF, Stream(layout=1, batch=batch, tick0=ticks[0], status=status, samples=samples)
    )


def train(count: int, *, first_tick: int = 0, first_seq: int = 0, divisor: int = 1) -> list[bytes]:
    step = BATCH * divisor
    return [frame_at(first_seq + i, first_tick + i * step, divisor=divisor) for i in range(count)]


def reply(message: Reply) -> bytes:
    return encode_message(0, message)


def hello(session: int) -> bytes:
    numbers = {field.name: 0 for field in fields(HelloReply) if field.name not in ("session", "bauds")}
    return reply(HelloReply(session=session, bauds=(), **numbers))


def ticks_of(blocks: list[SampleBlock]) -> list[int]:
    return [int(tick) for block in blocks for tick in block.ticks]


def gaps_of(blocks: list[SampleBlock]) -> list[Gap]:
    return [gap for block in blocks for gap in block.gaps]


def assert_true_samples(blocks: list[SampleBlock]) -> None:
    for block in blocks:
        if len(block.ticks):
            assert block.counts["current"].tolist() == [current_at(int(t) % 2**32) for t in block.ticks]
            assert block.counts["position"].tolist() == [position_at(int(t) % 2**32) for t in block.ticks]


def test_frames_of_one_shape_become_one_block() -> None:
    [block] = StreamAssembler(DICTIONARY).feed(train(4))
    assert block.ticks.tolist() == list(range(20))
    assert block.ticks.dtype == np.int64
    assert (block.layout, block.divisor, block.gaps) == ("both", 1, ())
    assert block.status.tolist() == [2, 2, 2, 2]
    assert block.counts["current"].dtype == np.int16
    assert block.counts["position"].dtype == np.uint16
    assert_true_samples([block])


def test_the_divisor_is_read_from_the_reply_to_stream_config() -> None:
    assembler = StreamAssembler(DICTIONARY)
    config = reply(StreamConfigReply(status=StatusCode.OK, layout=1, divisor=4, batch=BATCH))
    [block] = assembler.feed([config, *train(2, first_tick=100, divisor=4)])
    assert block.divisor == 4
    assert block.ticks.tolist() == list(range(100, 140, 4))


@given(st.lists(st.booleans(), min_size=2, max_size=60), st.integers(0, 2**32 - 1), st.integers(1, 5))
def test_every_lost_sample_is_counted(arrives: list[bool], first_tick: int, divisor: int) -> None:
    assembler = StreamAssembler(DICTIONARY)
    config = reply(StreamConfigReply(status=StatusCode.OK, layout=1, divisor=divisor, batch=BATCH))
    start = reply(StreamStartReply(status=StatusCode.OK, tick=first_tick))
    end = (first_tick + len(arrives) * BATCH * divisor) % 2**32
    stop = reply(StreamStopReply(status=StatusCode.OK, tick=end))
    frames = [
        f
        for f, ok in zip(train(len(arrives), first_tick=first_tick, divisor=divisor), arrives, strict=True)
        if ok
    ]
    blocks = assembler.feed([config, start, *frames, stop])
    assert_true_samples(blocks)
    expected = {first_tick + k * divisor for k in range(len(arrives) * BATCH)}
    missing = {g.first_tick + k * divisor for g in gaps_of(blocks) for k in range(g.missing_samples)}
    received = ticks_of(blocks)
    assert len(received) == len(set(received)) == sum(arrives) * BATCH
    assert set(received) | missing == expected
    assert not set(received) & missing
    assert {gap.cause for gap in gaps_of(blocks)} <= {GapCause.LOSS}
    assert assembler.counters.missing_samples == len(missing)


@given(
    st.lists(st.sampled_from(["pass", "lose", "twice", "corrupt"]), min_size=1, max_size=40),
    st.lists(st.integers(0), max_size=10),
)
def test_cutting_the_octets_changes_nothing_and_invents_nothing(fates: list[str], marks: list[int]) -> None:
    wire = b""
    for fate, frame in zip(fates, map(encode_frame, train(len(fates))), strict=True):
        damaged = frame[:5] + bytes([frame[5] ^ 0x55]) + frame[6:]
        wire += {"pass": frame, "lose": b"", "twice": frame + frame, "corrupt": damaged}[fate]
    edges = sorted({0, len(wire), *(mark % (len(wire) + 1) for mark in marks)})
    decoder, assembler = FrameDecoder(), StreamAssembler(DICTIONARY)
    pieces = [wire[a:b] for a, b in zip(edges, edges[1:], strict=False)]
    pieced = [block for piece in pieces for block in assembler.feed(decoder.feed(piece))]
    whole = StreamAssembler(DICTIONARY).feed(FrameDecoder().feed(wire))
    assert ticks_of(pieced) == ticks_of(whole)
    assert gaps_of(pieced) == gaps_of(whole)
    assert_true_samples(pieced)
    kept = [i for i, fate in enumerate(fates) if fate in ("pass", "twice")]
    assert ticks_of(whole) == [i * BATCH + k for i in kept for k in range(BATCH)]
    assert assembler.counters.repeated == fates.count("twice")


@given(st.lists(st.binary(min_size=2, max_size=60), max_size=20))
def test_no_messages_raise(bodies: list[bytes]) -> None:
    StreamAssembler(DICTIONARY).feed([*bodies, *(b"\x80" + body for body in bodies)])


def test_the_axis_goes_on_when_the_wire_tick_wraps() -> None:
    first = 2**32 - 7
    [block] = StreamAssembler(DICTIONARY).feed(train(3, first_tick=first))
    assert block.ticks.tolist() == list(range(first, first + 15))


def test_a_jump_of_the_tick_without_a_lost_frame_is_told_from_a_loss() -> None:
    blocks = StreamAssembler(DICTIONARY).feed([*train(2), *train(2, first_seq=2, first_tick=1010)])
    assert gaps_of(blocks) == [Gap(first_tick=10, missing_samples=1000, cause=GapCause.TICK_JUMP)]
    assert_true_samples(blocks)


def test_a_tick_that_was_set_back_does_not_turn_the_axis_back() -> None:
    blocks = StreamAssembler(DICTIONARY).feed(
        [*train(2, first_tick=1000), *train(2, first_seq=2, first_tick=3)]
    )
    assert gaps_of(blocks) == [Gap(first_tick=1010, missing_samples=0, cause=GapCause.TICK_JUMP)]
    assert ticks_of(blocks) == list(range(1000, 1020))


def test_between_a_stop_and_a_start_nothing_is_missing() -> None:
    stop = reply(StreamStopReply(status=StatusCode.OK, tick=10))
    start = reply(StreamStartReply(status=StatusCode.OK, tick=500))
    blocks = StreamAssembler(DICTIONARY).feed([*train(2), stop, start, *train(1, first_tick=500)])
    assert gaps_of(blocks) == []
    assert ticks_of(blocks) == [*range(10), *range(500, 505)]


def test_a_frame_after_the_stop_that_belongs_before_it_is_dropped() -> None:
    stop = reply(StreamStopReply(status=StatusCode.OK, tick=10))
    assembler = StreamAssembler(DICTIONARY)
    blocks = assembler.feed([*train(1), stop, frame_at(1, 5)])
    assert ticks_of(blocks) == list(range(5))
    assert [gap.missing_samples for gap in gaps_of(blocks)] == [5]
    assert assembler.counters.repeated == 1


def test_a_tick_set_back_between_stop_and_start_does_not_turn_the_axis_back() -> None:
    stop = reply(StreamStopReply(status=StatusCode.OK, tick=1010))
    start = reply(StreamStartReply(status=StatusCode.OK, tick=3))
    blocks = StreamAssembler(DICTIONARY).feed(
        [*train(2, first_tick=1000), stop, start, *train(1, first_tick=3)]
    )
    assert ticks_of(blocks) == list(range(1000, 1015))


def test_samples_lost_before_the_stop_are_counted_in_a_block_without_samples() -> None:
    stop = reply(StreamStopReply(status=StatusCode.OK, tick=17))
    *_, last = StreamAssembler(DICTIONARY).feed([*train(2), stop])
    assert last.gaps == (Gap(first_tick=10, missing_samples=7, cause=GapCause.LOSS),)
    assert (last.layout, len(last.ticks), len(last.status)) == ("both", 0, 0)


def test_a_repeated_start_reply_is_passed_over() -> None:
    start = reply(StreamStartReply(status=StatusCode.OK, tick=0))
    blocks = StreamAssembler(DICTIONARY).feed(
        [start, *train(2), start, *train(1, first_seq=2, first_tick=10)]
    )
    assert ticks_of(blocks) == list(range(15))
    assert gaps_of(blocks) == []


@pytest.mark.parametrize("tick", [40, 5000])
def test_a_reboot_in_mid_stream_leaves_a_gap_of_unknown_length(tick: int) -> None:
    start = reply(StreamStartReply(status=StatusCode.OK, tick=tick))
    blocks = StreamAssembler(DICTIONARY).feed(
        [hello(1), *train(2, first_tick=1000), hello(2), start, *train(2, first_tick=tick)]
    )
    assert gaps_of(blocks) == [Gap(first_tick=1010, missing_samples=0, cause=GapCause.REBOOT)]
    assert ticks_of(blocks) == list(range(1000, 1020))


def test_a_cable_pulled_in_mid_stream_leaves_a_gap_of_known_length() -> None:
    blocks = StreamAssembler(DICTIONARY).feed(
        [hello(1), *train(2), hello(1), *train(1, first_seq=40, first_tick=200)]
    )
    assert gaps_of(blocks) == [Gap(first_tick=10, missing_samples=190, cause=GapCause.RECONNECT)]
    assert ticks_of(blocks) == [*range(10), *range(200, 205)]


def test_a_stream_begun_anew_after_a_reconnection_tells_the_whole_gap() -> None:
    stop = reply(StreamStopReply(status=StatusCode.OK, tick=150))
    start = reply(StreamStartReply(status=StatusCode.OK, tick=200))
    blocks = StreamAssembler(DICTIONARY).feed(
        [hello(1), *train(2), hello(1), stop, start, *train(1, first_tick=200)]
    )
    assert gaps_of(blocks) == [Gap(first_tick=10, missing_samples=190, cause=GapCause.RECONNECT)]


def test_a_reboot_between_streams_leaves_no_gap_and_does_not_turn_the_axis_back() -> None:
    stop = reply(StreamStopReply(status=StatusCode.OK, tick=1010))
    start = reply(StreamStartReply(status=StatusCode.OK, tick=40))
    blocks = StreamAssembler(DICTIONARY).feed(
        [hello(1), *train(2, first_tick=1000), stop, hello(2), start, *train(2, first_tick=40)]
    )
    assert gaps_of(blocks) == []
    assert ticks_of(blocks) == list(range(1000, 1020))


def test_frames_of_equal_length_but_other_layout_are_told_apart() -> None:
    one = encode_message(1, Stream(layout=2, batch=2, tick0=1, status=0, samples=b"\x01\x00\x02\x00"))
    both = frame_at(0, 0, batch=1)
    assert len(one) == len(both)
    first, second = StreamAssembler(DICTIONARY).feed([both, one])
    assert (first.layout, second.layout) == ("both", "one")
    assert second.counts["current"].tolist() == [1, 2]


def test_a_shorter_last_frame_is_a_block_of_its_own() -> None:
    blocks = StreamAssembler(DICTIONARY).feed([*train(2), frame_at(2, 10, batch=3)])
    assert [len(block.ticks) for block in blocks] == [10, 3]
    assert_true_samples(blocks)


@pytest.mark.parametrize(
    "frame",
    [
        pytest.param(
            encode_message(0, Stream(layout=9, batch=1, tick0=0, status=0, samples=bytes(4))), id="layout"
        ),
        pytest.param(
            encode_message(0, Stream(layout=1, batch=2, tick0=0, status=0, samples=bytes(4))), id="short"
        ),
        pytest.param(
            encode_message(0, Stream(layout=1, batch=0, tick0=0, status=0, samples=b"")), id="empty"
        ),
        pytest.param(b"\x80\x00\x01\x01", id="header only"),
    ],
)
def test_a_frame_that_fits_no_layout_is_counted(frame: bytes) -> None:
    assembler = StreamAssembler(DICTIONARY)
    assert assembler.feed([frame, *train(1)])[0].ticks.tolist() == list(range(BATCH))
    assert assembler.counters.malformed == 1


def test_other_messages_are_passed_over() -> None:
    status = Status(**{field.name: 0 for field in fields(Status)})
    frames = train(2)
    blocks = StreamAssembler(DICTIONARY).feed([frames[0], encode_message(0, status), frames[1]])
    assert ticks_of(blocks) == list(range(10))
