"""A real Dask scheduler with real worker processes on 127.0.0.1, which end with the test."""

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from threading import Event

import pytest

ROOT = Path(__file__).resolve().parents[2]
# Other processes find `tests.scaling.chores` there.
sys.path.insert(0, str(ROOT))


@dataclass(slots=True)
class DaskProcesses:
    """Scheduler and workers as processes of their own."""

    folder: Path
    processes: list["subprocess.Popen[bytes]"] = field(default_factory=list)
    workers: list["subprocess.Popen[bytes]"] = field(default_factory=list)
    address: str = ""

    def start(self, workers: int) -> None:
        """Start a scheduler and its workers, without nannies: a killed worker stays dead."""
        contact = self.folder / "scheduler.json"
        self._run("scheduler", "--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(contact))
        self.address = self._read_address(contact)
        for number in range(workers):
            options = ("--nthreads", "1", "--no-nanny", "--name", str(number), "--host", "127.0.0.1")
            self.workers.append(self._run("worker", self.address, *options))

    def _read_address(self, contact: Path) -> str:
        """Wait for the file in which the scheduler says where it listens."""
        deadline_s = time.monotonic() + 60.0
        while time.monotonic() < deadline_s:
            try:
                return str(json.loads(contact.read_text())["address"])
            except (OSError, ValueError):  # not there yet, or half written
                Event().wait(0.02)
        raise TimeoutError("the Dask scheduler did not start within 60 s")

    def _run(self, kind: str, *options: str) -> "subprocess.Popen[bytes]":
        environment = {
            **os.environ,
            "PYTHONPATH": str(ROOT),
            "OPENBLAS_NUM_THREADS": "1",
            "PYTHONWARNINGS": "ignore",
        }
        command = [sys.executable, "-m", f"distributed.cli.dask_{kind}", *options, "--no-dashboard"]
        if kind == "worker":
            command += ["--local-directory", str(self.folder)]
        log = (self.folder / f"{kind}{len(self.processes)}.log").open("wb")
        with log:
            process = subprocess.Popen(command, cwd=ROOT, env=environment, stdout=log, stderr=log)
        self.processes.append(process)
        return process

    def end(self) -> None:
        """End what is still there."""
        for process in self.processes:
            process.kill()
            process.wait()


@pytest.fixture
def dask_processes(tmp_path: Path) -> Iterator[DaskProcesses]:
    """Return a scheduler with two workers."""
    pytest.importorskip("distributed", reason="the extra `cluster` is not installed")
    found = DaskProcesses(folder=tmp_path)
    try:
        found.start(2)
        yield found
    finally:
        found.end()
