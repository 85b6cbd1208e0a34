"""Live data by WebSocket, against the real service process and the real emulator."""

import json
import re
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import pairwise

import httpx
import pytest
from websockets.exceptions import InvalidStatus
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Subprotocol

from server.services.viewing.frame import FrameFlag, LiveFrame, decode_live
from tests.server.service.conftest import RIG, Service

PATH = f"/api/v1/rigs/{RIG}/live"


@contextmanager
def watch(service: Service, query: str = "", **headers: str) -> Iterator[ClientConnection]:
    """Open live data with a token, or with the headers given."""
    sent = headers or {"Authorization": f"Bearer {service.token('read')}"}
    url = service.url.replace("http", "ws") + PATH + query
    with connect(url, additional_headers=sent, compression=None) as live:
        yield live


def refusal(service: Service, query: str = "", **headers: str) -> tuple[int, dict[str, str]]:
    """Return status and problem of a refused connection."""
    with pytest.raises(InvalidStatus) as caught, watch(service, query, **headers):
        pass
    response = caught.value.response
    assert response.headers["content-type"] == "application/problem+json"
    return response.status_code, json.loads(response.body)


def read_plan(live: ClientConnection) -> dict[str, object]:
    """Pass over frames until a text message comes."""
    while isinstance(message := live.recv(timeout=30), bytes):
        pass
    plan: dict[str, object] = json.loads(message)
    return plan


def read_frames(live: ClientConnection, count: int) -> list[LiveFrame]:
    """Return the next frames that have rows."""
    frames: list[LiveFrame] = []
    while len(frames) < count:
        message = live.recv(timeout=30)
        if isinstance(message, bytes) and (frame := decode_live(message)).values.size:
            frames.append(frame)
    return frames


def test_frames_follow_each_other_without_a_hole_unless_they_say_so(service: Service) -> None:
    with watch(service, "?columns=position_rad&interval_ms=0") as live:
        frames = read_frames(live, 20)
    assert frames[0].flags & FrameFlag.BREAK
    for before, after in pairwise(frames):
        follows = after.first_tick == before.first_tick + before.values.shape[1]
        assert follows or after.flags & FrameFlag.BREAK


def test_a_plan_names_columns_and_units_and_changes_when_the_client_says_so(service: Service) -> None:
    with watch(service) as live:
        usual = read_plan(live)
        assert {"name": "speed_rad_s", "unit": "rad/s"} in usual["columns"]  # type: ignore[operator]  # JSON
        live.send('{"columns": ["current_A"], "rate_hz": 250}')
        assert read_plan(live)["columns"] == [{"name": "current_A", "unit": "A"}]
        frame = read_frames(live, 1)[0]
    assert frame.flags & FrameFlag.MIN_MAX
    assert frame.row_s == pytest.approx(4e-3)
    assert (frame.samples_per_row, frame.values.shape[0]) == (10, 2)
    assert (frame.values[0] <= frame.values[1]).all()


def test_a_wrong_wish_while_it_runs_is_told_and_changes_nothing(service: Service) -> None:
    with watch(service, "?columns=current_A") as live:
        plan = read_plan(live)
        live.send('{"rate_hz": -1}')
        problem = read_plan(live)
        assert (problem["type"], problem["field"]) == ("problem", "rate_hz")
        assert read_frames(live, 1)[0].plan == plan["plan"]


def test_a_viewer_that_reads_too_slowly_is_told_exactly_what_it_lost(service: Service) -> None:
    # At full speed the emulated rig makes far more than a connection's buffers and this viewer's queue hold.
    with watch(service, "?interval_ms=100&columns=current_A") as live:
        # The stream of the test before may just be ending; between two streams nothing is measured, nor lost.
        frames = read_frames(live, 8)[-1:]
        while frames[-1].dropped == frames[0].dropped:
            frames += read_frames(live, 1)
    missing = sum(
        after.first_tick - before.first_tick - before.values.shape[1] for before, after in pairwise(frames)
    )
    told = [frame.dropped + frame.lost for frame in frames]
    assert missing == told[-1] - told[0] > 0


@pytest.mark.parametrize(
    ("query", "status", "field"),
    [("?columns=colour", 422, "columns"), ("?rate_hz=1e9", 422, "rate_hz"), ("?no=such", 422, "no")],
)
def test_what_cannot_be_had_is_refused_before_the_connection_stands(
    service: Service, query: str, status: int, field: str
) -> None:
    found, problem = refusal(service, query)
    assert (found, problem["field"]) == (status, field)


def test_a_stranger_is_refused(service: Service) -> None:
    assert refusal(service, Authorization="Bearer js_nobody")[0] == 401
    assert refusal(service, Cookie="none")[0] == 401


def test_a_page_of_another_site_is_refused_even_with_a_token(service: Service) -> None:
    token = f"Bearer {service.token('read')}"
    assert refusal(service, Authorization=token, Origin="http://elsewhere.example")[0] == 403
    with watch(service, Authorization=token, Origin=service.url) as live:
        assert read_plan(live)["rig"] == RIG


def test_a_ticket_opens_one_connection(service: Service) -> None:
    ticket = service.client("read").post("/api/v1/tickets").json()["ticket"]
    url = service.url.replace("http", "ws") + PATH
    offered = [Subprotocol("jointscope.v1"), Subprotocol(f"ticket.{ticket}")]
    with connect(url, subprotocols=offered) as live:
        assert live.subprotocol == "jointscope.v1"
        assert read_plan(live)["rig"] == RIG
    with pytest.raises(InvalidStatus), connect(url, subprotocols=offered):
        pass


def test_events_come_by_websocket_those_stored_first(service: Service) -> None:
    stored = service.client("read").get("/api/v1/events", params={"limit": 500}).json()["items"]
    url = f"{service.url.replace('http', 'ws')}/api/v1/events/live?after=0"
    seen: list[dict[str, object]] = []
    with connect(url, additional_headers={"Authorization": f"Bearer {service.token('read')}"}) as live:
        while len(seen) < len(stored):
            seen += json.loads(live.recv(timeout=30))["items"]
        assert seen[: len(stored)] == stored
        with service.hold(service.client("run")):
            kinds: set[object] = set()
            while "lease.acquired" not in kinds:
                kinds |= {event["kind"] for event in json.loads(live.recv(timeout=30))["items"]}


@pytest.mark.slow
def test_a_viewer_that_reads_nothing_is_cut_off(service: Service) -> None:
    address = httpx.URL(service.url)
    with socket.create_connection((address.host, address.port or 80)) as mute:
        lines = (
            f"GET {PATH}?interval_ms=0 HTTP/1.1",
            f"Host: {address.host}:{address.port}",
            f"Authorization: Bearer {service.token('read')}",
            "Upgrade: websocket",
            "Connection: Upgrade",
            "Sec-WebSocket-Version: 13",
            "Sec-WebSocket-Key: MDEyMzQ1Njc4OWFiY2RlZg==",
        )
        mute.sendall("\r\n".join([*lines, "", ""]).encode())
        given_up = re.compile(r"^jointscope_live_viewers_given_up_total [1-9]", re.MULTILINE)
        client = service.client(None)
        service.wait_for(lambda: given_up.search(client.get("/metrics").text), "the end of the mute viewer")
