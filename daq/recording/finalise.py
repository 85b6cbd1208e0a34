"""From the journal to the recording: one Parquet file with counts, ticks, holes and the whole story.

The journal is kept, compressed, beside it. Every step leaves either the old state or the new one, so
finalising a journal twice, or being killed half way, does no harm: the journal itself goes last.
"""

import fcntl
import json
import shutil
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import numpy as np
import pyarrow as pa

from daq.calibration.channels import ChannelCalibration, calibrate_channels
from daq.errors import RecordingError
from daq.protocol.stream import SampleBlock
from daq.recording.derived_speed import SPEED_OF, describe_speed, speed_options
from daq.recording.gap_table import gaps_to_json, place_gaps
from daq.recording.header import dictionary_json, dictionary_of
from daq.recording.journal import CLOSED_KIND, JOURNAL_SUFFIX
from daq.recording.journal_reader import ARCHIVE_SUFFIX, JournalReader
from daq.recording.recording import GapSpan
from daq.recording.store import (
    GAP,
    ROW_GROUP_ROWS,
    SCHEMA,
    STATUS,
    TICK,
    CountsWriter,
    counts_column,
    publish,
)

LINK_STATISTICS_KIND: Final = "link_statistics"
CLOCK_FIT_KIND: Final = "clock_fit"
_OWN_KEYS: Final = frozenset({"schema", "dictionary"})


class JournalInUseError(RecordingError):
    """A journal that is still being written."""


class EmptyJournalError(RecordingError):
    """A journal without a single sample: there is nothing to make a recording of."""


def finalise_journal(path: Path, out_dir: Path) -> Path:
    """Make a recording of a journal that nobody writes any more.

    Args:
        path: the journal.
        out_dir: where `NAME.parquet` and `NAME.journal.zst` go; the journal is removed when both are there.

    Returns:
        Path of the Parquet file.

    Raises:
        EmptyJournalError: the journal has no samples; it stays where it is.
        JournalInUseError: the journal is still being written.
        RecordingError: the file is no journal.
    """
    with sole_access(path):
        out_dir.mkdir(parents=True, exist_ok=True)
        recording_path = _write_parquet(
            JournalReader(path), out_dir / f"{path.name.removesuffix(JOURNAL_SUFFIX)}.parquet"
        )
        archive_journal(path, out_dir)
    return recording_path


@contextmanager
def sole_access(path: Path) -> Iterator[None]:
    """Hold a journal's lock, so that neither its writer nor another recovery is at work on it.

    Raises:
        JournalInUseError: somebody holds it.
    """
    with path.open("rb") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            raise JournalInUseError(f"journal {path} is still being written; close it first") from error
        yield


def archive_journal(path: Path, out_dir: Path) -> Path:
    """Compress a journal into `out_dir` and remove it; returns the path of the archive."""
    archive = out_dir / (path.name + ARCHIVE_SUFFIX)
    partial_path = archive.with_name(archive.name + ".partial")
    with path.open("rb") as source, pa.CompressedOutputStream(str(partial_path), "zstd") as target:
        shutil.copyfileobj(source, target, 1 << 20)
    publish(partial_path, archive)
    path.unlink()
    return archive


def _write_parquet(reader: JournalReader, path: Path) -> Path:
    builder = _CountsBuilder(reader, path)
    try:
        for block in reader.blocks():
            builder.add(block)
        return builder.finish()
    except BaseException:  # whatever happened: no half-written file stays behind
        builder.discard()
        raise


