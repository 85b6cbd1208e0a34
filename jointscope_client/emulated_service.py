"""Runs a service with an emulated controller as processes of this one, for tests of whatever uses a rig."""

import contextlib
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from jointscope_client.client import Client
from jointscope_client.errors import ClientError, ProblemError
from jointscope_client.lease import Lease
from jointscope_client.records import Rig

FILES = Path(__file__).parent / "emulated"
NOMINAL = FILES / "scenarios" / "nominal.yaml"
# The first start on a machine compiles the emulator's kernels, which takes most of a minute on a slow one.
PATIENCE_S = 180.0
_STOP_S = 20.0
_LOOK_EVERY_S = 0.02
_READY = re.compile(r"Jointscope is at (\S+)")
_TOKEN = re.compile(r"shown this once: (\S+)")
_PORT = re.compile(r"emulated controller on (\S+)")


@dataclass(frozen=True, slots=True, kw_only=True)
class EmulatedRig:
    """A rig behind a service of its own.

    Attributes:
        id: the rig's id in the service.
        client: speaks to the service, and may do everything.
        url: address of the service.
        token: of an admin.
    """

    id: str
    client: Client
    url: str
    token: str = field(repr=False)

    def lease(self, *, ttl_s: float = 10.0) -> Lease:
        """Return the rig's lease, to be held by `with`."""
        return self.client.lease(self.id, ttl_s=ttl_s)

    def state(self) -> Rig:
        """Return the rig's state."""
        return self.client.rigs.get(self.id)

    def rest(self) -> None:
        """Bring the rig to rest with nothing latched, whoever holds it."""
        self.client.rigs.connect(self.id)
        with self.client.lease(self.id, take_over=True) as lease:
            # The state shown may be older than the last command (an e-stop): clear unasked, and see it gone.
            with contextlib.suppress(ProblemError):
                lease.clear_fault()
            _look_until(self._has_no_fault, "a state without faults")

    def _has_no_fault(self) -> bool:
        rig = self.state()
        known = rig.drive_state not in (None, "fault", "safe_timeout")
        return known and not rig.raw["drive"]["faults"]


@contextlib.contextmanager
def emulated_service(folder: Path, scenario: Path = NOMINAL, speed: str = "max") -> Iterator[EmulatedRig]:
    """Run a service with one emulated rig, connected.

    Args:
        folder: for its data and its log.
        scenario: what the emulated controller is like.
        speed: `max`, or a factor of real time.

    Raises:
        ClientError: it does not come up; the message ends with what it said.
    """
    command = ["server", "serve", "--port", "0", "--data", str(folder / "data"), "--speed", speed]
    command += ["--rigs", str(FILES / "rigs"), "--emulate", str(scenario)]
    with _process(command, folder / "service.log") as said:
        url, token = _wait_for(said, _READY), _wait_for(said, _TOKEN)
        with Client(url, token) as client:
            rig = EmulatedRig(id=client.rigs.all()[0].id, client=client, url=url, token=token)
            client.rigs.connect(rig.id)
            _look_until(lambda: rig.state().drive_state is not None, "the rig's first state")
            yield rig


@contextlib.contextmanager
def emulated_controller(folder: Path, scenario: Path = NOMINAL, speed: str = "max") -> Iterator[str]:
    """Run an emulated controller alone and give its serial port.

    Raises:
        ClientError: it does not come up.
    """
    command = [
        "mock_dsp",
        "--scenario",
        str(scenario),
        "--speed",
        speed,
        "--end-with-parent",
        str(os.getpid()),
    ]
    with _process(command, folder / "controller.log") as said:
        yield _wait_for(said, _PORT)


@contextlib.contextmanager
def _process(command: list[str], log: Path) -> Iterator[Callable[[], str]]:
    """Run a module as a process and give a function that returns what it has said; "" after its end is an error."""
    with log.open("w") as file:
        process = subprocess.Popen(
            [sys.executable, "-m", *command],
            stdin=subprocess.DEVNULL,
            stdout=file,
            stderr=subprocess.STDOUT,
            env={**os.environ, "PYTHONUNBUFFERED": "1"},
        )

    def said() -> str:
        code, text = process.poll(), log.read_text()
        if code is not None:
            raise ClientError(f"{' '.join(command[:2])} ended with code {code}: {text[-2000:]}")
        return text

    try:
        yield said
    finally:
        for request in (signal.SIGTERM, signal.SIGKILL):
            if process.poll() is None:
                process.send_signal(request)
                with contextlib.suppress(subprocess.TimeoutExpired):
                    process.wait(_STOP_S)


def _wait_for(said: Callable[[], str], what: re.Pattern[str]) -> str:
    found: list[str] = []

    def look() -> bool:
        match = what.search(said())
        found.extend([] if match is None else [match[1]])
        return bool(found)

    _look_until(look, f"{what.pattern!r} in the log")
    return found[0]


def _look_until(look: Callable[[], bool], what: str) -> None:
    deadline_s = time.monotonic() + PATIENCE_S
    while not look():
        if time.monotonic() > deadline_s:
            raise ClientError(f"{what} did not come within {PATIENCE_S:g} s")
        time.sleep(_LOOK_EVERY_S)
