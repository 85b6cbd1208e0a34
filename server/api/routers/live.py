"""Live data of a rig by WebSocket; docs/live.md describes the frames."""

import asyncio
from collections.abc import AsyncGenerator
from typing import Annotated

from fastapi import APIRouter, Depends, WebSocket
from fastapi.exceptions import RequestValidationError
from pydantic import ValidationError
from starlette.concurrency import run_in_threadpool

from server.api.dependencies import ReadDep, RigDep, ServicesDep
from server.api.following import follow
from server.api.schemas.live import LiveRequest, TicketAnswer
from server.api.sockets import Parcel, serve_socket, to_text
from server.services.errors import InvalidValueError
from server.services.figures import Figures
from server.services.rigs.served_rig import ServedRig
from server.services.tickets import TICKET_S
from server.services.viewing.view import LiveView

router = APIRouter(tags=["live"])
sockets = APIRouter(tags=["live"])
MAX_WAITING = 64
_HEARTBEAT_S = 1.0
_MAX_COMPLAINTS = 10


@router.post("/tickets", status_code=201)
def create_ticket(services: ServicesDep, who: ReadDep) -> TicketAnswer:
    """Make a ticket, which opens one WebSocket within 30 s; for browsers, which cannot send a token with it."""
    return TicketAnswer(ticket=services.tickets.issue(who), expires_in_s=TICKET_S)


def live_request(socket: WebSocket) -> LiveRequest:
    """Return what the address asks for.

    Raises:
        RequestValidationError: what it asks for is not allowed.
    """
    query = socket.query_params
    given: dict[str, object] = dict(query)
    if "columns" in query:
        given["columns"] = [name for each in query.getlist("columns") for name in each.split(",") if name]
    try:
        return LiveRequest.model_validate(given)
    except ValidationError as error:
        raise RequestValidationError(
            [{**each, "loc": ("query", *each["loc"])} for each in error.errors()]
        ) from error


@sockets.websocket("/rigs/{rig_id}/live")
async def watch_rig(
    socket: WebSocket,
    rig: RigDep,
    who: ReadDep,
    services: ServicesDep,
    wanted: Annotated[LiveRequest, Depends(live_request)],
) -> None:
    """Send a rig's samples as they come, until either side ends it."""
    view = await run_in_threadpool(LiveView, rig, services.live_sources, wanted.options())
    viewer = _Viewer(rig, view, services.figures)
    await serve_socket(socket, viewer.parcels(), viewer.listen)


class _Viewer:
    """One viewer: what it wants, and what is sent to it."""

    def __init__(self, rig: ServedRig, view: LiveView, figures: Figures) -> None:
        self._rig = rig
        self._view = view
        self._figures = figures
        self._dropped = 0
        self._told = -1
        self._complaints: list[str] = []

    async def listen(self, text: str) -> None:
        """Take another wish from the client."""
        try:
            self._view.change(LiveRequest.model_validate_json(text).options())
        except ValidationError as error:
            first = error.errors()[0]
            self._complain(".".join(str(part) for part in first["loc"]), first["msg"])
        except InvalidValueError as error:
            self._complain(error.field, f"{error}; {error.remedy}")

    async def parcels(self) -> AsyncGenerator[Parcel, None]:
        """Give plans and frames."""
        source = follow(self._rig.samples, MAX_WAITING, _HEARTBEAT_S, lambda block: len(block.ticks))
        async for taken in source:
            while self._complaints:
                yield self._complaints.pop(0)
            if self._told != self._view.plan:
                self._told = self._view.plan
                yield to_text(self._view.describe())
            self._figures.samples_dropped.add(taken.dropped - self._dropped)
            self._dropped = taken.dropped
            for frame in self._view.frames(taken.items, taken.dropped):
                yield frame
                self._figures.frames_sent.add()
            if not taken.items:
                yield self._view.heartbeat(taken.dropped)
            await asyncio.sleep(self._view.options.interval_ms / 1e3)

    def _complain(self, field: str, detail: str) -> None:
        if len(self._complaints) < _MAX_COMPLAINTS:
            self._complaints.append(to_text({"type": "problem", "field": field, "detail": detail}))
