"""The one state machine of sessions and campaigns: a literal table, and what may happen in each state.

`docs/jobs.md` draws its diagram from this table (`draw_diagram`); a test holds them together. What is not in the table
is refused.
"""

from enum import StrEnum

from server.storage.states import JobState as JobState  # the API has it from here


class Happening(StrEnum):
    """What moves a job from one state to the next: the first six are asked for, the others happen."""

    START = "start"
    PAUSE = "pause"
    RESUME = "resume"
    STOP = "stop"
    ABORT = "abort"
    REQUEUE = "requeue"
    TURN = "turn"  # the campaign is the first of its rig's queue
    BEGUN = "begun"  # rig connected, lease held
    HALTED = "halted"  # the drive rests, the job waits
    RESTED = "rested"  # the drive rests, the job is over as asked
    FINISHED = "finished"
    TRIPPED = "tripped"
    REFUSED = "refused"
    FAILED = "failed"
    CUT_OFF = "cut off"  # lease lost, service ended or killed


ASKED = frozenset(
    {
        Happening.START,
        Happening.PAUSE,
        Happening.RESUME,
        Happening.STOP,
        Happening.ABORT,
        Happening.REQUEUE,
    }
)
_S, _H = JobState, Happening
TRANSITIONS: tuple[tuple[JobState, Happening, JobState], ...] = (
    (_S.CREATED, _H.START, _S.STARTING),
    (_S.CREATED, _H.STOP, _S.CANCELLED),
    (_S.CREATED, _H.ABORT, _S.CANCELLED),
    (_S.QUEUED, _H.TURN, _S.STARTING),
    (_S.QUEUED, _H.STOP, _S.CANCELLED),
    (_S.QUEUED, _H.ABORT, _S.CANCELLED),
    (_S.STARTING, _H.BEGUN, _S.RUNNING),
    (_S.STARTING, _H.STOP, _S.STOPPING),
    (_S.STARTING, _H.ABORT, _S.ABORTING),
    (_S.STARTING, _H.TRIPPED, _S.TRIPPED),
    (_S.STARTING, _H.REFUSED, _S.REFUSED),
    (_S.STARTING, _H.FAILED, _S.FAILED),
    (_S.STARTING, _H.CUT_OFF, _S.INTERRUPTED),
    (_S.RUNNING, _H.PAUSE, _S.PAUSING),
    (_S.RUNNING, _H.STOP, _S.STOPPING),
    (_S.RUNNING, _H.ABORT, _S.ABORTING),
    (_S.RUNNING, _H.FINISHED, _S.DONE),
    (_S.RUNNING, _H.TRIPPED, _S.TRIPPED),
    (_S.RUNNING, _H.REFUSED, _S.REFUSED),
    (_S.RUNNING, _H.FAILED, _S.FAILED),
    (_S.RUNNING, _H.CUT_OFF, _S.INTERRUPTED),
    (_S.PAUSING, _H.HALTED, _S.PAUSED),
    (_S.PAUSING, _H.STOP, _S.STOPPING),
    (_S.PAUSING, _H.ABORT, _S.ABORTING),
    (_S.PAUSING, _H.FINISHED, _S.DONE),
    (_S.PAUSING, _H.TRIPPED, _S.TRIPPED),
    (_S.PAUSING, _H.REFUSED, _S.REFUSED),
    (_S.PAUSING, _H.FAILED, _S.FAILED),
    (_S.PAUSING, _H.CUT_OFF, _S.INTERRUPTED),
    (_S.PAUSED, _H.RESUME, _S.RUNNING),
    (_S.PAUSED, _H.STOP, _S.STOPPING),
    (_S.PAUSED, _H.ABORT, _S.ABORTING),
    (_S.PAUSED, _H.CUT_OFF, _S.INTERRUPTED),
    (_S.STOPPING, _H.ABORT, _S.ABORTING),
    (_S.STOPPING, _H.RESTED, _S.STOPPED),
    (_S.STOPPING, _H.FINISHED, _S.DONE),
    (_S.STOPPING, _H.TRIPPED, _S.TRIPPED),
    (_S.STOPPING, _H.REFUSED, _S.REFUSED),
    (_S.STOPPING, _H.FAILED, _S.FAILED),
    (_S.STOPPING, _H.CUT_OFF, _S.INTERRUPTED),
    (_S.ABORTING, _H.RESTED, _S.ABORTED),
    (_S.ABORTING, _H.FINISHED, _S.DONE),
    (_S.ABORTING, _H.TRIPPED, _S.TRIPPED),
    (_S.ABORTING, _H.REFUSED, _S.REFUSED),
    (_S.ABORTING, _H.FAILED, _S.FAILED),
    (_S.ABORTING, _H.CUT_OFF, _S.INTERRUPTED),
    (_S.INTERRUPTED, _H.REQUEUE, _S.QUEUED),
    (_S.STOPPED, _H.REQUEUE, _S.QUEUED),
    (_S.ABORTED, _H.REQUEUE, _S.QUEUED),
    (_S.TRIPPED, _H.REQUEUE, _S.QUEUED),
    (_S.REFUSED, _H.REQUEUE, _S.QUEUED),
    (_S.FAILED, _H.REQUEUE, _S.QUEUED),
    (_S.CANCELLED, _H.REQUEUE, _S.QUEUED),
)
NEXT = {(state, happening): following for state, happening, following in TRANSITIONS}
ENDED = frozenset(
    {
        JobState.DONE,
        JobState.STOPPED,
        JobState.ABORTED,
        JobState.TRIPPED,
        JobState.REFUSED,
        JobState.FAILED,
        JobState.CANCELLED,
        JobState.INTERRUPTED,
    }
)


def follow(state: JobState, happening: Happening) -> JobState | None:
    """Return the next state, None where the table has none."""
    return NEXT.get((state, happening))


def allowed(state: JobState) -> tuple[Happening, ...]:
    """Return what may be asked for in this state."""
    return tuple(each for each in Happening if each in ASKED and (state, each) in NEXT)


def draw_diagram() -> str:
    """Return the table as a Mermaid diagram."""
    lines = ["stateDiagram-v2", "    [*] --> created: a session", "    [*] --> queued: a campaign"]
    lines += [f"    {state} --> {following}: {happening}" for state, happening, following in TRANSITIONS]
    return "\n".join(lines)
