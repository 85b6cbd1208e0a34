"""Who may do what: every operation with every scope, and without a token."""

import re

import httpx
import pytest

from tests.server.service.conftest import RIG, Service

SCOPES = ("read", "run", "arm", "admin")
# Operation -> lowest scope. A new operation is refused by `test_every_operation_has_its_scope_written_down`.
NEEDED = {
    "GET /api/v1/rigs": "read",
    "GET /api/v1/rigs/{rig_id}": "read",
    "POST /api/v1/rigs/{rig_id}/connect": "run",
    "POST /api/v1/rigs/{rig_id}/disconnect": "run",
    "POST /api/v1/rigs/{rig_id}/estop": "read",
    "POST /api/v1/rigs/{rig_id}/clear-fault": "arm",
    "GET /api/v1/rigs/{rig_id}/parameters": "read",
    "GET /api/v1/rigs/{rig_id}/parameters/{name}": "read",
    "PUT /api/v1/rigs/{rig_id}/parameters/{name}": "run",
    "GET /api/v1/rigs/{rig_id}/link": "read",
    "POST /api/v1/rigs/{rig_id}/capture": "run",
    "GET /api/v1/rigs/{rig_id}/capture": "read",
    "GET /api/v1/rigs/{rig_id}/lease": "read",
    "POST /api/v1/rigs/{rig_id}/lease": "run",
    "PUT /api/v1/rigs/{rig_id}/lease": "run",
    "DELETE /api/v1/rigs/{rig_id}/lease": "run",
    "GET /api/v1/sessions": "read",
    "POST /api/v1/sessions": "run",
    "GET /api/v1/sessions/{session_id}": "read",
    "GET /api/v1/sessions/{session_id}/identification": "read",
    "POST /api/v1/sessions/{session_id}/start": "run",
    "POST /api/v1/sessions/{session_id}/pause": "run",
    "POST /api/v1/sessions/{session_id}/resume": "run",
    "POST /api/v1/sessions/{session_id}/stop": "run",
    "POST /api/v1/sessions/{session_id}/abort": "run",
    "GET /api/v1/campaigns": "read",
    "POST /api/v1/campaigns": "run",
    "GET /api/v1/campaigns/{campaign_id}": "read",
    "GET /api/v1/campaigns/{campaign_id}/document": "read",
    "POST /api/v1/campaigns/{campaign_id}/pause": "run",
    "POST /api/v1/campaigns/{campaign_id}/resume": "run",
    "POST /api/v1/campaigns/{campaign_id}/stop": "run",
    "POST /api/v1/campaigns/{campaign_id}/abort": "run",
    "POST /api/v1/campaigns/{campaign_id}/requeue": "run",
    "GET /api/v1/rigs/{rig_id}/queue": "read",
    "PUT /api/v1/rigs/{rig_id}/queue": "run",
    "POST /api/v1/tickets": "read",
    "GET /api/v1/events": "read",
    "GET /api/v1/events/stream": "read",
    "GET /api/v1/tokens": "admin",
    "POST /api/v1/tokens": "admin",
    "GET /api/v1/tokens/me": "read",
    "DELETE /api/v1/tokens/{token_id}": "admin",
    "GET /api/v1/audit": "admin",
    "GET /api/v1/recordings": "read",
    "POST /api/v1/recordings": "run",
    "GET /api/v1/recordings/{recording_id}": "read",
    "DELETE /api/v1/recordings/{recording_id}": "run",
    "GET /api/v1/recordings/{recording_id}/samples": "read",
    "GET /api/v1/recordings/{recording_id}/file": "read",
    "POST /api/v1/recordings/{recording_id}/undelete": "run",
    "POST /api/v1/recordings/{recording_id}/purge": "admin",
    "GET /api/v1/models": "read",
    "POST /api/v1/models": "run",
    "GET /api/v1/models/{model_id}": "read",
    "GET /api/v1/models/{model_id}/file": "read",
    "GET /api/v1/discrepancies": "read",
    "POST /api/v1/discrepancies": "run",
    "GET /api/v1/discrepancies/{analysis_id}": "read",
    "POST /api/v1/discrepancies/{analysis_id}/cancel": "run",
    "GET /api/v1/discrepancies/{analysis_id}/gap": "read",
    "GET /api/v1/discrepancies/{analysis_id}/report": "read",
}
METHODS = ("get", "post", "put", "patch", "delete")


def operations(service: Service) -> dict[str, dict[str, object]]:
    """Return every documented operation by method and path."""
    paths = service.client(None).get("/openapi.json").json()["paths"]
    return {
        f"{method.upper()} {path}": each
        for path, item in paths.items()
        for method, each in item.items()
        if method in METHODS
    }


def send(client: httpx.Client, operation: str) -> httpx.Response:
    """Send an operation with a body that no operation takes, to a rig that is not there: nothing must happen."""
    method, path = operation.split(" ")
    path = re.sub(r"\{\w+\}", "nobody", path)
    return client.request(method, path, json=None if method == "GET" else {"no": "such key"})


def test_every_operation_has_its_scope_written_down(service: Service) -> None:
    assert {name for name in operations(service) if "/api/v1" in name} == set(NEEDED)


@pytest.mark.parametrize("operation", NEEDED)
def test_an_operation_without_a_token_is_refused(service: Service, operation: str) -> None:
    answer = send(service.client(None), operation)
    assert answer.status_code == 401
    assert answer.headers["www-authenticate"].startswith("Bearer")


@pytest.mark.parametrize("scope", SCOPES)
@pytest.mark.parametrize("operation", [each for each in NEEDED if not each.endswith("/stream")])
def test_an_operation_needs_its_scope(service: Service, operation: str, scope: str) -> None:
    refused = send(service.client(scope), operation).status_code == 403
    # What is refused for another reason (no such rig) came past the scopes, or did not get to them: 404 comes first.
    if "{" in operation and "token" not in operation:
        answer = send_to_rig(service.client(scope), operation)
        refused = answer.status_code == 403
    assert refused == (SCOPES.index(scope) < SCOPES.index(NEEDED[operation]))


def send_to_rig(client: httpx.Client, operation: str) -> httpx.Response:
    """Send an operation to the emulated rig with a lease that does not exist, which refuses it behind the scopes."""
    method, path = operation.split(" ")
    path = path.replace("{rig_id}", RIG).replace("{name}", "current_limit_A")
    body = {"no": "such key"} if method != "GET" and path.endswith(("capture", "lease", "_A")) else None
    return client.request(method, path, json=body, headers={"Jointscope-Lease": "none"})


def test_a_revoked_token_is_refused(service: Service) -> None:
    admin = service.client()
    made = admin.post("/api/v1/tokens", json={"name": "short-lived", "scopes": ["read"]}).json()
    headers = {"Authorization": f"Bearer {made['secret']}"}
    stranger = service.client(None)
    assert stranger.get("/api/v1/rigs", headers=headers).status_code == 200
    assert admin.delete(f"/api/v1/tokens/{made['token']['id']}").json()["revoked_at"]
    assert stranger.get("/api/v1/rigs", headers=headers).status_code == 401


def test_secrets_are_nowhere_in_the_data_folder(service: Service) -> None:
    secret = service.token("run").encode()
    assert all(secret not in path.read_bytes() for path in service.data.rglob("*") if path.is_file())
