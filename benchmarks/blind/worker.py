"""A child process that handles one request after another; started anew when it dies or takes too long."""

import json
import os
import select
import subprocess
import sys
from typing import IO

from benchmarks.blind.serve import Request


class WorkerError(Exception):
    """The worker failed at a request; the message says how."""


class Worker:
    """One process running `python -m MODULE`, see `serve`.

    Args:
        module: what it runs.
        log: where its messages go.
    """

    def __init__(self, module: str, log: IO[str]) -> None:
        self._module = module
        self._log = log
        self._process: subprocess.Popen[str] | None = None

    def ask(self, request: Request, longest_s: float) -> None:
        """Send a request and wait for its end.

        Raises:
            WorkerError: it failed, died, or took longer than allowed; in the last two cases the process is gone.
        """
        process = self._running()
        if process.stdin is None or process.stdout is None:
            raise WorkerError("no pipe")
        try:
            process.stdin.write(json.dumps(dict(request)) + "\n")
            process.stdin.flush()
        except BrokenPipeError as error:
            self.stop()
            raise WorkerError("died before the request") from error
        ready, _, _ = select.select([process.stdout], [], [], longest_s)
        reply = process.stdout.readline().strip() if ready else ""
        if reply == "done":
            return
        if not reply:
            self.stop()
            raise WorkerError(f"no reply within {longest_s:g} s" if not ready else "died")
        raise WorkerError(reply)

    def stop(self) -> None:
        """End the process."""
        if self._process is not None:
            self._process.kill()
            self._process.communicate()
            self._process = None

    def _running(self) -> subprocess.Popen[str]:
        if self._process is None or self._process.poll() is not None:
            # One thread of linear algebra a process: more would fight over the cores that the workers share.
            environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
            self._process = subprocess.Popen(
                [sys.executable, "-m", self._module], env=environment, text=True,
                stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._log,
            )  # fmt: skip
        return self._process
