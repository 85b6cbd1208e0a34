"""Campaigns over REST: dry run, queue, control, restart; against the real process and the emulated controller."""

import random
from collections.abc import Callable, Iterator
from typing import Any

import httpx
import pytest

from tests.server.service.conftest import CONFIG, RIG, Service, launch
from tests.server.service.killing import kill_and_restart, submit

PATH = "/api/v1/campaigns"
QUEUE = f"/api/v1/rigs/{RIG}/queue"
YAML = {"content-type": "application/yaml"}
QUICK = (CONFIG / "campaigns" / "quick.yaml").read_text(encoding="utf-8")
LONG = """name: long
rig: emulated
steps:
  - record:
      name: one
      duration_s: 600
      excitation: {kind: sine, amplitude_A: 0.5, period_s: 5, ramp_s: 0.5}
  - wait: {seconds: 1}
"""
OVER = ("done", "stopped", "aborted", "tripped", "refused", "failed", "cancelled", "interrupted")
Json = dict[str, Any]  # JSON values
Start = Callable[..., Service]


@pytest.fixture(scope="module")
def real_time(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    """Give a service whose rig keeps real time, so that a step can be met under way."""
    started = launch(tmp_path_factory.mktemp("campaigns") / "data", speed="1")
    started.connect()
    yield started
    started.stop()


def post(client: httpx.Client, text: str, **query: str) -> httpx.Response:
    return client.post(PATH, content=text, headers=YAML, params=query)


def reach(service: Service, client: httpx.Client, campaign: str, *states: str) -> Json:
    def look() -> Json | None:
        view: Json = client.get(f"{PATH}/{campaign}").json()
        assert view["state"] in states or view["state"] not in OVER, view["reason"]
        return view if view["state"] in states else None

    found: Json = service.wait_for(look, f"a campaign that is {' or '.join(states)}")
    return found


def recording(service: Service, client: httpx.Client, campaign: str) -> None:
    """Wait until samples of the campaign's record come."""

    def look() -> bool:
        progress = client.get(f"{PATH}/{campaign}").json()["progress"]
        return bool(progress and progress["samples_received"] > 0)

    service.wait_for(look, "the first samples")


def test_a_dry_run_predicts_every_step_and_moves_and_keeps_nothing(rested: Service) -> None:
    client = rested.client("run")
    before = len(client.get(PATH).json()["items"])
    answer = post(client, QUICK, dry_run="true")
    forecast = answer.json()
    assert (answer.status_code, forecast["rig_id"], forecast["duration_s"]) == (200, RIG, 31.0)
    predicted = forecast["steps"][1]["predicted"]
    assert -29.8 < predicted["position_min_rad"] < predicted["position_max_rad"] < 29.8
    assert forecast["steps"][1]["samples"] == 50_000
    assert len(client.get(PATH).json()["items"]) == before


def test_a_campaign_is_played_to_its_end_and_its_recordings_are_listed(rested: Service) -> None:
    client = rested.client("run")
    made = post(client, QUICK)
    assert made.status_code == 201
    view = reach(rested, client, made.json()["id"], "done")
    assert [item["state"] for item in view["items"]] == ["done"] * 5
    assert view["items"][1]["figures"]["samples_lost"] == 0
    assert all(view["items"][step]["recording_id"] for step in (1, 3))
    run = rested.data / "campaigns" / view["id"] / "run-1"
    assert {path.name for path in run.iterdir()} >= {"manifest.json", "identification.json", "records"}


def test_the_same_campaign_as_json_gives_the_same_forecast(rested: Service) -> None:
    client = rested.client("run")
    record = {
        "name": "a",
        "duration_s": 5,
        "excitation": {"kind": "sine", "amplitude_A": 5e-1, "period_s": 5},
    }
    document = {"name": "trial", "rig": RIG, "steps": [{"record": record}]}
    as_json = client.post(PATH, json=document, params={"dry_run": True}).json()
    text = (
        f"name: trial\nrig: {RIG}\nsteps:\n"
        "  - record: {name: a, duration_s: 5, excitation: {kind: sine, amplitude_A: 0.5, period_s: 5}}\n"
    )
    assert as_json == post(client, text, dry_run="true").json()
    assert as_json["steps"][0]["predicted"]["peak_current_a"] == pytest.approx(0.5, rel=0.01)


@pytest.mark.parametrize(
    ("text", "field", "words"),
    [
        (QUICK.replace("0.8", "8"), "steps[1].record.excitation.amplitude_A", "less than or equal to 4"),
        (QUICK.replace("0.8", "3"), "steps[1].record.excitation", "limit"),
        (QUICK.replace("seed: 7", "sed: 7"), "steps[1].record.excitation.sed", 'did you mean "seed"'),
        (QUICK.replace("emulated.yaml", "absent.yaml"), "rig", "absent.yaml"),
        ("name: [", None, "not valid YAML"),
        ("name: !!python/object/apply:os.getcwd []\nsteps: []", None, "not valid YAML"),
        (
            LONG.replace("wait: {seconds: 1}", "gap: {model: /etc/passwd, train: one, test: one}"),
            "steps[1].gap.model",
            "this service has joint1.yaml",
        ),
    ],
)
def test_what_is_wrong_in_a_campaign_is_named_without_any_path_of_the_server(
    rested: Service, text: str, field: str | None, words: str
) -> None:
    answer = post(rested.client("run"), text)
    problem = answer.json()
    assert answer.status_code == 422, problem
    assert problem.get("field") == field
    assert words in problem["detail"]
    assert str(rested.data) not in answer.text


def test_a_queue_is_held_put_into_order_and_released(rested: Service) -> None:
    client = rested.client("run")
    assert client.put(QUEUE, json={"held": True}).json()["held"]
    first, second = (post(client, QUICK).json()["id"] for _ in range(2))
    waiting = client.put(QUEUE, json={"order": [second, first]}).json()["waiting"]
    assert [each["id"] for each in waiting] == [second, first]
    assert f'jointscope_queue_length{{rig="{RIG}"}} 2.0' in client.get("/metrics").text
    problem = client.put(QUEUE, json={"order": [second]}).json()
    assert (problem["status"], problem["field"]) == (422, "order")
    client.post(f"{PATH}/{first}/abort")
    assert client.get(f"{PATH}/{first}").json()["state"] == "cancelled"
    client.put(QUEUE, json={"held": False})
    reach(rested, client, second, "done")
    assert client.get(QUEUE).json() == {"rig_id": RIG, "held": False, "waiting": []}


@pytest.mark.parametrize("body", [{"held": 0}, {"held": "yes"}, {"order": [""]}, {"order": ["0" * 32]}])
def test_a_wrong_change_of_the_queue_is_refused(rested: Service, body: dict[str, object]) -> None:
    client = rested.client("run")
    before = client.get(QUEUE).json()
    assert client.put(QUEUE, json=body).status_code == 422
    assert client.get(QUEUE).json() == before


def test_a_campaign_waits_while_somebody_else_holds_the_rig(rested: Service) -> None:
    client = rested.client("run")
    with rested.hold(rested.client("admin")):
        campaign = post(client, QUICK).json()["id"]
        assert client.get(f"{PATH}/{campaign}").json()["state"] == "queued"
        assert client.get(f"/api/v1/rigs/{RIG}").json()["busy_with"] is None
    reach(rested, client, campaign, "done")


def test_a_campaign_of_a_revoked_token_does_not_begin(rested: Service) -> None:
    admin = rested.client()
    made = admin.post("/api/v1/tokens", json={"name": "leaves", "scopes": ["run"]}).json()
    admin.put(QUEUE, json={"held": True})
    bearer = {"Authorization": f"Bearer {made['secret']}"}
    answer = rested.client(None).post(PATH, content=QUICK, headers={**YAML, **bearer})
    admin.delete(f"/api/v1/tokens/{made['token']['id']}")
    admin.put(QUEUE, json={"held": False})
    view = reach(rested, admin, answer.json()["id"], "refused")
    assert view["reason"] == "the token of leaves is not valid any more"


def test_pause_resume_and_stop_end_with_the_recordings_kept(real_time: Service) -> None:
    client = real_time.client("run")
    campaign = post(client, LONG).json()["id"]
    recording(real_time, client, campaign)
    client.post(f"{PATH}/{campaign}/pause")
    reach(real_time, client, campaign, "paused")
    assert client.get(f"/api/v1/rigs/{RIG}").json()["armed"] is False
    client.post(f"{PATH}/{campaign}/resume")
    real_time.wait_for(lambda: client.get(f"/api/v1/rigs/{RIG}").json()["armed"], "the drive to run again")
    client.post(f"{PATH}/{campaign}/stop")
    view = reach(real_time, client, campaign, "stopped")
    assert [item["state"] for item in view["items"]] == ["stopped", "cancelled"]
    folder = real_time.data / "campaigns" / campaign / "run-1" / "records"
    assert {path.name for path in folder.glob("*.parquet")} == {"one.paused1.parquet", "one.parquet"}


def test_a_requeued_campaign_starts_again_in_a_folder_of_its_own(real_time: Service) -> None:
    client = real_time.client("run")
    campaign = post(client, LONG).json()["id"]
    recording(real_time, client, campaign)
    client.post(f"{PATH}/{campaign}/abort")
    reach(real_time, client, campaign, "aborted")
    assert client.post(f"{PATH}/{campaign}/requeue").status_code == 202
    recording(real_time, client, campaign)
    client.post(f"{PATH}/{campaign}/abort")
    reach(real_time, client, campaign, "aborted")
    runs = sorted(path.name for path in (real_time.data / "campaigns" / campaign).glob("run-*"))
    assert runs == ["run-1", "run-2"]


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_after_a_kill_nothing_recorded_is_missing_and_nothing_runs_again_by_itself(
    start_service: Start, seed: int
) -> None:
    first = start_service(speed="1")
    first.connect()
    client = first.client()
    campaign, waits = submit(client), submit(client)
    recording(first, client, campaign)
    more = random.Random(seed).randrange(
        12_000
    )  # samples of the 3 s that a record lasts, and of what follows
    first.wait_for(
        lambda: (
            (view := client.get(f"{PATH}/{campaign}").json())["progress"] is None
            or view["progress"]["step"] > 0
            or view["progress"]["samples_received"] > more
        ),
        "the moment to kill",
    )
    second, aftermath = kill_and_restart(
        first, campaign, lambda: start_service(speed="1", token=first.admin_token)
    )
    assert aftermath.faults == ()
    assert aftermath.state == ("running", "interrupted")
    queue = second.client().get(QUEUE).json()
    assert (queue["held"], [each["id"] for each in queue["waiting"]]) == (True, [waits])
