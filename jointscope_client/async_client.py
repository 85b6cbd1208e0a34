"""The client for asyncio; the same as `client.py`, with `await`, `async with` and `async for`."""

from collections.abc import AsyncIterator, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, TypeVar

import httpx

from jointscope_client import sending
from jointscope_client.async_job_resources import Discrepancies, Jobs
from jointscope_client.async_lease import AsyncLease
from jointscope_client.async_resources import Models, Recordings, Rigs
from jointscope_client.calls import Call, Page, as_json, get, one, path_of, post, submit_campaign
from jointscope_client.errors import make_problem
from jointscope_client.events import EventParser
from jointscope_client.live import LiveDecoder, LiveFrame, live_url
from jointscope_client.records import Event, Job, read_job
from jointscope_client.session_live import SessionMoment, read_moment, session_url

T = TypeVar("T")


class AsyncClient:
    """A connection to one service.

    Args:
        url: address of the service; None takes JOINTSCOPE_URL, or this machine's port 8000.
        token: None takes JOINTSCOPE_TOKEN.
        timeout_s: patience with one answer.

    Attributes:
        rigs, recordings, models, discrepancies, sessions, campaigns: what there is, by kind.
    """

    def __init__(self, url: str | None = None, token: str | None = None, *, timeout_s: float = 60.0) -> None:
        self.url, self._headers = sending.settings(url, token)
        self._http = httpx.AsyncClient(base_url=self.url, headers=self._headers, timeout=timeout_s)
        self.rigs = Rigs(self)
        self.recordings = Recordings(self)
        self.models = Models(self)
        self.discrepancies = Discrepancies(self)
        self.sessions = Jobs(self, "sessions")
        self.campaigns = Jobs(self, "campaigns")

    async def __aenter__(self) -> "AsyncClient":
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self.close()

    async def close(self) -> None:
        """Give the connections back."""
        await self._http.aclose()

    async def perform(self, call: Call[T]) -> T:
        """Send one call and return what it reads of the answer.

        Raises:
            ProblemError: the service refused.
            UnreachableError: it does not answer.
        """
        arguments = sending.arguments(call)
        if call.file is not None:
            arguments["content"] = _pieces(call.file)
        try:
            answer = await self._http.request(**arguments)
        except httpx.TransportError as error:
            raise sending.unreachable(self.url, error) from error
        sending.check(answer)
        return call.read(answer)

    async def pages(self, call: Call[Page[T]]) -> AsyncIterator[T]:
        """Give all items of a list, page by page, as they are needed."""
        following = call.params
        while True:
            page = await self.perform(
                Call(method=call.method, path=call.path, read=call.read, params=following)
            )
            for item in page.items:
                yield item
            if page.following is None:
                return
            following = page.following

    async def download(self, call: Call[None], target: Path) -> Path:
        """Write an answer's body to a file as it comes."""
        partial = target.with_name(target.name + ".partial")
        async with self._http.stream(**sending.arguments(call)) as answer:
            if not answer.is_success:
                await answer.aread()
            sending.check(answer)
            with partial.open("wb") as file:
                async for octets in answer.aiter_bytes(sending.PIECE):
                    file.write(octets)
        return partial.replace(target)

    async def create_session(self, **spec: Any) -> Job:  # JSON values
        """Create an identification session; `docs/operator.md` lists what to give. `sessions` begins and watches it."""
        return await self.perform(post(path_of("sessions"), one(read_job), spec))

    async def identification(self, session_id: str) -> dict[str, Any]:  # JSON values
        """Return a session's identification.json, as `jointscope identify` writes it."""
        call = get(path_of("sessions", session_id, "identification"), as_json)
        found: dict[str, Any] = await self.perform(call)
        return found

    async def submit_campaign(self, text: str, *, rig: str) -> Job:
        """Queue a campaign from a campaign file's text; `campaigns` watches it."""
        return await self.perform(submit_campaign(text, {"rig": rig}, one(read_job)))

    async def check_campaign(self, text: str, *, rig: str) -> dict[str, Any]:  # JSON values
        """Check a campaign against the rig's limits, and predict travel and duration; nothing moves."""
        call = submit_campaign(text, {"rig": rig, "dry_run": True}, as_json)
        found: dict[str, Any] = await self.perform(call)
        return found

    def lease(self, rig_id: str, *, ttl_s: float = 10.0, take_over: bool = False) -> AsyncLease:
        """Return the operator's lease of a rig, to be held by `async with`; it is renewed in the background.

        Args:
            rig_id: the rig.
            ttl_s: without renewal, the lease ends after so long, and with it whatever moves.
            take_over: take it from its holder, after the drive has ramped down.
        """
        return AsyncLease(self, rig_id, ttl_s, take_over)

    async def events(self, *, rig: str | None = None, after: int | None = None) -> AsyncIterator[Event]:
        """Give events as they happen, without end; `after` begins behind a number instead of with new ones."""
        parser = EventParser()
        params = {name: value for name, value in (("rig", rig), ("after", after)) if value is not None}
        path = path_of("events", "stream")
        async with self._http.stream("GET", path, params=params, timeout=None) as answer:
            if not answer.is_success:
                await answer.aread()
            sending.check(answer)
            async for line in answer.aiter_lines():
                event = parser.feed(line)
                if event is not None:
                    yield event

    async def live(
        self, rig_id: str, columns: Sequence[str] = (), *, rate_hz: float | None = None, interval_ms: int = 50
    ) -> AsyncIterator[LiveFrame]:
        """Give a rig's samples as they come, as frames of numpy arrays, without end.

        Args:
            rig_id: the rig.
            columns: SI columns; none takes those that the rig streams.
            rate_hz: rows per second, each with the least and the greatest value; None gives every sample.
            interval_ms: a frame at most so often.

        Raises:
            ProblemError: the service refused.
        """
        decoder = LiveDecoder()
        async for message in self._messages(live_url(self.url, rig_id, columns, rate_hz, interval_ms)):
            frame = decoder.feed(message)
            if frame is not None:
                yield frame

    async def follow_session(self, session_id: str, *, interval_ms: int = 50) -> AsyncIterator[SessionMoment]:
        """Give a session's state and estimates as they come, until it has ended; it may be started meanwhile.

        Args:
            session_id: the session.
            interval_ms: a moment at most so often.

        Raises:
            ProblemError: the service refused.
        """
        async for message in self._messages(session_url(self.url, session_id, interval_ms)):
            yield read_moment(message)

    async def _messages(self, url: str) -> AsyncIterator[str | bytes]:
        """Give a WebSocket's messages until the service ends it."""
        from websockets.asyncio.client import connect
        from websockets.exceptions import ConnectionClosedOK, InvalidStatus

        try:
            async with connect(url, additional_headers=self._headers, max_size=None) as socket:
                async for message in socket:
                    yield message
        except InvalidStatus as refusal:
            raise make_problem(
                sending.refusal(refusal.response.status_code, refusal.response.body)
            ) from refusal
        except ConnectionClosedOK:
            return


async def _pieces(path: Path) -> AsyncIterator[bytes]:
    """Give a file in pieces; each is read at once, which takes a disk about a millisecond."""
    with path.open("rb") as file:
        while octets := file.read(sending.PIECE):
            yield octets
