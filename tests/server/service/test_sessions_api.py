"""Identification sessions over REST, against the real process and the emulated controller."""

import json
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest

from estimators.settings import IdentifyOptions
from server.services.live.learner import replay_journal
from tests.server.service.conftest import RIG, Service, launch

PATH = "/api/v1/sessions"
MULTISINE = {"kind": "multisine", "amplitude_A": 0.8, "period_s": 5, "lines": 8, "seed": 7, "ramp_s": 0.5}
TRAPEZOID = {"kind": "trapezoid", "amplitude_A": 0.6, "period_s": 4, "rise_fraction": 0.2, "ramp_s": 0.5}
BODY: dict[str, Any] = {  # JSON values
    "name": "joint1",
    "rig": RIG,
    "excitation": MULTISINE,
    "duration_s": 20,
    "test": {"excitation": TRAPEZOID, "duration_s": 10},
    "sample_time_s": 0.1,
}
OF_FIRST = "estimators.0.options"
LONG = {**BODY, "name": "long", "duration_s": 600}
OVER = ("done", "stopped", "aborted", "tripped", "refused", "failed", "cancelled", "interrupted")
Json = dict[str, Any]  # JSON values


@pytest.fixture(scope="module")
def real_time(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    """Give a service whose rig keeps real time, so that a record can be met under way."""
    started = launch(tmp_path_factory.mktemp("sessions") / "data", speed="1")
    started.connect()
    yield started
    started.stop()


def create(client: httpx.Client, body: Json) -> str:
    answer = client.post(PATH, json=body)
    assert answer.status_code == 201, answer.text
    return str(answer.json()["id"])


def reach(service: Service, client: httpx.Client, session: str, *states: str) -> Json:
    def look() -> Json | None:
        view: Json = client.get(f"{PATH}/{session}").json()
        assert view["state"] in states or view["state"] not in OVER, view["reason"]
        return view if view["state"] in states else None

    found: Json = service.wait_for(look, f"a session that is {' or '.join(states)}")
    return found


def learning(service: Service, client: httpx.Client, session: str) -> Json:
    """Wait until the first estimates are there."""

    def look() -> Json | None:
        live = client.get(f"{PATH}/{session}").json()["live"]
        return live if live and live["estimators"]["rls"]["parameters"] else None

    found: Json = service.wait_for(look, "the first live estimates")
    return found


@pytest.fixture(scope="module")
def finished(service: Service) -> Json:
    """A session that was played to its end."""
    client = service.client("run")
    session = create(client, BODY)
    assert client.post(f"{PATH}/{session}/start").status_code == 202
    return reach(service, client, session, "done")


def records(service: Service, session: str) -> Path:
    return service.data / "sessions" / session / "records"


def test_a_finished_session_has_samples_estimates_and_a_recording(finished: Json) -> None:
    figures = finished["figures"]["records"]["record train (multisine, 20 s)"]
    assert figures["samples_received"] == figures["samples_expected"] > 50_000
    assert finished["recording_id"]
    assert finished["live"]["complete"]
    assert finished["figures"]["identification"]["rls"]["scores"]["test"]["free_run"]["r2_adjusted"] > 0.95


def test_live_estimates_equal_the_replayed_ones_to_the_last_digit(service: Service, finished: Json) -> None:
    journal = records(service, finished["id"]) / "train.journal.zst"
    replayed = replay_journal(journal, 0.1, IdentifyOptions())
    assert json.loads(json.dumps(replayed["estimators"])) == finished["live"]["estimators"]


def test_the_last_live_estimates_agree_with_the_identification(finished: Json) -> None:
    for method, found in finished["figures"]["identification"].items():
        for live, final in zip(
            finished["live"]["estimators"][method]["parameters"], found["parameters"], strict=True
        ):
            # Rounding of the streamed filters: far below what the estimate is known to, not below each digit of it.
            far = 1e-4 * final["std"]
            assert live["value"] == pytest.approx(final["value"], rel=1e-6, abs=far), method
            assert live["std"] == pytest.approx(final["std"], rel=1e-4), method


def test_the_identification_is_that_of_the_command_line(
    service: Service, finished: Json, tmp_path: Path
) -> None:
    folder = records(service, finished["id"])
    command = [sys.executable, "-m", "server", "identify", "--train", str(folder / "train.parquet")]
    command += ["--test", str(folder / "test.parquet"), "--sample-time", "0.1", "--out", str(tmp_path)]
    subprocess.run(command, check=True, capture_output=True)
    ours = service.client("read").get(f"{PATH}/{finished['id']}/identification").json()
    theirs = json.loads((tmp_path / "identification.json").read_text())
    for document in (ours, theirs):
        for method in document["methods"].values():
            method.pop("computing_time_s")  # the one figure that is not made of the data
    for phase in ("train", "test"):
        assert Path(ours["data"][phase].pop("file")).name == Path(theirs["data"][phase].pop("file")).name
    assert ours == theirs


def test_options_of_estimators_reach_the_identification(rested: Service) -> None:
    client = rested.client("run")
    estimators = [{"name": "rls", "options": {"forgetting": 0.995}}]
    session = create(client, {**BODY, "test": None, "estimators": estimators})
    client.post(f"{PATH}/{session}/start")
    reach(rested, client, session, "done")
    document = client.get(f"{PATH}/{session}/identification").json()
    assert document["methods"]["rls"]["weights"]["lam"] == 0.995


@pytest.mark.parametrize(
    ("change", "field", "words"),
    [
        ({"excitation": {**MULTISINE, "amplitude_A": 3}}, "excitation", "3 A"),
        ({"sample_time_s": 0.10001}, "sample_time_s", "0.1 s"),
        ({"estimators": [{"name": "rsl"}]}, "estimators.0.name", "rls"),
        ({"estimators": [{"name": "rls"}, {"name": "rls"}]}, "estimators.1.name", "twice"),
        (
            {"estimators": [{"name": "ls", "options": {"fogetting": 1}}]},
            f"{OF_FIRST}.fogetting",
            "forgetting",
        ),
        (
            {"estimators": [{"name": "ls", "options": {"forgetting": 1}}]},
            f"{OF_FIRST}.forgetting",
            "ls takes",
        ),
        (
            {"estimators": [{"name": "rls", "options": {"forgetting": 1.2}}]},
            f"{OF_FIRST}.forgetting",
            "(0, 1]",
        ),
        ({"order": 8, "sample_time_s": 2}, "duration_s", "rows"),
        ({"duration_s": -1}, "duration_s", "greater than 0"),
        ({"rig": "absent"}, None, "absent"),
    ],
)
def test_what_cannot_be_done_is_refused_with_its_field(
    service: Service, change: Json, field: str | None, words: str
) -> None:
    answer = service.client("run").post(PATH, json={**BODY, **change})
    assert answer.status_code in (404, 422)
    problem = answer.json()
    assert problem.get("field") == field
    assert words in problem["detail"] + problem["remedy"]


def test_sessions_are_listed_newest_first_by_page_and_by_state(service: Service, finished: Json) -> None:
    client = service.client("run")
    newest = create(client, {**BODY, "name": "waits"})
    page = client.get(PATH, params={"limit": 1}).json()
    assert [each["id"] for each in page["items"]] == [newest]
    rest = client.get(PATH, params={"before": page["next_before"]}).json()["items"]
    assert finished["id"] in [each["id"] for each in rest]
    assert newest not in [each["id"] for each in rest]
    waiting = client.get(PATH, params={"state": "created", "rig": RIG, "name": "waits"}).json()["items"]
    assert {each["state"] for each in waiting} == {"created"}


@pytest.mark.parametrize("before", ["", "0" * 31, "0" * 32])
def test_a_list_continues_after_a_session_that_exists_only(service: Service, before: str) -> None:
    answer = service.client("read").get(PATH, params={"before": before})
    assert answer.status_code == 422
    assert "before" in answer.text


@pytest.mark.parametrize("value", [0, "yes", None])
def test_centring_is_true_or_false_and_nothing_else(service: Service, value: object) -> None:
    answer = service.client("run").post(PATH, json={**BODY, "centring": value})
    assert answer.status_code == 422
    assert "centring" in answer.text


def test_a_session_is_not_started_twice(service: Service, finished: Json) -> None:
    problem = service.client("run").post(f"{PATH}/{finished['id']}/start").json()
    assert (problem["status"], problem["type"]) == (409, "/problems/conflict")


def test_a_rig_held_by_somebody_else_refuses_the_start(rested: Service) -> None:
    client = rested.client("run")
    session = create(client, BODY)
    with rested.hold(rested.client("admin")):
        problem = client.post(f"{PATH}/{session}/start").json()
    assert (problem["status"], problem["type"]) == (409, "/problems/lease")
    assert client.get(f"{PATH}/{session}").json()["state"] == "created"


def test_live_estimates_come_while_the_record_is_made_and_a_stop_identifies_what_there_is(
    real_time: Service,
) -> None:
    client = real_time.client("run")
    session = create(client, LONG)
    client.post(f"{PATH}/{session}/start")
    live = learning(real_time, client, session)
    rls = live["estimators"]["rls"]
    assert {each["name"] for each in rls["parameters"]} == {"a1", "a2", "b0", "b1"}
    assert rls["prediction"] is not None
    assert live["samples"]["received"] == live["samples"]["expected"] > 0
    assert client.get(f"/api/v1/rigs/{RIG}").json()["lease"]["holder"] == "test run"
    client.post(f"{PATH}/{session}/stop")
    view = reach(real_time, client, session, "stopped")
    assert view["figures"]["identification"]["rls"]["parameters"]
    assert client.get(f"/api/v1/rigs/{RIG}").json()["lease"] is None


def test_pause_brings_the_drive_to_rest_and_resume_records_anew(real_time: Service) -> None:
    client = real_time.client("run")
    session = create(client, {**LONG, "test": None})
    client.post(f"{PATH}/{session}/start")
    learning(real_time, client, session)
    client.post(f"{PATH}/{session}/pause")
    view = reach(real_time, client, session, "paused")
    rig = client.get(f"/api/v1/rigs/{RIG}").json()
    assert (rig["armed"], rig["lease"]["holder"]) == (False, "test run")
    assert view["possible"] == ["resume", "stop", "abort"]
    client.post(f"{PATH}/{session}/resume")
    real_time.wait_for(
        lambda: client.get(f"/api/v1/rigs/{RIG}").json()["drive"]["state"] == "running", "the drive to run"
    )
    client.post(f"{PATH}/{session}/abort")
    reach(real_time, client, session, "aborted")
    names = {path.name for path in records(real_time, session).glob("*.parquet")}
    assert names == {"train.parquet", "train.paused1.parquet"}


def test_an_estop_ends_the_session_as_tripped_with_cause_and_remedy(real_time: Service) -> None:
    client = real_time.client("arm")
    session = create(client, LONG)
    client.post(f"{PATH}/{session}/start")
    learning(real_time, client, session)
    real_time.client("read").post(f"/api/v1/rigs/{RIG}/estop")
    view = reach(real_time, client, session, "tripped")
    assert "stop" in view["reason"]
    assert view["recording_id"]
    with real_time.hold(client) as lease:
        assert client.post(f"/api/v1/rigs/{RIG}/clear-fault", headers=lease).status_code == 200


def test_who_takes_the_rig_over_ends_the_session_by_name(real_time: Service) -> None:
    client, other = real_time.client("run"), real_time.client("admin")
    session = create(client, LONG)
    client.post(f"{PATH}/{session}/start")
    learning(real_time, client, session)
    taken = other.post(f"/api/v1/rigs/{RIG}/lease", json={"take_over": True})
    assert taken.status_code == 201
    view = reach(real_time, client, session, "interrupted")
    assert view["reason"] == "first admin took over the rig; the drive came to rest first"
    other.delete(f"/api/v1/rigs/{RIG}/lease", headers={"Jointscope-Lease": taken.json()["id"]})


def test_the_end_of_the_service_interrupts_a_session_with_the_reason(
    start_service: Callable[..., Service], tmp_path: Path
) -> None:
    first = start_service(speed="1")
    first.connect()
    client = first.client()
    session = create(client, LONG)
    client.post(f"{PATH}/{session}/start")
    learning(first, client, session)
    assert first.stop() == 0
    second = start_service(token=first.admin_token)
    view = second.client().get(f"{PATH}/{session}").json()
    assert (view["state"], view["recording_id"] is not None) == ("interrupted", True)
    assert "the service was ended" in view["reason"]
