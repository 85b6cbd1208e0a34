"""Events over REST: by page and as a stream."""

import itertools

from tests.server.service.conftest import RIG, Service

PATH = f"/api/v1/rigs/{RIG}/lease"


def test_pages_continue_where_the_last_one_ended(service: Service) -> None:
    client = service.client("read")
    first = client.get("/api/v1/events", params={"limit": 1}).json()
    second = client.get("/api/v1/events", params={"limit": 1, "after": first["next_after"]}).json()
    assert second["items"][0]["id"] > first["items"][0]["id"]


def test_a_stream_gives_what_is_stored_and_then_what_comes(rested: Service) -> None:
    client = rested.client("run")
    stored = client.get("/api/v1/events", params={"limit": 500}).json()["items"]
    with client.stream("GET", "/api/v1/events/stream", params={"after": 0}) as stream:
        lines = (line for line in stream.iter_lines() if line.startswith("id: "))
        replayed = [int(line.removeprefix("id: ")) for line in itertools.islice(lines, len(stored))]
        assert replayed == [event["id"] for event in stored]
        with rested.hold(rested.client("run")):
            assert int(next(lines).removeprefix("id: ")) > replayed[-1]


def test_a_browser_that_reconnects_continues_behind_its_last_event(rested: Service) -> None:
    client = rested.client("read")
    second = client.get("/api/v1/events", params={"limit": 2}).json()["items"][1]["id"]
    with client.stream("GET", "/api/v1/events/stream", headers={"Last-Event-ID": str(second - 1)}) as stream:
        assert next(line for line in stream.iter_lines() if line.startswith("id: ")) == f"id: {second}"


def test_a_stream_of_one_rig_leaves_out_the_others(rested: Service) -> None:
    client = rested.client("run")
    parameters: dict[str, str] = {"after": "0", "rig": "another"}
    with client.stream("GET", "/api/v1/events/stream", params=parameters) as stream:
        lines = stream.iter_lines()
        assert [next(lines), next(lines)] == [": listening", ""]
