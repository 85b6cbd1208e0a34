"""Discrepancy analyses over REST: the real workflow in a process of its own."""

import signal
from collections.abc import Callable
from typing import Any

import httpx
import pytest
import yaml

from tests.server.service.conftest import Service
from tests.server.service.measured import MODEL, as_csv, measured_columns

PATH = "/api/v1/discrepancies"
Json = dict[str, Any]  # JSON values


def upload(client: httpx.Client, seed: int, n: int = 3000, hold: bool = False) -> str:
    """Upload a measurement and return its id; `hold` leaves the current constant, which allows no answer."""
    columns = measured_columns(seed, n)
    if hold:
        columns["current_A"] = columns["current_A"] * 0.0 + 0.5
    answer = client.post("/api/v1/recordings", params={"file": f"record{seed}.csv"}, content=as_csv(columns))
    made: str = answer.json()["id"]
    return made


def ask(client: httpx.Client, train: list[str], test: list[str]) -> Json:
    """Start an analysis of the model that the measurements come from."""
    model = client.post("/api/v1/models", content=MODEL).json()["id"]
    answer = client.post(PATH, json={"model": model, "train": train, "test": test})
    assert answer.status_code == 202, answer.text
    started: Json = answer.json()
    return started


def wait(service: Service, started: Json, *states: str) -> Json:
    """Wait until an analysis is in one of these states."""
    client = service.client("read")

    def look() -> Json | None:
        view: Json = client.get(f"{PATH}/{started['id']}").json()
        return view if view["state"] in states else None

    found: Json = service.wait_for(look, f"one of {states}")
    return found


def events_of(client: httpx.Client, analysis: str) -> list[str]:
    """Return what the event stream told of an analysis, in order."""
    items = client.get("/api/v1/events", params={"rig": "", "limit": 500}).json()["items"]
    kinds = [each["kind"] for each in items if each["data"]["id"] == analysis]
    assert all(kind.startswith("analysis.") for kind in kinds)
    return [kind.removeprefix("analysis.") for kind in kinds]


@pytest.mark.slow
def test_an_analysis_ends_with_a_report_and_a_new_model_version(service: Service) -> None:
    client = service.client("run")
    train, test = upload(client, 1), upload(client, 2)
    started = ask(client, [train], [test])
    assert client.get(f"{PATH}/{started['id']}/report").status_code == 409
    view = wait(service, started, "done", "failed")
    assert view["state"] == "done", view["reason"]
    assert view["progress"]["text"] and view["progress"]["elapsed_s"] > 0
    told = events_of(client, started["id"])
    assert (told[:2], told[-1], "progress" in told) == (["queued", "running"], "done", True)
    assert "jointscope_analyses_running 0.0" in client.get("/metrics").text
    gap = client.get(f"{PATH}/{started['id']}/gap").json()
    assert gap["schema"] == "jointscope.gap/1"
    assert view["result"]["verdict"] == gap["verdict"]
    model = client.get(f"/api/v1/models/{view['model_id']}").json()
    assert model["version"] == 2
    assert [each["kind"] for each in model["lineage"]] == ["analysis", "model", "recording", "recording"]
    assert [each["id"] for each in client.get(PATH, params={"model": model["id"]}).json()["items"]] == [
        view["id"]
    ]
    file = client.get(f"/api/v1/models/{model['id']}/file").text
    assert yaml.safe_load(file)["effects"] == model["document"]["effects"]
    report = client.get(f"{PATH}/{started['id']}/report")
    assert report.headers["content-type"].startswith("text/html")
    assert "default-src 'none'" in report.headers["content-security-policy"]
    assert "sandbox" in report.headers["content-security-policy"]
    assert report.text.startswith("<!doctype html>")
    assert str(service.data) not in report.text


def test_recordings_that_allow_no_answer_are_told(service: Service) -> None:
    client = service.client("run")
    started = ask(client, [upload(client, 3, hold=True)], [upload(client, 4)])
    view = wait(service, started, "done", "failed")
    assert view["state"] == "failed"
    assert "current_A is constant" in view["reason"]
    assert str(service.data) not in view["reason"]


def test_an_analysis_is_cancelled_whether_it_runs_or_waits(service: Service) -> None:
    client = service.client("run")
    train, test = upload(client, 5), upload(client, 6)
    first, second = ask(client, [train], [test]), ask(client, [train], [test])
    wait(service, first, "running")
    assert second["state"] == "queued"
    for each in (second, first):
        assert client.post(f"{PATH}/{each['id']}/cancel").json()["state"] == "cancelled"
        assert client.post(f"{PATH}/{each['id']}/cancel").status_code == 409
    folder = service.data / "discrepancies" / first["id"]
    service.wait_for(lambda: not folder.exists(), "the end of the process")
    told = events_of(client, first["id"]), events_of(client, second["id"])
    assert [kinds[:2] for kinds in told] == [["queued", "running"], ["queued", "cancelled"]]
    assert told[0][-1] == "cancelled"


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_an_analysis_under_way_is_interrupted_by_the_services_end(
    start_service: Callable[..., Service], number: int
) -> None:
    service = start_service()
    client = service.client("run")
    train, test = upload(client, 7), upload(client, 8)
    started, waiting = ask(client, [train], [test]), ask(client, [train], [test])
    wait(service, started, "running")
    token = service.admin_token
    service.stop(number)
    again = start_service(data=service.data, token=token)
    view = wait(again, started, "interrupted")
    assert "service" in view["reason"]
    assert wait(again, waiting, "running")["id"] == waiting["id"]
    again.client("run").post(f"{PATH}/{waiting['id']}/cancel")


@pytest.mark.parametrize(
    ("change", "status", "field"),
    [
        ({"model": "nobody"}, 404, None),
        ({"train": ["nobody"]}, 404, None),
        ({"train": []}, 422, "train"),
        ({"test": ["RECORDING"]}, 422, "train"),
        ({"jobs": 99}, 422, "jobs"),
    ],
)
def test_a_wrong_question_is_refused(service: Service, change: Json, status: int, field: str | None) -> None:
    client = service.client("run")
    recording, other = upload(client, 9), upload(client, 10)
    model = client.post("/api/v1/models", content=MODEL).json()["id"]
    body = {"model": model, "train": [recording], "test": [other]} | change
    body["test"] = [recording if each == "RECORDING" else each for each in body["test"]]
    answer = client.post(PATH, json=body)
    assert (answer.status_code, answer.json().get("field")) == (status, field)
