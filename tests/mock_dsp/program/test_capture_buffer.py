"""The capture buffer: triggers, pre-trigger part, freezing, reading."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from numpy.typing import NDArray

from daq.protocol.codes import EventCode, StatusCode, Trigger
from daq.protocol.commands import CaptureArm, CaptureConfig, CaptureRead
from daq.protocol.replies import CaptureConfigReply, CaptureReadReply

if TYPE_CHECKING:
    from tests.mock_dsp.conftest import Bench, RunMaker

DEPTH = 1365  # 4096 words of 3 channels
POSITION = 2  # channel in which the fake plant counts ticks


def config(
    trigger: Trigger, percent: int = 0, decimation: int = 1, channel: int = 0, level: int = 0
) -> CaptureConfig:
    return CaptureConfig(
        layout=1,
        decimation=decimation,
        pretrigger_percent=percent,
        trigger=trigger,
        channel=channel,
        level=level,
    )


def start(bench: Bench, command: CaptureConfig) -> None:
    reply = bench.ask(command)
    assert isinstance(reply, CaptureConfigReply) and reply.depth == DEPTH
    assert bench.status_of(CaptureArm()) == StatusCode.OK


def run_idle(bench: Bench, ticks: int) -> None:
    for _ in range(ticks // 100):
        bench.run_ticks(100)


def read_samples(bench: Bench) -> tuple[NDArray[np.uint16], int]:
    """Return the samples, shape (depth, 3), and the trigger tick."""
    words = b""
    while True:
        reply = bench.ask(CaptureRead(offset=len(words) // 2, count=96))
        assert isinstance(reply, CaptureReadReply) and reply.total
        words += reply.words
        if len(words) == 2 * reply.total:
            return np.frombuffer(words, dtype="<u2").reshape(-1, 3), reply.trigger_tick


@pytest.mark.parametrize(("percent", "before"), [(0, 0), (50, 682), (100, DEPTH - 1)])
def test_now_triggers_when_the_past_is_there(bench: Bench, percent: int, before: int) -> None:
    bench.greet()
    bench.run_ticks(17)
    start(bench, config(Trigger.NOW, percent))
    run_idle(bench, 1500)
    samples, trigger_tick = read_samples(bench)
    np.testing.assert_array_equal(samples[:, POSITION], np.arange(17, 17 + DEPTH))
    assert trigger_tick == 17 + before


def test_decimation_keeps_every_nth_tick(bench: Bench) -> None:
    bench.greet()
    start(bench, config(Trigger.NOW, decimation=3))
    run_idle(bench, 4200)
    samples, _ = read_samples(bench)
    np.testing.assert_array_equal(samples[:, POSITION], np.arange(0, 3 * DEPTH, 3))


def test_a_level_triggers_at_the_first_sample_that_rises_to_it(armed: Bench, make_run: RunMaker) -> None:
    start(armed, config(Trigger.LEVEL, percent=10, level=4096))
    armed.ask(make_run(period_ticks=1000))
    run_idle(armed, 2400)
    samples, trigger_tick = read_samples(armed)
    reference = samples[:, 0].view(np.int16)
    past = DEPTH // 10
    assert reference[past] >= 4096 > reference[past - 1]
    # sin reaches 1/2 at a twelfth of the period, which is too early; the next rise comes a period later.
    assert trigger_tick == samples[past, POSITION] == 1084


def test_a_level_of_an_unsigned_channel_is_taken_as_16_bit(bench: Bench) -> None:
    bench.greet()
    bench.plant.tick = 40_000
    start(bench, config(Trigger.LEVEL, channel=POSITION, level=40_100 - 65_536))
    run_idle(bench, 1500)
    samples, _ = read_samples(bench)
    assert samples[0, POSITION] == 40_100


def test_a_trip_freezes_what_led_to_it(armed: Bench, make_run: RunMaker) -> None:
    start(armed, config(Trigger.FAULT, percent=50))
    armed.ask(make_run())
    armed.plant.trip_tick = 900
    run_idle(armed, 1700)
    samples, trigger_tick = read_samples(armed)
    assert trigger_tick == samples[DEPTH // 2, POSITION] == 900
    assert np.all(samples[DEPTH // 2 + 1 :, 0] == 0)


def test_a_finished_capture_is_told_once_and_stays_frozen(bench: Bench) -> None:
    bench.greet()
    start(bench, config(Trigger.NOW))
    run_idle(bench, 1500)
    first, _ = read_samples(bench)
    run_idle(bench, 1500)
    again, _ = read_samples(bench)
    np.testing.assert_array_equal(first, again)
    assert bench.event_codes().count(EventCode.CAPTURE_READY) == 1


def test_reading_before_the_end_gives_nothing(bench: Bench) -> None:
    bench.greet()
    start(bench, config(Trigger.FAULT))
    reply = bench.ask(CaptureRead(offset=0, count=10))
    assert isinstance(reply, CaptureReadReply)
    assert (reply.total, reply.words, reply.trigger_tick) == (0, b"", 0)


def test_arming_without_a_configuration_is_refused(bench: Bench) -> None:
    bench.greet()
    assert bench.status_of(CaptureArm()) == StatusCode.NO_DATA


@pytest.mark.parametrize(("offset", "count"), [(0, 97), (4096, 1)])
def test_reading_too_much_or_beyond_the_end_is_refused(bench: Bench, offset: int, count: int) -> None:
    bench.greet()
    start(bench, config(Trigger.NOW))
    run_idle(bench, 1500)
    assert bench.status_of(CaptureRead(offset=offset, count=count)) == StatusCode.OUT_OF_RANGE


WRONG = {
    "layout": {"layout": 9},
    "decimation": {"decimation": 0},
    "percent": {"pretrigger_percent": 101},
    "trigger": {"trigger": 3},
    "channel": {"channel": 3},
}


@pytest.mark.parametrize("fields", WRONG.values(), ids=WRONG)
def test_an_impossible_capture_is_refused(bench: Bench, fields: dict[str, int]) -> None:
    bench.greet()
    values = {"layout": 1, "decimation": 1, "pretrigger_percent": 0, "trigger": 0, "channel": 0, "level": 0}
    assert bench.status_of(CaptureConfig(**(values | fields))) == StatusCode.OUT_OF_RANGE
