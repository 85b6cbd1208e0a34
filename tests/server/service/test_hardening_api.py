"""What strangers and careless programs may not do to the service."""

import re

import pytest
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from tests.server.service.conftest import RIG, Service
from tests.server.service.test_problem_shape import assert_problem


def test_a_refused_scope_stands_in_the_audit_log(service: Service) -> None:
    service.client("read").post(f"/api/v1/rigs/{RIG}/connect")
    newest = service.client().get("/api/v1/audit").json()["items"]
    line = next(each for each in newest if each["action"] == "refused")
    assert (line["token_name"], line["resource"]) == ("test read", f"/api/v1/rigs/{RIG}/connect")
    assert line["outcome"] == "403: needs run"


def test_many_wrong_tokens_are_told_to_wait_and_a_right_one_never_is(service: Service) -> None:
    stranger, statuses = service.client(None), []
    for number in range(23):
        answer = stranger.get("/api/v1/rigs", headers={"Authorization": f"Bearer js_{number}"})
        statuses.append(answer.status_code)
    assert statuses[0] == 401
    assert_problem(answer, 429)
    assert int(answer.headers["retry-after"]) > 0
    assert service.client("read").get("/api/v1/rigs").status_code == 200
    assert_problem(stranger.get("/api/v1/rigs"), 401)


def test_a_revoked_token_loses_its_open_connections(service: Service) -> None:
    admin = service.client()
    made = admin.post("/api/v1/tokens", json={"name": "short-lived", "scopes": ["read"]}).json()
    url = f"{service.url.replace('http', 'ws')}/api/v1/rigs/{RIG}/live?interval_ms=1000&rate_hz=1"
    with connect(url, additional_headers={"Authorization": f"Bearer {made['secret']}"}) as socket:
        admin.delete(f"/api/v1/tokens/{made['token']['id']}")
        with pytest.raises(ConnectionClosed) as caught:
            while True:
                socket.recv(timeout=30)
    assert caught.value.rcvd is not None
    assert caught.value.rcvd.reason == "the token is no longer valid"


def test_metrics_cover_link_lease_viewers_queue_and_fit(service: Service) -> None:
    text = service.client(None).get("/metrics").text
    for name in (
        "link_samples_lost_total",
        "lease_left_seconds",
        "viewers",
        "live_frames_total",
        "live_samples_dropped_total",
        "live_viewers_given_up_total",
        "tokens_refused_total",
        "fit_seconds{",
        "fit_seconds_max{",
        "analyses_running",
        "analyses_waiting",
        "analysis_seconds_count",
        "session_followers",
    ):
        assert f"\njointscope_{name}" in text, name
    assert "# TYPE jointscope_queue_length gauge" in text
    families = re.findall(r"^# TYPE (\S+)", text, re.MULTILINE)
    assert len(families) == len(set(families))  # one that stands twice makes Prometheus refuse the whole page
