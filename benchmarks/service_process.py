"""A service process with emulated rigs for a benchmark, and what the operating system says of it."""

import contextlib
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import httpx

ROOT = Path(__file__).parents[1]
RIG_FILE = ROOT / "config" / "rigs" / "emulated.yaml"
SCENARIO = ROOT / "config" / "scenarios" / "nominal.yaml"
_READY_S = 120.0


@dataclass(frozen=True, slots=True, kw_only=True)
class BenchService:
    """A running service.

    Attributes:
        process: the service itself; emulated controllers are its children.
        url: where it is.
        token: an admin's.
        rigs: ids of its rigs.
    """

    process: subprocess.Popen[str]
    url: str
    token: str
    rigs: tuple[str, ...]

    def client(self) -> httpx.Client:
        """Return a client that may do everything."""
        return httpx.Client(
            base_url=self.url, headers={"Authorization": f"Bearer {self.token}"}, timeout=60.0
        )

    def memory_octets(self) -> int:
        """Return the resident memory."""
        status = Path(f"/proc/{self.process.pid}/status").read_text()
        found = re.search(r"VmRSS:\s+(\d+) kB", status)
        return 1024 * int(found[1]) if found else 0

    def cpu_s(self) -> float:
        """Return the CPU time of the service alone, s."""
        fields = Path(f"/proc/{self.process.pid}/stat").read_text().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


@contextlib.contextmanager
def running_service(
    names: Sequence[str], *, speed: str = "1", options: Sequence[str] = ()
) -> Iterator[BenchService]:
    """Run a service with emulated rigs of these names, all connected."""
    with tempfile.TemporaryDirectory(prefix="jointscope-bench-") as base:
        folder = Path(base)
        (folder / "rigs").mkdir()
        for each in names:
            text = RIG_FILE.read_text().replace("name: emulated ", f"name: {each} ", 1)
            (folder / "rigs" / f"{each}.yaml").write_text(
                text.replace("../scenarios/nominal.yaml", str(SCENARIO))
            )
        command = [sys.executable, "-m", "server", "serve", "--port", "0", "--data", str(folder / "data")]
        command += ["--rigs", str(folder / "rigs"), "--emulate", str(SCENARIO), "--speed", speed, *options]
        environment = {**os.environ, "PYTHONUNBUFFERED": "1"}
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment) as process:
            try:
                service = _read_address(process, tuple(names))
                _wait_connected(service)
                yield service
            finally:
                process.terminate()


def _read_address(process: subprocess.Popen[str], rigs: tuple[str, ...]) -> BenchService:
    url = token = ""
    assert process.stdout is not None  # noqa: S101  # opened as a pipe above
    for line in process.stdout:
        if found := re.search(r"Jointscope is at (\S+)", line):
            url = found[1]
        if found := re.search(r"shown this once: (\S+)", line):
            token = found[1]
        if url and token:
            return BenchService(process=process, url=url, token=token, rigs=rigs)
    raise RuntimeError(f"the service ended with {process.wait()}")


def _wait_connected(service: BenchService) -> None:
    deadline_s = time.monotonic() + _READY_S
    with service.client() as client:
        while time.monotonic() < deadline_s:
            rigs = client.get("/api/v1/rigs").json()["items"]
            if all(rig["connection"] == "connected" for rig in rigs):
                return
            time.sleep(0.2)
    raise RuntimeError(f"not all rigs were connected within {_READY_S:g} s")
