"""A controller's octets without a controller: a dictionary, and stream frames that follow from the tick."""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from daq.protocol.dictionary import Dictionary, build_dictionary
from daq.protocol.dictionary_entries import Channel, CountType, Layout
from daq.protocol.framing import encode_frame
from daq.protocol.messages import encode_message
from daq.protocol.reports import Stream
from daq.recording.header import make_header
from daq.recording.journal import Journal

BATCH = 25
Frames = Callable[[Iterable[int]], bytes]


def counts_at(ticks: np.ndarray[Any, np.dtype[np.int64]]) -> np.ndarray[Any, np.dtype[np.int64]]:
    """Reference, current and position counts that the fake controller takes at these ticks, shape (n, 3)."""
    position = 32768 + np.rint(3000.0 * np.sin(ticks / 2500.0)).astype(np.int64)
    return np.stack([ticks % 1000 - 500, -(ticks % 777), position], axis=1)


@pytest.fixture
def dictionary_octets() -> bytes:
    """A dictionary with the three channels of the layout `control`."""
    channels = (
        ("current_ref", "current_ref_A", "A", CountType.I16, 2.0**-13, 0.0),
        ("current", "current_A", "A", CountType.I16, 2.0**-13, 0.0),
        ("position", "position_rad", "rad", CountType.U16, 20.0 * np.pi / 65536.0, 32768.0),
    )
    return build_dictionary(
        Dictionary(
            device="fake",
            firmware="0",
            parameters=(),
            channels=tuple(
                Channel(name=name, column=column, unit=unit, type=kind, scale=scale, offset=offset)
                for name, column, unit, kind, scale, offset in channels
            ),
            layouts=(Layout(id=1, name="control", channels=("current_ref", "current", "position")),),
            faults=(),
            generators=(),
        )
    )


@pytest.fixture
def header(dictionary_octets: bytes) -> dict[str, Any]:
    """A journal header as a run would write it."""
    details = {"operator": "Ada", "excitation": {"kind": "prbs", "seed": 7}}
    return make_header(dictionary=dictionary_octets, tick_hz=2500, divisor=1, details=details)


@pytest.fixture
def frames() -> Frames:
    """Octets of the stream frames with these numbers; frame k begins at tick 25 k."""

    def make(numbers: Iterable[int]) -> bytes:
        return b"".join(encode_frame(_stream_message(k)) for k in numbers)

    return make


@pytest.fixture
def closed_journal(tmp_path: Path, header: dict[str, Any], frames: Frames) -> Path:
    """A journal of 200 frames of which 50 to 53 were lost, with notes, closed."""
    path = tmp_path / "run.journal"
    journal = Journal.create(path, header)
    journal.append(frames(range(50)))
    journal.note("clock_fit", {"slope_ns_per_tick": 400001.5})
    journal.note("link_statistics", {"t_s": 1.0, "crc_errors": 0})
    journal.append(frames(range(54, 200)))
    journal.note("link_statistics", {"t_s": 2.0, "crc_errors": 4})
    journal.note("event", {"code": "RUN_DONE"})
    journal.close("done", duration_s=2.0)
    return path


def _stream_message(number: int) -> bytes:
    ticks = np.arange(BATCH * number, BATCH * (number + 1), dtype=np.int64)
    words = counts_at(ticks).astype(np.uint16)  # modulo 2^16: the two's complement of the negative ones
    message = Stream(
        layout=1, batch=BATCH, tick0=BATCH * number, status=2, samples=words.astype("<u2").tobytes()
    )
    return encode_message(number % 256, message)