class _CountsBuilder:
    """Gathers blocks into row groups and counts what the metadata will say."""

    def __init__(self, reader: JournalReader, path: Path) -> None:
        self._reader = reader
        self._path = path
        self._writer: CountsWriter | None = None
        self._layout = ""
        self._divisor = 1
        self._first_tick = 0
        self._pending: defaultdict[str, list[np.ndarray[Any, np.dtype[Any]]]] = defaultdict(list)
        self._pending_rows = 0
        self._rows = 0
        self._rows_other_layout = 0
        self._gaps: list[GapSpan] = []

    def add(self, block: SampleBlock) -> None:
        """Take over a block's samples and gaps."""
        n = len(block.ticks)
        if self._writer is None:
            if not n:
                return  # a gap before the first sample ever: the time axis begins after it
            self._start(block)
        elif n and block.layout != self._layout:
            self._rows_other_layout += n
            return
        gaps = place_gaps(block, self._rows, self._first_tick, self._reader.header["tick_hz"])
        self._gaps.extend(gaps)
        if not n:
            return
        flags = np.zeros(n, dtype=np.bool_)
        flags[[gap.row - self._rows for gap in gaps]] = True
        self._append(block, flags)

    def finish(self) -> Path:
        """Write what is left and the metadata."""
        if self._writer is None:
            raise EmptyJournalError(
                f"journal {self._reader.path} has no samples; there is nothing to finalise"
            )
        self._flush()
        return self._writer.finish(self._metadata())

    def discard(self) -> None:
        """Remove the unfinished file."""
        if self._writer is not None:
            self._writer.discard()

    def _start(self, block: SampleBlock) -> None:
        self._layout, self._divisor = block.layout, block.divisor
        self._first_tick = int(block.ticks[0])
        counts = {counts_column(name): values.dtype for name, values in block.counts.items()}
        fixed = {STATUS: np.dtype(np.uint16), GAP: np.dtype(np.bool_)}
        self._writer = CountsWriter(self._path, {TICK: np.dtype(np.int64), **counts, **fixed})

    def _append(self, block: SampleBlock, flags: np.ndarray[Any, np.dtype[np.bool_]]) -> None:
        n = len(block.ticks)
        self._pending[TICK].append(block.ticks)
        for name, values in block.counts.items():
            self._pending[counts_column(name)].append(values)
        self._pending[STATUS].append(np.repeat(block.status, n // len(block.status)))
        self._pending[GAP].append(flags)
        self._rows += n
        self._pending_rows += n
        if self._pending_rows >= ROW_GROUP_ROWS:
            self._flush()

    def _flush(self) -> None:
        if self._writer is not None and self._pending_rows:
            self._writer.write(self._pending)
            self._pending.clear()
            self._pending_rows = 0

    def _calibrations(self) -> tuple[ChannelCalibration, ...]:
        dictionary = dictionary_of(self._reader.header)
        sent = dictionary.layout(self._layout).channels
        calibrations = calibrate_channels(dictionary.channels, self._reader.header.get("calibration"))
        return tuple(each for each in calibrations if each.channel in sent)

    def _metadata(self) -> dict[str, Any]:
        header, calibrations = self._reader.header, self._calibrations()
        sample_time_s = self._divisor / header["tick_hz"]
        units = {"time_s": "s", **{each.column: each.unit for each in calibrations}}
        metadata: dict[str, Any] = {
            **{key: value for key, value in header.items() if key not in _OWN_KEYS},
            "schema": SCHEMA,
            "layout": self._layout,
            "divisor": self._divisor,
            "sample_time_s": sample_time_s,
            "first_tick": self._first_tick,
            "calibration": [each.to_dict() for each in calibrations],
            "controller_dictionary": json.loads(dictionary_json(header)),
            "gaps": gaps_to_json(self._gaps),
            "samples": self._sample_counts(),
            **_told_by_notes(self._reader),
            "journal": _journal_facts(self._reader),
        }
        for position in SPEED_OF.keys() & units.keys():
            metadata["speed"] = describe_speed(position, sample_time_s, speed_options(header.get("speed")))
            units[SPEED_OF[position]] = units[position] + "/s"
        return {**metadata, "units": units}

    def _sample_counts(self) -> dict[str, int]:
        lost = sum(gap.missing_samples for gap in self._gaps)
        return {
            "received": self._rows,
            "lost": lost,
            "expected": self._rows + lost,
            "other_layout": self._rows_other_layout,
        }


def _told_by_notes(reader: JournalReader) -> dict[str, Any]:
    """Sort the host's notes: the last clock fit, the link statistics as series, all others in their order."""
    closing = reader.closing
    statistics = [note.data for note in reader.notes if note.kind == LINK_STATISTICS_KIND]
    fits = [note.data for note in reader.notes if note.kind == CLOCK_FIT_KIND]
    sorted_kinds = {LINK_STATISTICS_KIND, CLOCK_FIT_KIND, CLOSED_KIND}
    return {
        "clock_fit": fits[-1] if fits else None,
        "link_statistics": {
            key: [entry.get(key) for entry in statistics] for key in (statistics or [{}])[-1]
        },
        "notes": [{**note.data, "kind": note.kind} for note in reader.notes if note.kind not in sorted_kinds],
        "ended": {"closed": True, **closing.data} if closing else {"closed": False, "reason": "left open"},
    }


def _journal_facts(reader: JournalReader) -> dict[str, Any]:
    counters = reader.counters
    return {
        "file": reader.path.name,
        "sha256": reader.sha256,
        "octets": reader.octets,
        "frames": counters.frames,
        "crc_errors": counters.crc_errors,
        "malformed": counters.malformed,
    }
