"""The operator's lease over REST."""

from tests.server.service.conftest import LEASE, RIG, Service

PATH = f"/api/v1/rigs/{RIG}/lease"


def test_a_second_operator_is_refused_and_told_who_holds_the_rig(rested: Service) -> None:
    with rested.hold(rested.client("run")):
        problem = rested.client("arm").post(PATH, json={}).json()
    assert (problem["status"], problem["type"]) == (409, "/problems/lease")
    assert problem["detail"] == "test run holds this rig"


def test_the_loser_of_a_take_over_is_told_by_an_event_and_may_do_nothing_more(rested: Service) -> None:
    loser, winner = rested.client("run"), rested.client("arm")
    old = {LEASE: loser.post(PATH, json={}).json()["id"]}
    taken = winner.post(PATH, json={"take_over": True})
    assert taken.json()["holder"] == "test arm"
    assert loser.put(PATH, json={}, headers=old).json()["type"] == "/problems/lease"

    def told() -> bool:
        events = loser.get("/api/v1/events", params={"kind": "lease.taken_over", "limit": 500}).json()[
            "items"
        ]
        return any(event["data"]["holder"] == "test run" for event in events)

    rested.wait_for(told, "the event")
    winner.delete(PATH, headers={LEASE: taken.json()["id"]})


def test_a_lease_that_nobody_renews_ends_by_itself(rested: Service) -> None:
    client = rested.client("run")
    client.post(PATH, json={"ttl_s": 1.0})
    rested.wait_for(lambda: client.get(PATH).status_code == 404, "the end of the lease")

    def told() -> bool:
        return bool(client.get("/api/v1/events", params={"kind": "lease.expired"}).json()["items"])

    rested.wait_for(told, "the event")


def test_a_lease_is_given_back(rested: Service) -> None:
    client = rested.client("run")
    headers = {LEASE: client.post(PATH, json={}).json()["id"]}
    assert client.delete(PATH, headers=headers).status_code == 204
    assert client.get(PATH).status_code == 404
