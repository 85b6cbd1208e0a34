"""Runs one analysis in a process of its own and gives what it tells, line by line."""

import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from server.services.workers import child_environment

LOG_NAME = "analysis.log"
_MODULE = "server.services.analyses.child"


@dataclass(frozen=True, slots=True, kw_only=True)
class AnalysisTask:
    """What the process is told; paths are relative to the data folder.

    Attributes:
        model: model file.
        train, test: recordings.
        out: folder for the answer.
        jobs: processes for the candidate fits.
    """

    model: str
    train: list[str]
    test: list[str]
    out: str
    jobs: int


class AnalysisProcess:
    """A running analysis.

    Args:
        task: what to do.
        data_dir: where it runs; its messages then name files as the data folder does.
    """

    def __init__(self, task: AnalysisTask, data_dir: Path) -> None:
        with (data_dir / task.out / LOG_NAME).open("w") as log:
            self._process = subprocess.Popen(
                [sys.executable, "-m", _MODULE],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=log,
                text=True,
                cwd=data_dir,
                env=child_environment(),
                start_new_session=True,  # with a process group, so that its pool can be ended with it
            )
        self._killing = threading.Lock()
        self._say(json.dumps(asdict(task)) + "\n")

    def messages(self) -> Iterator[dict[str, Any]]:  # JSON values
        """Give what it tells, until it has ended."""
        if self._process.stdout is not None:
            for line in self._process.stdout:
                yield json.loads(line)
        self.end()

    def end(self) -> None:
        """End it with its whole pool, at once; may be called from any thread, and again."""
        with self._killing:
            if self._process.returncode is None:  # not yet collected, so the number is still its own
                os.killpg(self._process.pid, signal.SIGKILL)
                self._process.wait()

    def close(self) -> None:
        """Give its pipes back; called by the thread that reads the messages, after the last."""
        self.end()
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                pipe.close()

    def _say(self, line: str) -> None:
        if self._process.stdin is not None:
            self._process.stdin.write(line)
            self._process.stdin.flush()
