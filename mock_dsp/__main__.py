"""Command line of the emulated controller, `python -m mock_dsp`; see `--help`.

Prints one line when the port is there, and ends cleanly on SIGTERM or SIGINT; with `--end-with-parent` also when
the process that started it is gone, which SIGKILL leaves no time to tell. Exit codes: 0 ended so, 2 wrong input
(one line on stderr).
"""

import argparse
import math
import os
import signal
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from types import FrameType

from mock_dsp.program.baud import START_BAUD
from mock_dsp.scenario.schema import Scenario, ScenarioError, read_scenario
from mock_dsp.scenario.sealed import draw_sealed, write_answer
from mock_dsp.wire.assembly import EmulationOptions, build_emulation
from mock_dsp.wire.pty import PtyPort

_MAX_SPEED_FACTOR = 1000.0
_SESSION_MASK = 0x3FFF_FFFF


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the emulated controller until a signal ends it; return the exit code."""
    options = _parse_arguments(arguments)
    try:
        scenario = _make_scenario(options)
        port = PtyPort(options.link, START_BAUD)
    except FileExistsError as error:
        sys.stderr.write(f"{error.filename} exists already; choose another path\n")
        return 2
    except (ScenarioError, OSError) as error:
        sys.stderr.write(f"{error}\n")
        return 2
    stop = _StopSignal(options.end_with_parent)
    try:
        emulation = build_emulation(
            scenario,
            port,
            EmulationOptions(
                speed=options.speed,
                first_session=int(time.time()) & _SESSION_MASK,
                clock_ns=time.monotonic_ns,
            ),
        )
        emulation.run(stop.requested, lambda: _announce(port, options.link))
    finally:
        port.close()
    return 0


class _StopSignal:
    """Tells the loop, between two passes, that SIGTERM or SIGINT came or that the parent has died.

    Args:
        parent: process to end with, None to outlive it.
    """

    def __init__(self, parent: int | None) -> None:
        self._came = False
        self._parent = parent
        for number in (signal.SIGTERM, signal.SIGINT):
            signal.signal(number, self._take)

    def requested(self) -> bool:
        """Return whether the process should end."""
        return self._came or self._parent not in (None, os.getppid())

    def _take(self, number: int, frame: FrameType | None) -> None:
        self._came = True


def _parse_arguments(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m mock_dsp", description="An emulated controller with its rig on a pseudo-terminal."
    )
    parser.add_argument("--scenario", type=Path, metavar="FILE", help="scenario file (YAML)")
    parser.add_argument("--link", type=Path, metavar="PATH", help="symbolic link to make to the port")
    parser.add_argument("--speed", type=_parse_speed, default=1.0, help="1 (default), a factor, or max")
    parser.add_argument("--sealed", type=int, metavar="SEED", help="draw hidden effects from this seed")
    parser.add_argument("--answer", type=Path, metavar="FILE", help="where to write what was drawn")
    parser.add_argument(
        "--end-with-parent", type=int, metavar="PID", help="end when this process, which started it, is gone"
    )
    options = parser.parse_args(arguments)
    if options.scenario is None and options.sealed is None:
        parser.error("give --scenario FILE, or --sealed SEED --answer FILE")
    if (options.sealed is None) != (options.answer is None):
        parser.error("--sealed SEED and --answer FILE belong together")
    return options


def _parse_speed(text: str) -> float:
    if text == "max":
        return math.inf
    try:
        speed = float(text)
    except ValueError:
        speed = math.nan
    if not 0.0 < speed <= _MAX_SPEED_FACTOR:
        raise argparse.ArgumentTypeError(f"{text!r} must be a factor in (0, {_MAX_SPEED_FACTOR:g}], or max")
    return speed


def _make_scenario(options: argparse.Namespace) -> Scenario:
    """Read the scenario; with a seed, draw its effects and write them to the answer file only."""
    base = read_scenario(options.scenario) if options.scenario is not None else None
    if options.sealed is None and base is not None:
        return base
    sealed, answer = draw_sealed(options.sealed)
    write_answer(answer, options.answer)
    return sealed if base is None else sealed.model_copy(update={"rig": base.rig, "faults": base.faults})


def _announce(port: PtyPort, link: Path | None) -> None:
    """Tell where the port is, again whenever it comes back under another name."""
    where = f" (link {link})" if link is not None else ""
    sys.stdout.write(f"emulated controller on {port.name}{where}\n")
    sys.stdout.flush()


if __name__ == "__main__":
    sys.exit(main())
