"""Finalising: the journal's numbers, holes and story arrive in the Parquet file, whoever left it."""

import hashlib
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest

from daq.calibration.channels import calibrate_channels, counts_to_si
from daq.errors import RecordingError
from daq.protocol.framing import FrameDecoder, encode_frame
from daq.protocol.messages import encode_message
from daq.protocol.replies import StreamStopReply
from daq.protocol.stream import StreamAssembler
from daq.recording.finalise import EmptyJournalError, JournalInUseError, finalise_journal
from daq.recording.header import dictionary_of, make_header
from daq.recording.journal import Journal
from daq.recording.journal_reader import read_journal
from daq.recording.recovery import RecoveryOutcome, recover_journals
from daq.recording.store import read_counts, read_recording

Frames = Callable[[Iterable[int]], bytes]


def test_counts_and_si_values_are_those_that_were_seen_live(
    closed_journal: Path, header: dict[str, Any], frames: Frames, tmp_path: Path
) -> None:
    live = StreamAssembler(dictionary_of(header))
    decoder = FrameDecoder()
    octets = frames(range(50)) + frames(range(54, 200))
    pieces = [octets[k : k + 1013] for k in range(0, len(octets), 1013)]
    blocks = [block for piece in pieces for block in live.feed(decoder.feed(piece))]
    path = finalise_journal(closed_journal, tmp_path)
    recording = read_recording(path)
    for calibration in calibrate_channels(dictionary_of(header).channels):
        seen = np.concatenate([block.counts[calibration.channel] for block in blocks])
        stored = read_counts(path, f"{calibration.channel}_counts")
        assert stored.dtype == seen.dtype
        assert np.array_equal(stored, seen)
        assert np.array_equal(recording.column(calibration.column), counts_to_si(seen, calibration))
    assert np.array_equal(read_counts(path, "tick"), np.concatenate([block.ticks for block in blocks]))


def test_compressed_journal_replays_to_the_same_blocks(closed_journal: Path, tmp_path: Path) -> None:
    before = read_journal(closed_journal)
    finalise_journal(closed_journal, tmp_path)
    after = read_journal(tmp_path / "run.journal.zst")
    assert after.header == before.header
    assert after.notes == before.notes
    for one, other in zip(before.blocks, after.blocks, strict=True):
        assert np.array_equal(one.ticks, other.ticks)
        assert np.array_equal(one.counts["position"], other.counts["position"])
        assert one.gaps == other.gaps


def test_si_columns_have_contract_names_units_and_values(closed_journal: Path, tmp_path: Path) -> None:
    recording = read_recording(finalise_journal(closed_journal, tmp_path))
    assert dict(recording.units) == {
        "time_s": "s",
        "current_ref_A": "A",
        "current_A": "A",
        "position_rad": "rad",
        "speed_rad_s": "rad/s",
    }
    ticks = np.concatenate([np.arange(1250), np.arange(1350, 5000)])
    assert np.array_equal(recording.time_s, ticks / 2500)
    assert np.array_equal(recording.column("current_ref_A"), (ticks % 1000 - 500) / 8192)


def test_hole_stands_in_time_axis_flags_table_and_counts(closed_journal: Path, tmp_path: Path) -> None:
    path = finalise_journal(closed_journal, tmp_path)
    recording = read_recording(path)
    (gap,) = recording.gaps
    assert (gap.row, gap.start_s, gap.missing_samples, gap.cause) == (1250, 0.5, 100, "loss")
    assert np.flatnonzero(recording.gap).tolist() == [1250]
    assert np.flatnonzero(read_counts(path, "gap")).tolist() == [1250]
    assert recording.segments() == (slice(0, 1250), slice(1250, 4900))
    assert recording.metadata["samples"] == {
        "received": 4900,
        "lost": 100,
        "expected": 5000,
        "other_layout": 0,
    }


