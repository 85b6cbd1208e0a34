"""The journal keeps what was received, in its order, whatever happens to the writer."""

import base64
import errno
import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from daq.errors import JournalWriteError, RecordingError
from daq.recording.journal import Journal
from daq.recording.journal_reader import JournalContent, read_journal

Frames = Callable[[Iterable[int]], bytes]


def ticks_of(content: JournalContent) -> np.ndarray[Any, np.dtype[np.int64]]:
    return (
        np.concatenate([block.ticks for block in content.blocks]) if content.blocks else np.empty(0, np.int64)
    )


def test_journal_holds_the_received_octets_unchanged(
    tmp_path: Path, header: dict[str, Any], frames: Frames
) -> None:
    path = tmp_path / "a.journal"
    journal = Journal.create(path, header)
    start = journal.octets
    journal.append(frames(range(3)))
    assert path.read_bytes()[start:] == frames(range(3))
    journal.close("done")


def test_header_and_notes_come_back_in_order(closed_journal: Path, header: dict[str, Any]) -> None:
    content = read_journal(closed_journal)
    kinds = [note.kind for note in content.notes]
    assert content.header == header
    assert kinds == ["clock_fit", "link_statistics", "link_statistics", "event", "closed"]


def test_journal_read_while_it_is_written_is_not_closed(
    tmp_path: Path, header: dict[str, Any], frames: Frames
) -> None:
    journal = Journal.create(tmp_path / "a.journal", header)
    journal.append(frames(range(4)))
    content = read_journal(journal.path)
    journal.close("done")
    assert not content.closed
    assert len(ticks_of(content)) == 100


@pytest.mark.parametrize("cut", range(1, 160, 23))
def test_note_never_lands_inside_a_frame(
    tmp_path: Path, header: dict[str, Any], frames: Frames, cut: int
) -> None:
    journal = Journal.create(tmp_path / "a.journal", header)
    octets = frames(range(2))
    journal.append(octets[:cut])
    journal.note("event", {"code": "FAULT"})
    journal.append(octets[cut:])
    journal.close("done")
    content = read_journal(journal.path)
    assert [note.kind for note in content.notes] == ["event", "closed"]
    assert ticks_of(content).tolist() == list(range(50))


def test_notes_behind_a_frame_that_was_cut_off_are_kept(
    tmp_path: Path, header: dict[str, Any], frames: Frames
) -> None:
    journal = Journal.create(tmp_path / "a.journal", header)
    journal.append(frames(range(2))[:-10])
    journal.note("event", {"code": "FAULT"})
    journal.close("lost")
    content = read_journal(journal.path)
    assert [note.kind for note in content.notes] == ["event", "closed"]
    assert len(ticks_of(content)) == 25


