"""The client for ordinary programs; `async_client.py` has the same for asyncio.

with Client("http://127.0.0.1:8000", token) as client:
    for recording in client.recordings.all(text="train"):
        print(recording.name, client.recordings.samples(recording.id, points=100)["current_A_max"].max())
"""

import contextlib
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, TypeVar

import httpx

from jointscope_client import sending
from jointscope_client.calls import Call, Page, as_json, get, one, path_of, post, submit_campaign
from jointscope_client.errors import make_problem
from jointscope_client.events import EventParser
from jointscope_client.job_resources import Discrepancies, Jobs
from jointscope_client.lease import Lease
from jointscope_client.live import LiveDecoder, LiveFrame, live_url
from jointscope_client.records import Event, Job, read_job
from jointscope_client.resources import Models, Recordings, Rigs
from jointscope_client.session_live import SessionMoment, read_moment, session_url

T = TypeVar("T")


class Client:
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
        self._http = httpx.Client(base_url=self.url, headers=self._headers, timeout=timeout_s)
        self.rigs = Rigs(self)
        self.recordings = Recordings(self)
        self.models = Models(self)
        self.discrepancies = Discrepancies(self)
        self.sessions = Jobs(self, "sessions")
        self.campaigns = Jobs(self, "campaigns")

    def __enter__(self) -> "Client":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Give the connections back."""
        self._http.close()

    def perform(self, call: Call[T]) -> T:
        """Send one call and return what it reads of the answer.

        Raises:
            ProblemError: the service refused.
            UnreachableError: it does not answer.
        """
        with contextlib.ExitStack() as stack:
            arguments = sending.arguments(call)
            if call.file is not None:
                arguments["content"] = stack.enter_context(call.file.open("rb"))
            try:
                answer = self._http.request(**arguments)
            except httpx.TransportError as error:
                raise sending.unreachable(self.url, error) from error
        sending.check(answer)
        return call.read(answer)

    def pages(self, call: Call[Page[T]]) -> Iterator[T]:
        """Give all items of a list, page by page, as they are needed."""
        following = call.params
        while True:
            page = self.perform(Call(method=call.method, path=call.path, read=call.read, params=following))
            yield from page.items
            if page.following is None:
                return
            following = page.following

    def download(self, call: Call[None], target: Path) -> Path:
        """Write an answer's body to a file as it comes."""
        partial = target.with_name(target.name + ".partial")
        with self._http.stream(**sending.arguments(call)) as answer:
            if not answer.is_success:
                answer.read()
            sending.check(answer)
            with partial.open("wb") as file:
                for octets in answer.iter_bytes(sending.PIECE):
                    file.write(octets)
        return partial.replace(target)

    def create_session(self, **spec: Any) -> Job:  # JSON values
        """Create an identification session; `docs/operator.md` lists what to give. `sessions` begins and watches it."""
        return self.perform(post(path_of("sessions"), one(read_job), spec))

    def identification(self, session_id: str) -> dict[str, Any]:  # JSON values
        """Return a session's identification.json, as `jointscope identify` writes it."""
        call = get(path_of("sessions", session_id, "identification"), as_json)
        found: dict[str, Any] = self.perform(call)
        return found

    def submit_campaign(self, text: str, *, rig: str) -> Job:
        """Queue a campaign from a campaign file's text; `campaigns` watches it."""
        return self.perform(submit_campaign(text, {"rig": rig}, one(read_job)))

    def check_campaign(self, text: str, *, rig: str) -> dict[str, Any]:  # JSON values
        """Check a campaign against the rig's limits, and predict travel and duration; nothing moves."""
        call = submit_campaign(text, {"rig": rig, "dry_run": True}, as_json)
        found: dict[str, Any] = self.perform(call)
        return found

    def lease(self, rig_id: str, *, ttl_s: float = 10.0, take_over: bool = False) -> Lease:
        """Return the operator's lease of a rig, to be held by `with`; it is renewed in the background.

        Args:
            rig_id: the rig.
            ttl_s: without renewal, the lease ends after so long, and with it whatever moves.
            take_over: take it from its holder, after the drive has ramped down.
        """
        return Lease(self, rig_id, ttl_s, take_over)

    def events(self, *, rig: str | None = None, after: int | None = None) -> Iterator[Event]:
        """Give events as they happen, without end; `after` begins behind a number instead of with new ones."""
        parser = EventParser()
        params = {name: value for name, value in (("rig", rig), ("after", after)) if value is not None}
        with self._http.stream("GET", path_of("events", "stream"), params=params, timeout=None) as answer:
            if not answer.is_success:
                answer.read()
            sending.check(answer)
            for line in answer.iter_lines():
                event = parser.feed(line)
                if event is not None:
                    yield event

    def live(
        self, rig_id: str, columns: Sequence[str] = (), *, rate_hz: float | None = None, interval_ms: int = 50
    ) -> Iterator[LiveFrame]:
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
        for message in self._messages(live_url(self.url, rig_id, columns, rate_hz, interval_ms)):
            frame = decoder.feed(message)
            if frame is not None:
                yield frame

    def follow_session(self, session_id: str, *, interval_ms: int = 50) -> Iterator[SessionMoment]:
        """Give a session's state and estimates as they come, until it has ended; it may be started meanwhile.

        Args:
            session_id: the session.
            interval_ms: a moment at most so often.

        Raises:
            ProblemError: the service refused.
        """
        for message in self._messages(session_url(self.url, session_id, interval_ms)):
            yield read_moment(message)

    def _messages(self, url: str) -> Iterator[str | bytes]:
        """Give a WebSocket's messages until the service ends it."""
        from websockets.exceptions import ConnectionClosedOK, InvalidStatus
        from websockets.sync.client import connect

        try:
            with connect(url, additional_headers=self._headers, max_size=None) as socket:
                yield from socket
        except InvalidStatus as refusal:
            raise make_problem(
                sending.refusal(refusal.response.status_code, refusal.response.body)
            ) from refusal
        except ConnectionClosedOK:
            return
