"""Joint models over REST."""

import httpx
import pytest
import yaml

from tests.server.service.conftest import Service
from tests.server.service.measured import MODEL

PATH = "/api/v1/models"


def upload(client: httpx.Client, name: str, **params: str) -> httpx.Response:
    """Upload the model under another name."""
    return client.post(PATH, params=params, content=MODEL.replace("bench", name))


def test_a_model_gets_the_next_version_of_its_name(service: Service) -> None:
    client = service.client("run")
    first = upload(client, "versions").json()
    second = upload(client, "versions", note="again", parent=first["id"]).json()
    assert (first["version"], second["version"], second["document"]["version"]) == (1, 2, 2)
    assert second["lineage"] == [{"kind": "model", "id": first["id"]}]
    assert first["created_by"] == "test run"
    listed = client.get(PATH, params={"name": "versions"}).json()["items"]
    assert [each["version"] for each in listed] == [2, 1]
    of_first = client.get(PATH, params={"source": first["id"]}).json()["items"]
    assert [each["id"] for each in of_first] == [second["id"]]


def test_the_file_of_a_version_reads_back(service: Service) -> None:
    client = service.client("run")
    made = upload(client, "file").json()
    answer = client.get(f"{PATH}/{made['id']}/file")
    assert answer.headers["content-type"].startswith("application/yaml")
    assert yaml.safe_load(answer.text) == made["document"]


def test_pages_go_on(service: Service) -> None:
    client = service.client("run")
    for _ in range(3):
        upload(client, "paged")
    page = client.get(PATH, params={"name": "paged", "limit": 2}).json()
    rest = client.get(PATH, params={"name": "paged", "limit": 2, "offset": page["next_offset"]}).json()
    assert [each["version"] for each in page["items"] + rest["items"]] == [3, 2, 1]
    assert rest["next_offset"] is None


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("parameters: {inertia: 1, friction: 2}", "parameters.friction: unknown parameter"),
        ("- 1", "a model file is a mapping"),
        ("a: [", "not readable: line"),
        ("a: &a [x]\nb: *a", "references"),
        ("!!python/object/apply:os.system [ls]", "could not determine a constructor"),
        ("[" * 5000, "not readable"),
        ("parameters: {inertia: .nan}", "not readable"),
        ('name: "\\ud800"\nparameters: {inertia: 1}', "not readable"),
        ("parameters: {inertia: 1}\nversion: .inf", "not readable"),
        ("parameters: {inertia: 1}\nlineage: 5", "a list is needed"),
        (f"name: {'a' * 121}\nparameters: {{inertia: 1}}", "name: 1..120 characters"),
        (b"\xff", "not readable"),
        (b"", "a model file is a mapping"),
    ],
)
def test_what_is_no_model_is_refused(service: Service, content: str | bytes, message: str) -> None:
    answer = service.client("run").post(PATH, content=content)
    assert (answer.status_code, answer.json()["type"]) == (422, "/problems/invalid-value")
    assert message in answer.json()["detail"]


def test_an_unknown_parent_is_refused(service: Service) -> None:
    assert upload(service.client("run"), "orphan", parent="nobody").status_code == 404
