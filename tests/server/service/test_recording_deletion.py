"""Deletion of recordings: taken back, purged at once, purged when due."""

from collections.abc import Callable

from tests.server.service.conftest import Service
from tests.server.service.measured import upload

PATH = "/api/v1/recordings"


def test_a_deleted_recording_can_be_taken_back(service: Service) -> None:
    client = service.client("run")
    path = f"{PATH}/{upload(client, 'mistake')['id']}"
    deleted = client.delete(path).json()
    assert deleted["purge_at"] > deleted["deleted_at"]
    assert client.get(f"{path}/samples").json()["remedy"].endswith("/undelete first")
    assert deleted["id"] in [
        each["id"] for each in client.get(PATH, params={"deleted": True}).json()["items"]
    ]
    assert client.post(f"{path}/undelete").json()["deleted_at"] is None
    assert client.get(f"{path}/samples").status_code == 200


def test_a_purged_recording_is_gone_for_good(service: Service) -> None:
    admin = service.client("admin")
    made = upload(admin, "gone")
    path = f"{PATH}/{made['id']}"
    assert admin.post(f"{path}/purge").status_code == 409
    admin.delete(path)
    assert admin.post(f"{path}/purge").json()["purged"]
    assert admin.post(f"{path}/undelete").status_code == 409
    assert not list(service.data.rglob("gone.parquet"))


def test_what_is_due_is_purged_at_the_next_start(start_service: Callable[..., Service]) -> None:
    service = start_service("--grace-days", "0")
    client = service.client()
    made, kept = upload(client, "due"), upload(client, "kept")
    client.delete(f"{PATH}/{made['id']}")
    service.stop()
    again = start_service("--grace-days", "0", data=service.data, token=service.admin_token)
    again.wait_for(lambda: again.client().get(f"{PATH}/{made['id']}").json()["purged"], "the purge")
    assert again.client().get(f"{PATH}/{kept['id']}/samples").status_code == 200
    assert not list(service.data.rglob("due.parquet"))
