"""The generators' vectors: right where a closed form is at hand, and met by the controller's program.

The host's own implementation is compared with the controller's elsewhere, over whole runs.
"""

import json
import math
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from daq.protocol.codes import CURRENT_COUNT_A, StatusCode
from daq.protocol.commands import Run
from mock_dsp.program.excitation import Excitation
from mock_dsp.program.waves import WaveTables

Vector = dict[str, Any]  # Any: parsed JSON
VECTORS: list[Vector] = json.loads((Path(__file__).parents[2] / "vectors" / "generators.json").read_text())[
    "vectors"
]
FIELDS = (
    "flags",
    "offset_ua",
    "period_ticks",
    "duration_ticks",
    "phase",
    "ramp_ticks",
    "p1",
    "p2",
    "p3",
    "p4",
)


def vector_named(start: str) -> Vector:
    [vector] = [vector for vector in VECTORS if vector["name"].startswith(start)]
    return vector


def tables_of(vector: Vector) -> WaveTables:
    tables = WaveTables()
    if "words" in vector:
        words = np.array(vector["words"], dtype="<i2").tobytes()
        slot = vector["run"]["p1"]
        tables.begin(slot, len(vector["words"]), zlib.crc32(words))
        tables.fill(slot, 0, words)
        assert tables.commit(slot) == StatusCode.OK
    return tables


@pytest.mark.parametrize("vector", VECTORS, ids=lambda vector: vector["name"])
def test_the_controller_plays_the_vector(vector: Vector) -> None:
    run = Run(start_tick=0, **dict.fromkeys(FIELDS, 0) | vector["run"])
    excitation = Excitation(run, tables_of(vector), 2500, 2.0)
    length = excitation.length_ticks or max(vector["ticks"]) + 1
    reference = excitation.reference(0, length)
    played = [reference[k] if 0 <= k < length else 0.0 for k in vector["ticks"]]
    counts = [math.floor(value / CURRENT_COUNT_A + 0.5) for value in played]
    # One count: where the true value lies on the edge between two counts, either rounding is right.
    assert np.abs(np.array(counts) - vector["counts"]).max() <= 1
    assert np.mean(np.array(counts) == vector["counts"]) > 0.9


def test_sine_vector_is_the_sine() -> None:
    vector = vector_named("sine, one period")
    expected = [math.floor(8192 * math.sin(math.pi * k / 4) + 0.5) for k in vector["ticks"]]
    assert vector["counts"] == expected


def test_prbs_vector_is_a_maximum_length_sequence() -> None:
    vector = vector_named("PRBS of 5 bits")
    bits = [count > 0 for count in vector["counts"][::2]]
    assert sum(bits[:31]) == 16
    assert len({tuple(bits[i : i + 5]) for i in range(27)}) == 27


def test_trapezoid_vector_reaches_its_top_after_half_a_rise() -> None:
    vector = vector_named("trapezoid, a tenth")
    assert vector["counts"][:4] == [0, 4096, 8192, 8192]
    assert sum(vector["counts"]) == 0


def test_multisine_vector_uses_the_documented_generator() -> None:
    phases = [270369, 67634689, 2647435461]
    vector = vector_named("multisine of 3 lines")
    grid = np.arange(8192) / 8192

    def total(u: Any) -> Any:  # Any: number or array alike
        return sum(np.sin(2 * np.pi * (h * u + x / 2**32)) for h, x in zip((1, 2, 3), phases, strict=True))

    peak = np.abs(total(grid)).max()
    expected = [math.floor(8192 * min(1.0, max(-1.0, total(k / 40) / peak)) + 0.5) for k in vector["ticks"]]
    assert vector["counts"] == expected