def test_counter_set_back_is_a_gap_of_unknown_length_and_time_goes_on(
    tmp_path: Path, header: dict[str, Any], frames: Frames
) -> None:
    journal = Journal.create(tmp_path / "a.journal", header)
    journal.append(frames(range(200, 210)) + frames(range(20, 30)))
    journal.close("done")
    recording = read_recording(finalise_journal(journal.path, tmp_path))
    (gap,) = recording.gaps
    assert (gap.row, gap.missing_samples, gap.cause) == (250, 0, "tick_jump")
    assert recording.time_s.tolist() == (np.arange(500) / 2500).tolist()
    assert recording.segments() == (slice(0, 250), slice(250, 500))


def test_samples_lost_at_the_end_stand_in_the_table_behind_the_last_row(
    tmp_path: Path, header: dict[str, Any], frames: Frames
) -> None:
    journal = Journal.create(tmp_path / "a.journal", header)
    journal.append(frames(range(4)))
    journal.append(encode_frame(encode_message(4, StreamStopReply(status=0, tick=150))))
    journal.close("done")
    recording = read_recording(finalise_journal(journal.path, tmp_path))
    assert [(gap.row, gap.missing_samples) for gap in recording.gaps] == [(100, 50)]
    assert recording.metadata["samples"]["expected"] == 150
    assert recording.segments() == (slice(0, 100),)


def test_divisor_of_the_header_spaces_the_samples(
    tmp_path: Path, dictionary_octets: bytes, frames: Frames
) -> None:
    header = make_header(dictionary=dictionary_octets, tick_hz=2500, divisor=2)
    journal = Journal.create(tmp_path / "a.journal", header)
    journal.append(frames([0, 2, 4]))  # 25 samples each, 50 ticks apart
    journal.close("done")
    recording = read_recording(finalise_journal(journal.path, tmp_path))
    assert not recording.gaps
    assert recording.sample_time_s == 0.0008
    assert recording.time_s.tolist() == (np.arange(75) * 2 / 2500).tolist()


def test_speed_is_derived_run_by_run_without_delay(closed_journal: Path, tmp_path: Path) -> None:
    recording = read_recording(finalise_journal(closed_journal, tmp_path))
    # 3000 counts at 1 rad/s; quantisation of 1/sqrt(12) count times the noise gain of 3.6/s is 1e-3 rad/s.
    amplitude = 3000 * 20 * np.pi / 65536
    error = recording.column("speed_rad_s") - amplitude * np.cos(recording.time_s)
    assert np.sqrt(np.mean(error**2)) < 2e-3
    # Each end of a run has half of the neighbours, and thus several times the noise.
    assert np.abs(error).max() < 0.02
    assert recording.metadata["speed"]["delay_s"] == 0.0
    assert recording.metadata["speed"]["bandwidth_hz"] == pytest.approx(10.0)


def test_metadata_tell_the_whole_story(closed_journal: Path, tmp_path: Path) -> None:
    digest = hashlib.sha256(closed_journal.read_bytes()).hexdigest()
    metadata = read_recording(finalise_journal(closed_journal, tmp_path)).metadata
    assert metadata["journal"]["sha256"] == digest
    assert metadata["operator"] == "Ada"
    assert metadata["excitation"]["seed"] == 7
    assert metadata["controller_dictionary"]["device"] == "fake"
    assert metadata["clock_fit"] == {"slope_ns_per_tick": 400001.5}
    assert metadata["link_statistics"] == {"t_s": [1.0, 2.0], "crc_errors": [0, 4]}
    assert metadata["notes"] == [{"kind": "event", "code": "RUN_DONE"}]
    assert metadata["ended"] == {"closed": True, "reason": "done", "duration_s": 2.0}
    assert set(metadata["software"]) == {"python", "jointscope", "numpy", "pyarrow"}
    assert [each["channel"] for each in metadata["calibration"]] == ["current_ref", "current", "position"]


