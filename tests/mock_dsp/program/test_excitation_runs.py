"""RUN, tables and set-points as they reach the fast loop."""

from __future__ import annotations

import json
import zlib
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from daq.protocol.codes import CURRENT_COUNT_A, DriveState, EventCode, Generator, RunFlag, StatusCode
from daq.protocol.commands import WaveBegin, WaveCommit, WaveData
from daq.protocol.replies import RunReply
from mock_dsp.program.excitation import Excitation
from mock_dsp.program.waves import WaveTables

if TYPE_CHECKING:
    from tests.mock_dsp.conftest import Bench, RunMaker

VECTORS = Path(__file__).parents[2] / "vectors" / "generators.json"
TICK_HZ = 2500
LIMIT_A = 2.0


def load_vectors() -> list[Any]:  # Any: free-form JSON
    vectors: list[Any] = json.loads(VECTORS.read_text())["vectors"]
    return vectors


def upload_words(words: list[int], slot: int) -> WaveTables:
    octets = np.array(words, dtype="<i2").tobytes()
    tables = WaveTables()
    tables.begin(slot, len(words), zlib.crc32(octets))
    tables.fill(slot, 0, octets)
    assert tables.commit(slot) is StatusCode.OK
    return tables


@pytest.mark.parametrize("vector", load_vectors(), ids=lambda vector: str(vector["name"]))
def test_a_generator_reproduces_its_vector_to_one_count(vector: Any, make_run: RunMaker) -> None:
    nothing = {"amplitude_ua": 0, "period_ticks": 0}
    run = make_run(**(nothing | vector["run"]))
    tables = upload_words(vector["words"], run.p1) if "words" in vector else WaveTables()
    excitation = Excitation(run, tables, TICK_HZ, LIMIT_A)
    length = excitation.length_ticks
    for k, counts in zip(vector["ticks"], vector["counts"], strict=True):
        outside = k < 0 or (length is not None and k >= length)
        reference_a = 0.0 if outside else excitation.reference(k, 1)[0]
        assert abs(np.floor(reference_a / CURRENT_COUNT_A + 0.5) - counts) <= 1, f"tick {k}"


CASES: dict[str, dict[str, int]] = {
    "sine": {"generator": 1},
    "trapezoid": {"generator": 2, "p1": 13107},
    "chirp": {"generator": 3, "period_ticks": 2000, "p1": 100_000, "p2": 50_000_000, "p3": 1, "flags": 2},
    "prbs": {"generator": 4, "period_ticks": 0, "p1": 9, "p2": 3, "p3": 17},
    "staircase": {"generator": 5, "period_ticks": 0, "p1": 5, "p2": 7, "p3": 2, "flags": 2},
    "multisine": {"generator": 6, "period_ticks": 500, "p1": 12, "p2": 3, "p3": 1, "p4": 2},
}


@pytest.mark.parametrize("fields", CASES.values(), ids=CASES)
@pytest.mark.parametrize("block", [1, 7, 250])
def test_the_size_of_blocks_does_not_change_the_reference(
    fields: dict[str, int], block: int, make_run: RunMaker
) -> None:
    run = make_run(**fields)
    whole = Excitation(run, WaveTables(), TICK_HZ, LIMIT_A).reference(0, 1500)
    pieces = Excitation(run, WaveTables(), TICK_HZ, LIMIT_A)
    parts = [pieces.reference(first, min(block, 1500 - first)) for first in range(0, 1500, block)]
    # Sums of sines over blocks of other shapes may be added in another order.
    np.testing.assert_allclose(np.concatenate(parts), whole, rtol=0.0, atol=1e-12)


REFUSED: dict[str, dict[str, int]] = {
    "unknown generator": {"generator": 8},
    "unknown flag": {"flags": 4},
    "unused field": {"p1": 1},
    "period too short": {"period_ticks": 3},
    "peak over the limit": {"amplitude_ua": 1_500_000, "offset_ua": -600_000},
    "fades longer than the run": {"duration_ticks": 99, "ramp_ticks": 50},
    "start tick in the past": {"start_tick": 2**31 + 5},
    "rise of nothing": {"generator": 2, "p1": 0},
    "rise over half a period": {"generator": 2, "p1": 32769},
    "chirp from zero": {"generator": 3, "p1": 0, "p2": 1},
    "chirp over a quarter of the tick rate": {"generator": 3, "p1": 1, "p2": 625_000_001},
    "chirp law": {"generator": 3, "p1": 1, "p2": 1, "p3": 2},
    "register length": {"generator": 4, "period_ticks": 0, "p1": 8, "p2": 1, "p3": 1},
    "register state zero": {"generator": 4, "period_ticks": 0, "p1": 5, "p2": 1, "p3": 32},
    "one level": {"generator": 5, "period_ticks": 0, "p1": 1, "p2": 1},
    "even levels from zero": {"generator": 5, "period_ticks": 0, "p1": 4, "p2": 1, "p3": 2},
    "seed zero": {"generator": 6, "p1": 1, "p2": 0, "p3": 1, "p4": 1},
    "harmonic too high": {"generator": 6, "p1": 2, "p2": 1, "p3": 25, "p4": 1},
    "step zero": {"generator": 6, "p1": 2, "p2": 1, "p3": 1, "p4": 0},
}


@pytest.mark.parametrize("fields", REFUSED.values(), ids=REFUSED)
def test_a_run_out_of_range_is_refused_and_nothing_happens(
    armed: Bench, make_run: RunMaker, fields: dict[str, int]
) -> None:
    assert armed.status_of(make_run(**fields)) == StatusCode.OUT_OF_RANGE
    assert armed.drive_state() is DriveState.ARMED