def test_a_lost_link_ends_the_frame_that_it_cut_off(
    tmp_path: Path, header: dict[str, Any], frames: Frames
) -> None:
    path, octets = tmp_path / "a.journal", frames(range(3))
    size = len(octets) // 3
    journal = Journal.create(path, header)
    journal.append(octets[: size + size // 2])
    journal.note("link_lost", {"cause": "cable"})
    journal.append(octets[2 * size :])  # the new link begins with a whole frame
    journal.close("done")
    content = read_journal(path)
    assert [gap.cause.value for block in content.blocks for gap in block.gaps] == ["reconnect"]
    assert sum(block.ticks.size for block in content.blocks) == 50


def test_notes_of_many_threads_and_frames_do_not_mix(
    tmp_path: Path, header: dict[str, Any], frames: Frames
) -> None:
    journal = Journal.create(tmp_path / "a.journal", header)
    octets = frames(range(200))
    with ThreadPoolExecutor(4) as pool:
        notes = [pool.submit(journal.note, "event", {"number": k}) for k in range(300)]
        for k in range(0, len(octets), 97):
            journal.append(octets[k : k + 97])
        for note in notes:
            note.result()
    journal.close("done")
    content = read_journal(journal.path)
    assert sorted(note.data["number"] for note in content.notes[:-1]) == list(range(300))
    assert ticks_of(content).tolist() == list(range(5000))


def test_long_note_survives(tmp_path: Path, header: dict[str, Any]) -> None:
    journal = Journal.create(tmp_path / "a.journal", header)
    rng = np.random.default_rng(1)
    data = {"numbers": rng.normal(size=500).tolist()}  # far longer than a frame on the wire may be
    journal.note("table", data)
    journal.close("done")
    assert read_journal(journal.path).notes[0].data == data


def test_damaged_octets_cost_only_their_frame(tmp_path: Path, header: dict[str, Any], frames: Frames) -> None:
    journal = Journal.create(tmp_path / "a.journal", header)
    octets = bytearray(frames(range(10)))
    octets[len(octets) // 2] ^= 0x10
    journal.append(bytes(octets))
    journal.close("done")
    content = read_journal(journal.path)
    assert 200 <= len(ticks_of(content)) <= 225
    assert sum(gap.missing_samples for block in content.blocks for gap in block.gaps) in {25, 50}


def test_existing_file_is_not_overwritten(tmp_path: Path, header: dict[str, Any]) -> None:
    path = tmp_path / "a.journal"
    path.write_bytes(b"precious")
    with pytest.raises(JournalWriteError, match="File exists"):
        Journal.create(path, header)
    assert path.read_bytes() == b"precious"


def test_append_after_close_is_refused(tmp_path: Path, header: dict[str, Any], frames: Frames) -> None:
    journal = Journal.create(tmp_path / "a.journal", header)
    journal.close("done")
    journal.close("done again")
    with pytest.raises(JournalWriteError, match="is closed"):
        journal.append(frames([0]))


def test_file_that_is_no_journal_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.journal"
    path.write_bytes(b"time_s,current_A\n0,1\n")
    with pytest.raises(RecordingError, match="is no journal"):
        read_journal(path)


def test_full_disk_stops_the_journal_and_keeps_what_was_written(
    tmp_path: Path, header: dict[str, Any], frames: Frames, monkeypatch: pytest.MonkeyPatch
) -> None:
    journal = Journal.create(tmp_path / "a.journal", header)
    journal.append(frames(range(10)))
    write, room = os.write, [300]  # octets left on the medium: one frame and a half

    def write_until_full(descriptor: int, data: bytes) -> int:
        if not room[0]:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        written = write(descriptor, data[: room[0]])
        room[0] -= written
        return written

    monkeypatch.setattr(os, "write", write_until_full)
    with pytest.raises(JournalWriteError, match="No space left on device; free some space"):
        journal.append(frames(range(10, 20)))
    with pytest.raises(JournalWriteError, match="No space left on device"):
        journal.append(frames([20]))
    journal.close("disk full")
    assert len(ticks_of(read_journal(journal.path))) == 275


def test_second_writer_of_a_live_journal_is_kept_out(tmp_path: Path, header: dict[str, Any]) -> None:
    journal = Journal.create(tmp_path / "a.journal", header)
    with pytest.raises(JournalWriteError, match="File exists"):
        Journal.create(tmp_path / "a.journal", header)
    journal.close("done")


WRITER = """
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from daq.recording.journal import Journal
import base64, json, random
path, seed, payload = Path(sys.argv[1]), int(sys.argv[2]), base64.b64decode(sys.stdin.readline())
journal = Journal.create(path, json.loads(sys.stdin.readline()))
rng = random.Random(seed)
sent = 0
while sent < len(payload):
    piece = payload[sent : sent + rng.randrange(1, 700)]
    journal.append(piece)
    sent += len(piece)
    # Only what append has returned for counts as received; each report is one atomic write to the pipe.
    sys.stdout.buffer.raw.write(sent.to_bytes(8, "little"))
    if rng.random() < 0.1:
        journal.note("event", {"sent": sent})
"""


@pytest.mark.slow
def test_sigkill_at_any_moment_loses_nothing_received(
    tmp_path: Path, header: dict[str, Any], frames: Frames
) -> None:
    rng = np.random.default_rng(20)
    payload = frames(range(6000))
    received = [
        _write_until_killed(tmp_path / f"{k}.journal", k, header, payload, int(rng.integers(1, 4000)))
        for k in range(25)
    ]
    print(f"killed after {received} octets")  # noqa: T201  # shown when the test fails
    for k, octets in enumerate(received):
        whole_frames = payload[:octets].count(b"\x00")
        assert len(ticks_of(read_journal(tmp_path / f"{k}.journal"))) >= 25 * whole_frames, f"kill {k}"


def _write_until_killed(path: Path, seed: int, header: dict[str, Any], payload: bytes, reports: int) -> int:
    """Kill a writing process after it has reported so many appends; return the octets it reported."""
    with subprocess.Popen(
        [sys.executable, "-c", WRITER, str(path), str(seed)], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as child:
        if child.stdin is None or child.stdout is None:
            raise RuntimeError("no pipes")
        child.stdin.write(base64.b64encode(payload) + b"\n" + json.dumps(header).encode() + b"\n")
        child.stdin.flush()
        told = child.stdout.read(8 * reports)
        child.send_signal(signal.SIGKILL)
        told += child.stdout.read()  # what it reported between our decision and its death
    return int.from_bytes(told[-8:], "little")
