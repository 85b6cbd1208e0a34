"""One discrepancy analysis as a process: `python -m server.services.analyses.child`, started by `jobs.py`.

The request is one line of JSON on stdin; what happens is told in lines of JSON on stdout: {"tell": TEXT} on the way,
then {"done": true}, or {"error": TEXT, "input": whether the request is to blame}. Stdin stays open as long as the
service lives: its end ends this process, and with it the processes of its pool.
"""

import json
import os
import sys
import threading
import traceback
from pathlib import Path

from server.errors import InputError
from server.services.discrepancy import GapRequest, run_gap_analysis

_NICENESS = 10  # rigs that stream come first


def main() -> None:
    """Read the request, analyse, tell."""
    os.nice(_NICENESS)
    asked = json.loads(sys.stdin.readline())
    threading.Thread(target=_end_with_service, daemon=True).start()
    request = GapRequest(
        model=Path(asked["model"]),
        train=tuple(Path(each) for each in asked["train"]),
        test=tuple(Path(each) for each in asked["test"]),
        jobs=asked["jobs"],
    )
    try:
        run_gap_analysis(request, Path(asked["out"]), lambda line: _say(tell=line))
    except InputError as error:
        _say(error=str(error), input=True)
    except Exception as error:  # noqa: BLE001  # outermost: the service is told, the log has the traceback
        traceback.print_exc()
        _say(error=f"{type(error).__name__}: {error}", input=False)
    else:
        _say(done=True)


def _say(**message: object) -> None:
    sys.stdout.write(json.dumps(message) + "\n")
    sys.stdout.flush()


def _end_with_service() -> None:
    sys.stdin.read()
    os._exit(1)


if __name__ == "__main__":
    main()
