"""Start and end the emulated controller, a process of its own that nobody imports.

It runs in a session of its own, so that Ctrl-C on the terminal reaches the campaign first, which then brings
the drive to rest over the line before the process is ended. It ends with its parent, so that a campaign that is
killed leaves no emulator behind.
"""

import contextlib
import os
import selectors
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

from server.errors import InputError, InputLocation, RunFailedError

MODULE = "mock_dsp"
READY = "emulated controller on "
# The first start on a machine compiles the physics kernels, which takes most of a minute on a slow one.
START_TIMEOUT_S = 180.0
STOP_TIMEOUT_S = 5.0


def emulator_command(options: Sequence[str]) -> list[str]:
    """Return the command line of an emulated controller's process."""
    return [sys.executable, "-m", MODULE, *options]


@contextlib.contextmanager
def emulated_controller(scenario: Path, speed: str) -> Iterator[str]:
    """Run an emulated controller and give the port that leads to it.

    Raises:
        InputError: the scenario is refused.
        RunFailedError: it does not come up.
    """
    if not scenario.is_file():
        raise InputError("no such scenario file; see config/scenarios/", InputLocation(source=scenario))
    with tempfile.TemporaryDirectory(prefix="jointscope-") as folder:
        # A cable that is pulled and put back comes back as another pseudo-terminal; the link goes along.
        link = Path(folder) / "controller"
        options = ["--scenario", str(scenario), "--speed", speed, "--link", str(link)]
        process = subprocess.Popen(
            emulator_command([*options, "--end-with-parent", str(os.getpid())]),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        try:
            _wait_until_ready(process, scenario)
            yield str(link)
        finally:
            _stop(process)


def _wait_until_ready(process: subprocess.Popen[str], scenario: Path) -> None:
    assert process.stdout is not None and process.stderr is not None  # noqa: S101  # opened as pipes above
    deadline = time.monotonic() + START_TIMEOUT_S
    with selectors.DefaultSelector() as selector:
        selector.register(process.stdout, selectors.EVENT_READ)
        while selector.select(max(0.0, deadline - time.monotonic())):
            line = process.stdout.readline()
            if line.startswith(READY):
                return
            if not line:
                _refuse(process, scenario, process.stderr.read())
    raise RunFailedError(f"the emulated controller did not come up within {START_TIMEOUT_S:g} s")


def _refuse(process: subprocess.Popen[str], scenario: Path, complaint: str) -> None:
    code = process.wait()
    last = complaint.strip().splitlines()[-1:] or ["no message"]
    if code == 2:  # the emulator's exit code for wrong input
        raise InputError(last[0].removeprefix(f"{scenario}: "), InputLocation(source=scenario))
    raise RunFailedError(f"the emulated controller ended with code {code}: {last[0]}")


def _stop(process: subprocess.Popen[str]) -> None:
    for request in (signal.SIGTERM, signal.SIGKILL):
        if process.poll() is None:
            process.send_signal(request)
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(STOP_TIMEOUT_S)
    for pipe in (process.stdout, process.stderr):
        if pipe is not None:
            pipe.close()
