"""A worker that answers requests, one JSON object a line on standard input, one line of reply on standard output."""

import json
import sys
import traceback
from collections.abc import Callable, Mapping
from pathlib import Path

Request = Mapping[str, str]


def serve(handle: Callable[[Request], None]) -> None:
    """Handle requests until the input ends; a request that fails is answered by its error in one line."""
    for line in sys.stdin:
        request: Request = json.loads(line)
        try:
            handle(request)
            reply = "done"
        except Exception as error:  # noqa: BLE001  # outermost loop: the runner counts the failure and goes on
            traceback.print_exc()
            reply = f"failed: {type(error).__name__}: {error}".replace("\n", " ")
        sys.stdout.write(reply + "\n")
        sys.stdout.flush()


class CountingSolver:
    """Handles requests to solve a case and counts them: the first of a process pays for loading compiled code.

    Args:
        solve: takes the question's folder, the verdict's path, and how many cases this process has solved before.
    """

    def __init__(self, solve: Callable[[Path, Path, int], None]) -> None:
        self._solve = solve
        self._done = 0

    def __call__(self, request: Request) -> None:
        """Solve the case that a request describes."""
        self._done += 1
        self._solve(Path(request["question"]), Path(request["verdict"]), self._done - 1)
