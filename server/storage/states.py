"""States of everything that runs: sessions, campaigns and their items, analyses."""

from enum import StrEnum


class JobState(StrEnum):
    """Where a piece of work stands; the values are stored and appear in the API."""

    CREATED = "created"
    QUEUED = "queued"
    STARTING = "starting"
    RUNNING = "running"
    PAUSING = "pausing"
    PAUSED = "paused"
    STOPPING = "stopping"
    ABORTING = "aborting"
    DONE = "done"
    STOPPED = "stopped"
    ABORTED = "aborted"
    TRIPPED = "tripped"
    REFUSED = "refused"
    FAILED = "failed"
    CANCELLED = "cancelled"
    INTERRUPTED = "interrupted"


UNDER_WAY = frozenset(
    {
        JobState.STARTING,
        JobState.RUNNING,
        JobState.PAUSING,
        JobState.PAUSED,
        JobState.STOPPING,
        JobState.ABORTING,
    }
)
"""States that cannot outlive the process: the next start turns them into `interrupted`."""