def test_an_empty_slot_cannot_be_played(armed: Bench, make_run: RunMaker) -> None:
    run = make_run(generator=Generator.TABLE, period_ticks=0, p1=1, p2=1)
    assert armed.status_of(run) == StatusCode.NO_DATA


def test_a_run_fades_in_and_out_and_returns_to_armed(armed: Bench, make_run: RunMaker) -> None:
    run = make_run(offset_ua=1_000_000, amplitude_ua=0, duration_ticks=200, ramp_ticks=50)
    start = armed.plant.tick
    assert armed.status_of(run) == StatusCode.OK
    for _ in range(4):
        armed.run_ticks(100)
    fade = np.minimum(1.0, np.minimum(np.arange(200) / 50, (200 - np.arange(200)) / 50))
    assert armed.plant.played()[start : start + 200] == pytest.approx(fade)
    assert armed.drive_state() is DriveState.ARMED
    assert armed.event_codes().count(EventCode.RUN_DONE) == 1


def test_a_run_waits_for_its_start_tick(armed: Bench, make_run: RunMaker) -> None:
    reply = armed.ask(make_run(offset_ua=500_000, amplitude_ua=0, start_tick=armed.plant.tick + 40))
    assert isinstance(reply, RunReply)
    armed.run_ticks(100)
    played = armed.plant.played()
    assert reply.start_tick == 40
    assert np.all(played[:40] == 0.0) and np.all(played[40:] == 0.5)
    started = next(event for event in armed.events if event.code == EventCode.RUN_STARTED)
    assert started.tick == 40


def test_the_centring_loop_fades_with_the_run(armed: Bench, make_run: RunMaker) -> None:
    armed.ask(make_run(flags=RunFlag.CENTRING, duration_ticks=200, ramp_ticks=100))
    assert armed.plant.parameters.centring_on
    armed.run_ticks(200)
    weight = np.concatenate(armed.plant.weight)
    assert weight[[0, 50, 100, 150]] == pytest.approx([0.0, 0.5, 1.0, 0.5])
    assert not armed.plant.parameters.centring_on


def test_a_clipped_reference_is_told_once_per_run(armed: Bench, make_run: RunMaker) -> None:
    armed.ask(make_run(flags=RunFlag.CENTRING))
    armed.plant.parameters = armed.plant.parameters.__class__(pwm_on=True, current_limit_a=0.5)
    armed.run_ticks(300)
    assert armed.event_codes().count(EventCode.LIMIT) == 1


def test_a_table_plays_its_words_as_they_are(armed: Bench, make_run: RunMaker) -> None:
    words = np.array([0, 100, -200, 16384, -16384], dtype="<i2")
    crc = zlib.crc32(words.tobytes())
    assert armed.status_of(WaveBegin(slot=1, length=5, crc=crc)) == StatusCode.OK
    assert armed.status_of(WaveData(slot=1, offset=3, words=words[3:].tobytes())) == StatusCode.OK
    assert armed.status_of(WaveCommit(slot=1)) == StatusCode.NO_DATA
    assert armed.status_of(WaveData(slot=1, offset=0, words=words[:3].tobytes())) == StatusCode.OK
    assert armed.status_of(WaveCommit(slot=1)) == StatusCode.OK
    armed.ask(make_run(generator=Generator.TABLE, period_ticks=0, p1=1, p2=2))
    armed.run_ticks(10)
    np.testing.assert_array_equal(armed.plant.played() / CURRENT_COUNT_A, np.repeat(words, 2))


@pytest.mark.parametrize(
    ("command", "status"),
    [
        (WaveBegin(slot=2, length=4, crc=0), StatusCode.OUT_OF_RANGE),
        (WaveBegin(slot=0, length=0, crc=0), StatusCode.OUT_OF_RANGE),
        (WaveBegin(slot=0, length=1025, crc=0), StatusCode.OUT_OF_RANGE),
        (WaveData(slot=0, offset=0, words=b"\0\0"), StatusCode.NO_DATA),
        (WaveData(slot=3, offset=0, words=b"\0\0"), StatusCode.OUT_OF_RANGE),
        (WaveCommit(slot=1), StatusCode.NO_DATA),
    ],
)
def test_a_wrong_upload_is_refused(
    bench: Bench, command: WaveBegin | WaveData | WaveCommit, status: StatusCode
) -> None:
    bench.greet()
    assert bench.status_of(command) == status


def test_words_beyond_the_slot_and_a_wrong_crc_are_refused(bench: Bench) -> None:
    bench.greet()
    bench.ask(WaveBegin(slot=0, length=2, crc=1))
    assert bench.status_of(WaveData(slot=0, offset=1, words=bytes(4))) == StatusCode.OUT_OF_RANGE
    assert bench.status_of(WaveData(slot=0, offset=0, words=bytes(4))) == StatusCode.OK
    assert bench.status_of(WaveCommit(slot=0)) == StatusCode.BAD_CRC


def test_a_slot_may_be_filled_anew_while_its_table_is_played(armed: Bench, make_run: RunMaker) -> None:
    octets = np.full(4, 8192, dtype="<i2").tobytes()
    armed.ask(WaveBegin(slot=0, length=4, crc=zlib.crc32(octets)))
    armed.ask(WaveData(slot=0, offset=0, words=octets))
    armed.ask(WaveCommit(slot=0))
    armed.ask(make_run(generator=Generator.TABLE, flags=RunFlag.REPEAT, period_ticks=0, p1=0, p2=1))
    armed.ask(WaveBegin(slot=0, length=4, crc=0))
    armed.run_ticks(50)
    assert np.all(armed.plant.played() == 1.0)
