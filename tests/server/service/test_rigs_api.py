"""Rigs over REST, against the real service process and the real emulator."""

import pytest

from tests.server.service.conftest import LEASE, RIG, Service

PATH = f"/api/v1/rigs/{RIG}"
LIMIT = f"{PATH}/parameters/current_limit_A"


def test_a_connected_rig_tells_its_state(service: Service) -> None:
    rig = service.client("read").get(PATH).json()
    assert (rig["connection"], rig["armed"], rig["emulated"]) == ("connected", False, True)
    assert rig["controller"]["tick_hz"] == 2500
    assert rig["drive"]["bus_voltage_v"] == pytest.approx(540.0, abs=20.0)


def test_a_parameter_is_written_under_a_lease_and_read_back_with_its_unit(rested: Service) -> None:
    client = rested.client("run")
    with rested.hold(client) as lease:
        written = client.put(LIMIT, json={"value": 1.5}, headers=lease).json()
        client.put(LIMIT, json={"value": 2.0}, headers=lease)
    assert (written["value"], written["unit"], written["maximum"]) == (1.5, "A", 2.0)


def test_a_value_beyond_the_controllers_limit_names_field_value_and_remedy(rested: Service) -> None:
    client = rested.client("run")
    with rested.hold(client) as lease:
        answer = client.put(LIMIT, json={"value": 150}, headers=lease)
    problem = answer.json()
    assert answer.status_code == 422
    assert (problem["field"], problem["value"]) == ("value", "150.0")
    assert problem["remedy"] == "give a value in [0, 2] A"


def test_writing_without_a_lease_is_refused(rested: Service) -> None:
    problem = rested.client("run").put(LIMIT, json={"value": 1.5}).json()
    assert (problem["status"], problem["type"], problem["field"]) == (409, "/problems/lease", LEASE)


def test_estop_needs_only_read_and_latches_until_it_is_cleared(rested: Service) -> None:
    assert rested.client("read").post(f"{PATH}/estop").status_code == 200
    client = rested.client("arm")
    rested.wait_for(lambda: client.get(PATH).json()["drive"]["state"] == "fault", "the latched fault")
    assert [fault["name"] for fault in client.get(PATH).json()["drive"]["faults"]] == ["estop"]
    with rested.hold(client) as lease:
        assert client.post(f"{PATH}/clear-fault", headers=lease).status_code == 200
    rested.wait_for(lambda: client.get(PATH).json()["drive"]["state"] == "idle", "the cleared drive")


def test_estop_is_an_event_with_its_tick_and_a_line_of_the_audit_log(rested: Service) -> None:
    client = rested.client()
    client.post(f"{PATH}/estop")

    def stops() -> list[int]:
        page = client.get("/api/v1/events", params={"kind": "drive.estop", "rig": RIG}).json()
        return [event["tick"] for event in page["items"]]

    assert rested.wait_for(stops, "the event")[-1] > 0
    newest = client.get("/api/v1/audit", params={"resource": f"rigs/{RIG}"}).json()["items"]
    assert ("rig.estop", "done", "first admin") in [
        (line["action"], line["outcome"], line["token_name"]) for line in newest
    ]


def test_the_capture_buffer_is_read_in_si(rested: Service) -> None:
    client = rested.client("run")
    with rested.hold(client) as lease:
        started = client.post(f"{PATH}/capture", json={"layout": "control"}, headers=lease)
        capture = rested.wait_for(
            lambda: (answer := client.get(f"{PATH}/capture").json())["complete"] and answer, "the capture"
        )
    assert len(capture["columns"]["current_A"]) == started.json()["samples"]
    assert capture["sample_time_s"] == pytest.approx(4e-4)
    assert abs(capture["columns"]["position_rad"][0]) < 31.4


def test_a_level_that_can_never_be_measured_is_refused(rested: Service) -> None:
    client = rested.client("run")
    body = {"layout": "control", "trigger": "level", "column": "current_A", "level": 1000}
    with rested.hold(client) as lease:
        problem = client.post(f"{PATH}/capture", json=body, headers=lease).json()
    assert (problem["status"], problem["field"], problem["value"]) == (422, "level", "1000.0")


def test_link_statistics_count_what_was_received(service: Service) -> None:
    link = service.client("read").get(f"{PATH}/link").json()
    assert (link["baud"], link["bad_frames"]) == (937500, 0)


def test_a_rig_is_disconnected_and_connected_again(rested: Service) -> None:
    client = rested.client("run")
    assert client.post(f"{PATH}/disconnect").json()["connection"] == "disconnected"
    problem = client.get(f"{PATH}/parameters").json()
    assert (problem["type"], problem["remedy"]) == ("/problems/conflict", "connect it first")
    rested.connect()
    assert client.get(PATH).json()["connection"] == "connected"
