"""Start and end the emulated controller for a benchmark."""

import contextlib
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
SCENARIOS = ROOT / "config" / "scenarios"


@contextlib.contextmanager
def emulated_controller(speed: str, scenario: str = "nominal") -> Iterator[str]:
    """Run an emulated controller and give the path of its port."""
    command = [
        sys.executable,
        "-m",
        "mock_dsp",
        "--scenario",
        str(SCENARIOS / f"{scenario}.yaml"),
        "--speed",
        speed,
    ]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None  # noqa: S101  # opened as a pipe above
            yield process.stdout.readline().split(" on ", 1)[1].split()[0]
        finally:
            process.terminate()
