"""Sequence numbers of commands as the controller sees them: new, seen before, or too old to tell.

Works like the anti-replay window of IPsec (RFC 4303, 3.4.3): the newest number and, for the few before it,
whether they have been seen. A command lost on the line may so be executed after its successors, but none
twice.
"""

from enum import Enum, auto
from typing import Final

WINDOW: Final = 4
"""Commands that may be under way at once, and replies that the controller keeps for repeated commands."""


class Freshness(Enum):
    """What a sequence number says about its command."""

    NEW = auto()
    SEEN = auto()
    STALE = auto()


class SequenceWindow:
    """Remembers the newest sequence number and which of the `WINDOW` numbers up to it have been accepted.

    Args:
        first: Number of the command that opened the session.
    """

    def __init__(self, first: int) -> None:
        self._newest = first
        self._accepted = (
            1 << WINDOW
        ) - 1  # bit b: `newest - b`; what came before the session counts as accepted

    def judge(self, seq: int) -> Freshness:
        """Tell whether a command of this number may be executed."""
        ahead = (seq - self._newest) & 0xFF
        if 0 < ahead < 128:
            return Freshness.NEW
        behind = -ahead & 0xFF
        if behind >= WINDOW:
            return Freshness.STALE
        return Freshness.SEEN if self._accepted >> behind & 1 else Freshness.NEW

    def accept(self, seq: int) -> None:
        """Take note that the command of this number, judged new, is being executed."""
        ahead = (seq - self._newest) & 0xFF
        if ahead < 128:
            self._accepted = (self._accepted << ahead | 1) & ((1 << WINDOW) - 1)
            self._newest = seq
        else:
            self._accepted |= 1 << (-ahead & 0xFF)
