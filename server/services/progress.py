"""What a service tells while it works: the command line renders it, others may store or stream it."""

from typing import Protocol


class ProgressListener(Protocol):
    """Told what a run is doing; called from the thread that runs the steps, and must return quickly."""

    def step_started(self, index: int, count: int, title: str) -> None:
        """Begin a step; `index` counts from 0, `count` is the number of steps."""

    def step_progress(self, done_s: float, total_s: float, detail: str) -> None:
        """Report how far the step is, in seconds of the rig's own time."""

    def step_ended(self, title: str, ended: str, detail: str) -> None:
        """End a step; `ended` is a value of `server.services.manifest.Ended`."""

    def note(self, text: str) -> None:
        """Say something that the operator should know."""


class SilentListener:
    """Listens and says nothing."""

    def step_started(self, index: int, count: int, title: str) -> None:
        """Ignore it."""

    def step_progress(self, done_s: float, total_s: float, detail: str) -> None:
        """Ignore it."""

    def step_ended(self, title: str, ended: str, detail: str) -> None:
        """Ignore it."""

    def note(self, text: str) -> None:
        """Ignore it."""
