"""Live estimates of an identification session by WebSocket; docs/live.md describes the messages."""

import asyncio
import dataclasses
import time
from collections.abc import AsyncGenerator
from typing import Annotated

from fastapi import APIRouter, Depends, Query, WebSocket
from fastapi import Path as PathParameter
from starlette.concurrency import run_in_threadpool

from server.api.dependencies import ReadDep, ServicesDep
from server.api.following import follow
from server.api.sockets import Parcel, ignore, serve_socket, to_text
from server.services.container import Services
from server.services.jobs.machine import ENDED
from server.services.rigs.fanout import Taken
from server.services.session_views import Json, SessionView
from server.services.viewing.clock import wall_clock_ns

sockets = APIRouter(tags=["sessions"])
_MAX_WAITING = 16
_HEARTBEAT_S = 1.0


def existing_session(
    services: ServicesDep, session_id: Annotated[str, PathParameter(max_length=40)]
) -> SessionView:
    """Return the session that the path names, before a connection stands."""
    return services.sessions.get(session_id)


@sockets.websocket("/sessions/{session_id}/live")
async def follow_session(
    socket: WebSocket,
    session: Annotated[SessionView, Depends(existing_session)],
    who: ReadDep,
    services: ServicesDep,
    interval_ms: Annotated[int, Query(ge=0, le=5000)] = 50,
) -> None:
    """Send a session's state and estimates as they come, until it has ended."""
    follower = _Follower(services, session, interval_ms)
    await serve_socket(socket, follower.parcels(), ignore)


class _Follower:
    """One who follows a session."""

    def __init__(self, services: Services, session: SessionView, interval_ms: int) -> None:
        self._services = services
        self._view = session
        self._live = session.live
        self._interval_s = interval_ms / 1e3
        self._skipped = 0
        self._dropped = 0
        self._number = 0

    async def parcels(self) -> AsyncGenerator[Parcel, None]:
        """Give a message at once, with each news, and once a second; the last one has the session's end."""
        sessions = self._services.sessions
        with sessions.news.followed(self._view.id) as source:
            async for taken in follow(source, _MAX_WAITING, _HEARTBEAT_S):
                if taken.closed or not taken.items or None in taken.items or taken.dropped > self._dropped:
                    self._view = await run_in_threadpool(sessions.get, self._view.id)
                    self._live = self._view.live
                self._take(taken)
                yield to_text(self._message())
                if self._view.state in ENDED:
                    return
                await asyncio.sleep(self._interval_s)

    def _take(self, taken: Taken[Json | None]) -> None:
        """Keep the newest estimates; those that it replaces were never sent, and are counted."""
        estimates = [each for each in taken.items if each is not None]
        if estimates:
            self._live = estimates[-1]
        self._skipped += max(0, len(estimates) - 1) + taken.dropped - self._dropped
        self._dropped = taken.dropped

    def _message(self) -> Json:
        view, progress = self._view, self._view.progress
        sent_ns, number = time.time_ns(), self._number
        self._number += 1
        return {
            "type": "session",
            "id": view.id,
            "number": number,
            "state": view.state.value,
            "reason": view.reason,
            "live": self._live,
            "progress": None if progress is None else dataclasses.asdict(progress),
            "skipped": self._skipped,
            "newest_ns": self._newest_ns(sent_ns),
            "sent_ns": sent_ns,
        }

    def _newest_ns(self, now_ns: int) -> int:
        """Return when the newest sample was taken that the provisional estimates have used; 0 when unknown."""
        driver = self._services.rigs.get(self._view.rig_id).worker.open_driver
        provisional = (self._live or {}).get("provisional")
        if driver is None or provisional is None:
            return 0
        return wall_clock_ns(driver, provisional["newest_tick"], now_ns)