def test_measured_calibration_replaces_the_dictionarys(
    tmp_path: Path, header: dict[str, Any], frames: Frames
) -> None:
    header["calibration"] = {"current": {"offset_counts": 12.0, "source": "Hall zero of 3 May"}}
    journal = Journal.create(tmp_path / "a.journal", header)
    journal.append(frames(range(4)))
    journal.close("done")
    recording = read_recording(finalise_journal(journal.path, tmp_path))
    assert recording.column("current_A")[0] == -12.0 / 8192
    assert recording.metadata["calibration"][1]["source"] == "Hall zero of 3 May"


@pytest.mark.parametrize(
    ("details", "message"),
    [
        ({"calibration": {"curent": {"scale": 1.0}}}, "unknown channel 'curent'"),
        (
            {"speed": {"method": "guess", "bandwidth_hz": 10.0}},
            "'guess' is unknown; there are kalman",
        ),
        ({"speed": {"method": "kalman", "bandwidth_hz": 1e4}}, "10000 Hz must lie between 0.5 and 250 Hz"),
    ],
)
def test_impossible_header_is_refused_before_the_run(
    dictionary_octets: bytes, details: dict[str, Any], message: str
) -> None:
    with pytest.raises(RecordingError, match=message):
        make_header(dictionary=dictionary_octets, tick_hz=2500, divisor=1, details=details)


def test_journal_is_gone_only_when_recording_and_archive_are_there(
    closed_journal: Path, tmp_path: Path
) -> None:
    octets = closed_journal.read_bytes()
    finalise_journal(closed_journal, tmp_path / "out")
    assert not closed_journal.exists()
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["run.journal.zst", "run.parquet"]
    with pa.input_stream(str(tmp_path / "out" / "run.journal.zst")) as archive:
        assert archive.read() == octets


def test_killed_finalising_is_repeated_from_the_start(closed_journal: Path, tmp_path: Path) -> None:
    (tmp_path / "run.parquet.partial").write_bytes(b"half a file")
    (tmp_path / "run.journal.zst.partial").write_bytes(b"half an archive")
    assert read_recording(finalise_journal(closed_journal, tmp_path)).n == 4900
    assert not list(tmp_path.glob("*.partial"))


def test_live_journal_is_not_finalised(tmp_path: Path, header: dict[str, Any], frames: Frames) -> None:
    journal = Journal.create(tmp_path / "a.journal", header)
    journal.append(frames(range(3)))
    with pytest.raises(JournalInUseError, match="still being written"):
        finalise_journal(journal.path, tmp_path)
    (report,) = recover_journals(tmp_path)
    journal.close("done")
    assert report.outcome is RecoveryOutcome.IN_USE
    assert journal.path.exists()


def test_journal_left_open_is_recovered_with_all_whole_frames(
    tmp_path: Path, header: dict[str, Any], frames: Frames
) -> None:
    journal = Journal.create(tmp_path / "a.journal", header)
    journal.append(frames(range(8))[:-40])
    left_open = journal.path.read_bytes()
    journal.close("done")
    journal.path.write_bytes(left_open)  # as a killed process would have left it
    (report,) = recover_journals(tmp_path)
    assert report.outcome is RecoveryOutcome.RECOVERED
    assert report.recording is not None
    recording = read_recording(report.recording)
    assert recording.n == 175
    assert recording.metadata["ended"] == {"closed": False, "reason": "left open"}


def test_journal_without_samples_is_archived(tmp_path: Path, header: dict[str, Any]) -> None:
    journal = Journal.create(tmp_path / "a.journal", header)
    journal.close("aborted")
    with pytest.raises(EmptyJournalError, match="has no samples"):
        finalise_journal(journal.path, tmp_path)
    (report,) = recover_journals(tmp_path)
    assert report.outcome is RecoveryOutcome.EMPTY
    assert [path.name for path in tmp_path.iterdir()] == ["a.journal.zst"]


def test_unreadable_journal_stays_where_it_is(tmp_path: Path) -> None:
    path = tmp_path / "a.journal"
    path.write_bytes(b"\x05\x01")
    (report,) = recover_journals(tmp_path)
    assert report.outcome is RecoveryOutcome.UNREADABLE
    assert "cut off within its header" in report.detail
    assert path.exists()
