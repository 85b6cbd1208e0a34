"""Events: stored ones by page, new ones as a stream (server-sent events)."""

from collections.abc import AsyncGenerator, AsyncIterator
from dataclasses import dataclass
from typing import Annotated

from fastapi import APIRouter, Header, Query, WebSocket
from fastapi.responses import StreamingResponse
from starlette.concurrency import run_in_threadpool

from server.api.dependencies import ReadDep, ServicesDep
from server.api.following import follow
from server.api.schemas.events import EventAnswer, EventPage
from server.api.sockets import Parcel, ignore, serve_socket, to_text
from server.services.container import Services
from server.services.events import ServiceEvent

router = APIRouter(prefix="/events", tags=["events"])
sockets = APIRouter(tags=["events"])
_MAX_WAITING = 1000
_HEARTBEAT_S = 15.0
_PAGE = 500
MAX_ID = 2**63 - 1
RigFilter = Annotated[str | None, Query(max_length=80, description="Only of this rig.")]
KindFilter = Annotated[str | None, Query(max_length=60, description="Only of this kind.")]


@router.get("")
def list_events(
    services: ServicesDep,
    who: ReadDep,
    rig: RigFilter = None,
    kind: KindFilter = None,
    after: Annotated[int, Query(ge=0, le=MAX_ID, description="Only with numbers above this.")] = 0,
    limit: Annotated[int, Query(ge=1, le=_PAGE)] = 100,
) -> EventPage:
    """List stored events, oldest first."""
    events = services.events.page(rig_id=rig, kind=kind, after=after, limit=limit)
    following = events[-1].id if len(events) == limit else None
    return EventPage(items=[EventAnswer.model_validate(event) for event in events], next_after=following)


@router.get(
    "/stream",
    response_class=StreamingResponse,
    responses={200: {"content": {"text/event-stream": {"schema": {"type": "string"}}}, "description": "SSE"}},
)
async def stream_events(
    services: ServicesDep,
    who: ReadDep,
    rig: RigFilter = None,
    after: Annotated[
        int | None, Query(ge=0, le=MAX_ID, description="Begin behind this number instead of with new events.")
    ] = None,
    last_event_id: Annotated[
        int | None, Header(ge=0, le=MAX_ID, description="Sent by browsers that reconnect.")
    ] = None,
) -> StreamingResponse:
    """Follow events as they are stored (server-sent events: `id`, `event`, `data` as JSON).

    A reader that is too slow loses the oldest and is told by an event `lost`; a comment comes every 15 s.
    """
    since = last_event_id if last_event_id is not None else after
    return StreamingResponse(_lines(services, rig, since), media_type="text/event-stream")


@sockets.websocket("/events/live")
async def watch_events(
    socket: WebSocket,
    services: ServicesDep,
    who: ReadDep,
    rig: RigFilter = None,
    after: Annotated[int | None, Query(ge=0, le=MAX_ID)] = None,
) -> None:
    """Send events as they are stored, for pages, whose event streams cannot carry a token."""
    await serve_socket(socket, _messages(services, rig, after), ignore)


@dataclass(frozen=True, slots=True)
class _News:
    """Events for one reader, and how many it has lost since the last time by being slow."""

    events: list[ServiceEvent]
    lost: int


async def _follow_events(
    services: Services, rig: str | None, since: int | None
) -> AsyncGenerator[_News, None]:
    """Give news as they come, and an empty one now and then; the first has what is stored behind `since`."""
    newest, lost, caught_up = since or 0, 0, since is None
    async for taken in follow(services.events.stored, _MAX_WAITING, _HEARTBEAT_S):
        events: list[ServiceEvent] = []
        if not taken.items:
            yield _News([], 0)
        if not caught_up:  # subscribed first, read afterwards: nothing falls between
            caught_up = True
            async for event in _stored(services, newest):
                newest = event.id
                events.append(event)
                if len(events) >= _PAGE:
                    yield _News(_of_rig(events, rig), 0)
                    events = []
        events += [event for event in taken.items if event.id > newest]
        if events or taken.dropped > lost:
            yield _News(_of_rig(events, rig), taken.dropped - lost)
        lost = taken.dropped


def _of_rig(events: list[ServiceEvent], rig: str | None) -> list[ServiceEvent]:
    return [event for event in events if rig in (None, event.rig_id)]


async def _lines(services: Services, rig: str | None, since: int | None) -> AsyncGenerator[str, None]:
    async for news in _follow_events(services, rig, since):
        if not news.events and not news.lost:
            yield ": listening\n\n"
        if news.lost:
            yield f'event: lost\ndata: {{"lost": {news.lost}}}\n\n'
        for event in news.events:
            yield _sse(event)


async def _messages(services: Services, rig: str | None, since: int | None) -> AsyncGenerator[Parcel, None]:
    async for news in _follow_events(services, rig, since):
        items = [EventAnswer.model_validate(event).model_dump(mode="json") for event in news.events]
        yield to_text({"type": "events", "items": items, "lost": news.lost})


async def _stored(services: Services, after: int) -> AsyncIterator[ServiceEvent]:
    while True:
        page = await run_in_threadpool(services.events.page, after=after, limit=_PAGE)
        for event in page:
            yield event
        if len(page) < _PAGE:
            return
        after = page[-1].id


def _sse(event: ServiceEvent) -> str:
    data = EventAnswer.model_validate(event).model_dump_json()
    return f"id: {event.id}\nevent: {event.kind}\ndata: {data}\n\n"
