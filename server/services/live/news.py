"""Tells who follows a session that there is news of it: new estimates, or a new state.

Theory of operation. A follower subscribes before it reads the session's state, and a session's end is announced after
its state is stored: whoever comes at that moment sees either the end stored, or the announcement. Each follower has a
bounded queue of its own (`Fanout`); the estimators only ever append to it. What costs time only for followers, the
look-ahead, is made while there are any.
"""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from server.services.rigs.fanout import Fanout

Json = dict[str, Any]  # JSON values


class SessionNews:
    """All sessions that somebody follows."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._followed: dict[str, tuple[Fanout[Json | None], int]] = {}
        self._closed = False

    @contextmanager
    def followed(self, session_id: str) -> Iterator[Fanout[Json | None]]:
        """Give the news of a session as long as the block lasts: estimates, or None for a new state."""
        with self._lock:
            source, followers = self._followed.get(session_id, (Fanout[Json | None](), 0))
            self._followed[session_id] = source, followers + 1
            if self._closed:
                source.close()
        try:
            yield source
        finally:
            self._leave(session_id, source)

    def has_followers(self, session_id: str) -> bool:
        """Tell whether anybody follows a session."""
        return session_id in self._followed

    @property
    def followers(self) -> int:
        """How many follow any session."""
        with self._lock:
            return sum(followers for _, followers in self._followed.values())

    def publish(self, session_id: str, estimates: Json | None) -> None:
        """Tell new estimates, or by None that the session's state has changed; never waits."""
        found = self._followed.get(session_id)
        if found is not None:
            found[0].publish(estimates)

    def end(self, session_id: str) -> None:
        """Tell that a session has ended; its state is stored."""
        found = self._followed.get(session_id)
        if found is not None:
            found[0].close()

    def close(self) -> None:
        """Send everybody home: the service ends."""
        with self._lock:
            self._closed = True
            sources = [source for source, _ in self._followed.values()]
        for source in sources:
            source.close()

    def _leave(self, session_id: str, source: Fanout[Json | None]) -> None:
        with self._lock:
            _, followers = self._followed[session_id]
            if followers > 1:
                self._followed[session_id] = source, followers - 1
            else:
                del self._followed[session_id]
