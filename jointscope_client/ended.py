"""When work in the service has ended."""

from jointscope_client.errors import NotDoneError

DONE = "done"
ENDED = frozenset({DONE, "stopped", "aborted", "tripped", "refused", "failed", "cancelled", "interrupted"})


def check_done(state: str, reason: str, late: bool) -> bool:
    """Tell whether work is done; False while it goes on.

    Raises:
        NotDoneError: it ended otherwise, or goes on although it is late.
    """
    if state == DONE:
        return True
    if state in ENDED:
        raise NotDoneError(f"{state}: {reason}" if reason else state, state)
    if late:
        raise NotDoneError(f"still {state}", state)
    return False
