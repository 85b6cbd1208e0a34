"""One hour at 2.5 kHz through the journal into Parquet and back: sizes and times, printed as a table.

Run `python benchmarks/recording.py [MINUTES]`. Reading is timed in a process of its own, without its imports.
The samples are those of a joint under a slow sine: reference without noise, current with 25 counts rms (3
mA), potentiometer with 3 counts rms, as the emulated rig has them.
"""

import resource
import struct
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from daq.protocol.dictionary import Dictionary, build_dictionary
from daq.protocol.dictionary_entries import Channel, CountType, Layout
from daq.protocol.framing import encode_frame
from daq.recording.finalise import finalise_journal
from daq.recording.header import make_header
from daq.recording.journal import Journal
from daq.recording.store import read_recording

TICK_HZ = 2500
BATCH = 25
CHUNK_FRAMES = 4  # what a reader thread gets from one read of the port at 1x, more or less


def main() -> None:
    """Print the table."""
    if sys.argv[1:2] == ["--read"]:
        print_reading(Path(sys.argv[2]))
        return
    minutes = float(sys.argv[1]) if len(sys.argv) > 1 else 60.0
    chunks = list(received_chunks(round(minutes * 60 * TICK_HZ / BATCH)))
    samples = len(chunks) * CHUNK_FRAMES * BATCH
    with TemporaryDirectory() as folder:
        path = Path(folder) / "hour.journal"
        append_s = timed(lambda: write_journal(path, chunks))
        journal_mb = path.stat().st_size / 1e6
        finalise_s = timed(lambda: finalise_journal(path, Path(folder)))
        recording_path = Path(folder) / "hour.parquet"
        archive_mb = (Path(folder) / "hour.journal.zst").stat().st_size / 1e6
        print(f"{samples} samples of three channels, {minutes:g} minutes at {TICK_HZ} Hz\n")
        print("| figure | value |\n|---|---|")
        print(f"| journal, as received | {journal_mb:.1f} MB |")
        print(f"| journal, time to append | {append_s:.2f} s ({append_s / (0.6 * minutes):.3f} % at 1x) |")
        print(
            f"| to Parquet and archive | {finalise_s:.2f} s, {samples / finalise_s / 1e6:.1f} M samples/s |"
        )
        print(f"| Parquet | {recording_path.stat().st_size / 1e6:.1f} MB |")
        print(f"| journal, compressed | {archive_mb:.1f} MB |")
        sys.stdout.flush()
        subprocess.run([sys.executable, __file__, "--read", str(recording_path)], check=True)


def print_reading(path: Path) -> None:
    """Print the rows about reading: the first time in this process, and the best of five."""
    measured = ("time_s", "current_ref_A", "current_A", "position_rad")
    columns_s = [timed(lambda: read_columns(path, measured)) for _ in range(5)]
    speed_s = [timed(lambda: read_columns(path, ("speed_rad_s",))) for _ in range(5)]
    print(f"| read back, four SI columns | {columns_s[0]:.2f} s first, {min(columns_s):.2f} s best of five |")
    print(
        f"| position, and the speed from it | {speed_s[0]:.2f} s first, {min(speed_s):.2f} s best of five |"
    )
    print(f"| peak memory of reading | {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3:.0f} MB |")


def read_columns(path: Path, names: Sequence[str]) -> None:
    """Open a recording and load columns."""
    recording = read_recording(path)
    for name in names:
        recording.column(name)


def received_chunks(frames: int) -> Iterator[bytes]:
    """Yield the octets of stream frames as a reader thread receives them."""
    rng = np.random.default_rng(1)
    chunk = b""
    for start in range(0, frames, 4000):
        count = min(4000, frames - start)
        for k, octets in enumerate(_frame_octets(start, count, rng)):
            chunk += octets
            if (start + k) % CHUNK_FRAMES == CHUNK_FRAMES - 1:
                yield chunk
                chunk = b""


def write_journal(path: Path, chunks: list[bytes]) -> None:
    """Append every chunk by itself, as the reader thread does."""
    channels = (
        ("current_ref", "current_ref_A", "A", CountType.I16, 2.0**-13, 0.0),
        ("current", "current_A", "A", CountType.I16, 2.0**-13, 0.0),
        ("position", "position_rad", "rad", CountType.U16, 20.0 * np.pi / 65536.0, 32768.0),
    )
    dictionary = Dictionary(
        device="benchmark",
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
    header = make_header(dictionary=build_dictionary(dictionary), tick_hz=TICK_HZ, divisor=1)
    journal = Journal.create(path, header)
    for chunk in chunks:
        journal.append(chunk)
    journal.close("done")


def timed(action: Callable[[], object]) -> float:
    """Return the seconds that an action takes."""
    start = time.perf_counter()
    action()
    return time.perf_counter() - start


def _frame_octets(first: int, count: int, rng: np.random.Generator) -> Iterator[bytes]:
    ticks = np.arange(first * BATCH, (first + count) * BATCH)
    phase = 2.0 * np.pi * ticks / TICK_HZ / 20.0
    reference = np.rint(4096.0 * np.sin(phase))
    current = reference + np.rint(rng.normal(scale=25.0, size=len(ticks)))
    position = 32768.0 - np.rint(8000.0 * np.cos(phase) + rng.normal(scale=3.0, size=len(ticks)))
    words = np.stack([reference, current, position], axis=1).astype(np.int64).astype("<u2")
    for k in range(count):
        head = struct.pack("<BBBBIH", 0x80, (first + k) % 256, 1, BATCH, (first + k) * BATCH, 2)
        yield encode_frame(head + words[k * BATCH : (k + 1) * BATCH].tobytes())


if __name__ == "__main__":
    main()
