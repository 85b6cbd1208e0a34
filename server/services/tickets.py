"""Tickets: for some seconds, and for one connection, as good as the token that they were made with.

A browser cannot send a token with a WebSocket but in its address, where logs would keep it, or as a subprotocol. A
ticket goes the second way, and is worth nothing by the time that anybody finds it. Kept in memory only.
"""

import secrets
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from server.services.tokens import Principal

TICKET_S = 30.0
_MAX_OPEN = 10_000


@dataclass(frozen=True, slots=True, kw_only=True)
class _Ticket:
    secret: str
    who: Principal
    ends_s: float


class TicketOffice:
    """Makes tickets and takes each once.

    Args:
        clock: monotonic time, s.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._open: deque[_Ticket] = deque(maxlen=_MAX_OPEN)
        self._lock = threading.Lock()

    def issue(self, who: Principal) -> str:
        """Return a ticket."""
        ticket = _Ticket(secret=secrets.token_urlsafe(24), who=who, ends_s=self._clock() + TICKET_S)
        with self._lock:
            self._forget_old()
            self._open.append(ticket)
        return ticket.secret

    def redeem(self, secret: str) -> Principal | None:
        """Return whose ticket this is, once; None for an unknown, used or old one."""
        with self._lock:
            self._forget_old()
            for ticket in self._open:
                if secrets.compare_digest(ticket.secret.encode(), secret.encode()):
                    self._open.remove(ticket)
                    return ticket.who
        return None

    def _forget_old(self) -> None:
        now_s = self._clock()
        while self._open and self._open[0].ends_s <= now_s:
            self._open.popleft()
