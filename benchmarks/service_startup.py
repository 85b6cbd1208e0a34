"""How long the service takes from its start to `/readyz`, with many recordings in the store.

    python -m benchmarks.service_startup [RECORDINGS]        (10,000 by default)

Each recording is a folder of its own with a Parquet file and a manifest, as sessions make them, and a row in the
database. Each store is started twice: the first start may read what the file system has not in memory.
"""

import os
import re
import resource
import subprocess
import sys
import tempfile
import time
import uuid
from pathlib import Path

import httpx
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from server.storage.database import database_url, open_database
from server.storage.tables import RecordingRow

_ROWS = 250


def fill(data: Path, count: int) -> None:
    """Put recordings into a data folder: copies of one small file, and their rows."""
    table = pa.table({"time_s": np.arange(_ROWS) * 4e-4, "current_A": np.zeros(_ROWS)})
    buffer = pa.BufferOutputStream()
    pq.write_table(table, buffer)
    octets = buffer.getvalue().to_pybytes()
    database = open_database(database_url(data))
    rows = []
    for number in range(count):
        name = str(uuid.uuid4())
        folder = data / "sessions" / name
        folder.mkdir(parents=True)
        path = folder / "train.parquet"
        path.write_bytes(octets)
        (folder / "manifest.json").write_text("{}")
        rows.append(
            RecordingRow(
                id=name,
                name=f"recording {number}",
                path=str(path.relative_to(data)),
                origin="session",
                rig_id="emulated",
                samples=_ROWS,
                size_octets=len(octets),
            )
        )
    with database.write() as session:
        session.add_all(rows)
    database.close()


def start(data: Path) -> float:
    """Start a service, wait until it is ready, end it, and return how long it took, s."""
    command = [sys.executable, "-m", "server", "serve", "--port", "0", "--data", str(data)]
    begun_s = time.monotonic()
    environment = {**os.environ, "PYTHONUNBUFFERED": "1"}
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment) as process:
        try:
            assert process.stdout is not None  # noqa: S101  # opened as a pipe above
            line = next(line for line in process.stdout if "Jointscope is at" in line)
            found = re.search(r"Jointscope is at (\S+)", line)
            assert found is not None  # noqa: S101  # the line was chosen by these words
            with httpx.Client(base_url=found[1]) as client:
                while True:
                    try:
                        if client.get("/readyz").status_code == 200:
                            return time.monotonic() - begun_s
                    except httpx.TransportError:
                        pass
                    time.sleep(0.01)
        finally:
            process.terminate()


def start_twice(data: Path) -> str:
    """Start a service twice and say how long each took; processor time includes the end of the service."""
    words = []
    for _ in range(2):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        ready_s = start(data)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        cpu_s = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        words.append(f"{ready_s:.2f} s ({cpu_s:.2f} s of CPU)")
    return ", again ".join(words)


def main() -> None:
    """Fill a folder and start twice."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000
    with tempfile.TemporaryDirectory(prefix="jointscope-bench-") as name:
        empty, full = Path(name) / "empty", Path(name) / "full"
        print(f"empty store: ready after {start_twice(empty)}")
        full.mkdir()
        fill(full, count)
        print(f"{count} recordings: ready after {start_twice(full)}")


if __name__ == "__main__":
    main()
