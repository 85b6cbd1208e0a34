"""One shape for every error of every operation, found by walking the OpenAPI document."""

import httpx
import pytest

from tests.server.service.conftest import Service
from tests.server.service.test_access_api import NEEDED, operations, send

KEYS = {"type", "title", "status", "detail", "instance", "remedy"}


def assert_problem(answer: httpx.Response, *statuses: int) -> None:
    """Check an answer's shape."""
    assert answer.status_code in statuses, answer.text
    assert answer.headers["content-type"] == "application/problem+json"
    problem = answer.json()
    assert set(problem) - {"field", "value"} == KEYS
    assert problem["status"] == answer.status_code
    assert problem["type"].startswith("/problems/")
    assert all(problem[key] for key in KEYS)


@pytest.mark.parametrize("operation", NEEDED)
def test_every_operation_answers_a_stranger_with_a_problem(service: Service, operation: str) -> None:
    assert_problem(send(service.client(None), operation), 401)


@pytest.mark.parametrize(
    "operation",
    # A ticket is made of nothing but the token: nothing of it can be wrong.
    [each for each in NEEDED if ("{" in each or each.startswith("POST")) and not each.endswith("/tickets")],
)
def test_every_operation_answers_what_it_cannot_do_with_a_problem(service: Service, operation: str) -> None:
    assert_problem(send(service.client("admin"), operation), 404, 422)


@pytest.mark.parametrize("operation", NEEDED)
def test_a_method_that_a_path_does_not_have_is_a_problem(service: Service, operation: str) -> None:
    path = operation.split(" ")[1]
    assert_problem(service.client("admin").request("PATCH", path), 405)


def test_every_documented_operation_documents_the_problem(service: Service) -> None:
    for name, operation in operations(service).items():
        responses = operation["responses"]
        assert isinstance(responses, dict)
        # Every status by itself: a wildcard would let an answer that nobody thought of pass as documented.
        assert not {"4XX", "5XX", "500", "default"} & set(responses), name
        behind_a_token = ("400", "401", "403", "409", "413", "422", "429") if "/api/" in name else ()
        for status in ("404", "503", *behind_a_token):
            schema = responses[status]["content"]["application/problem+json"]["schema"]
            assert schema == {"$ref": "#/components/schemas/Problem"}, name


def test_an_address_that_does_not_exist_is_a_problem(service: Service) -> None:
    assert_problem(service.client("read").get("/api/v1/nothing"), 404)


def test_a_wrong_query_names_field_value_and_what_is_allowed(service: Service) -> None:
    answer = service.client("read").get("/api/v1/events", params={"limit": 0})
    assert_problem(answer, 422)
    assert (answer.json()["field"], answer.json()["value"]) == ("limit", "0")
    assert "greater than or equal to 1" in answer.json()["detail"]


def test_a_body_that_is_no_json_is_a_problem(service: Service) -> None:
    headers = {"content-type": "application/json"}
    assert_problem(service.client("admin").post("/api/v1/tokens", content=b"{", headers=headers), 422)


def test_a_body_that_is_no_text_is_a_problem(service: Service) -> None:
    headers = {"content-type": "application/json"}
    answer = service.client("admin").post("/api/v1/tokens", content=b"\xff.\xfe", headers=headers)
    assert_problem(answer, 422)
    assert (answer.json()["field"], answer.json()["detail"]) == (
        "body",
        "body: not readable as JSON in UTF-8",
    )


def test_a_stranger_learns_nothing_from_a_bodys_mistakes(service: Service) -> None:
    headers = {"content-type": "application/json"}
    answer = service.client(None).post("/api/v1/tokens", content=b"{", headers=headers)
    assert_problem(answer, 401)


def test_an_address_that_does_not_exist_needs_a_token_as_well(service: Service) -> None:
    assert_problem(service.client(None).get("/api/v1/nothing"), 401)


def test_a_body_beyond_the_limit_is_refused_whether_announced_or_not(service: Service) -> None:
    client, body = service.client("admin"), b" " * (1024 * 1024 + 1)
    assert_problem(client.post("/api/v1/tokens", content=body), 413)
    assert_problem(client.post("/api/v1/tokens", content=iter([body])), 413)
