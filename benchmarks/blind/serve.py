"""A worker that answers requests, one JSON object a line on standard input, one line of reply on standard output."""

import json
import sys
import traceback
from collections.abc import Callable, Mapping

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
