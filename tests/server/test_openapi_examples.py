"""Every request body and main answer of the OpenAPI document has a whole example, and it is one."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jsonschema_rs
import pytest
import yaml

from server.api.app import create_app
from server.api.schemas.jobs import SessionBody
from server.config.campaign import Campaign
from server.services.estimator_choice import check_choices
from server.services.settings import ServiceSettings

Json = dict[str, Any]  # JSON values
DOCUMENT: Json = create_app(ServiceSettings(data_dir=Path("unused"))).openapi()
NO_EXAMPLE = {  # what is no JSON of ours, or documented elsewhere
    ("get", "/api/v1/sessions/{session_id}/identification"),
    ("get", "/api/v1/discrepancies/{analysis_id}/gap"),
    ("get", "/healthz"),
    ("get", "/readyz"),
}


def contents() -> Iterator[tuple[str, str, str, Json]]:
    """Give method, path, `request` or status, and content of every JSON body."""
    for path, operations in DOCUMENT["paths"].items():
        for method, operation in operations.items():
            for media_type, content in operation.get("requestBody", {}).get("content", {}).items():
                yield method, path, f"request {media_type}", content
            for status, response in operation["responses"].items():
                content = response.get("content", {}).get("application/json")
                if status.startswith("2") and content is not None:
                    yield method, path, status, content


ALL = [pytest.param(*each, id=f"{each[0]} {each[1]} {each[2]}") for each in contents()]


@pytest.mark.parametrize(("method", "path", "where", "content"), ALL)
def test_every_body_has_an_example_that_its_schema_takes(
    method: str, path: str, where: str, content: Json
) -> None:
    if (method, path) in NO_EXAMPLE:
        return
    schema = {**content["schema"], "components": DOCUMENT["components"]}
    given = content["example"]
    if "yaml" in where and schema.get("type") == "object":  # a document in YAML, shown as its text
        given = yaml.safe_load(given)
    jsonschema_rs.Draft202012Validator(schema, validate_formats=True).validate(given)


def test_examples_are_whole() -> None:
    for method, path, where, content in contents():
        name = content["schema"].get("$ref", "").rpartition("/")[2]
        if where.startswith("2") and name and (method, path) not in NO_EXAMPLE:
            fields = DOCUMENT["components"]["schemas"][name].get("properties", {})
            assert set(fields) == set(content["example"]), f"{method} {path}"


def example(path: str, media_type: str) -> Any:  # JSON values or text
    return DOCUMENT["paths"][path]["post"]["requestBody"]["content"][media_type]["example"]


def test_the_example_of_a_session_may_be_meant() -> None:
    spec = SessionBody.model_validate(example("/api/v1/sessions", "application/json")).to_spec()
    assert check_choices(spec.estimators) == {"forgetting": 0.995}


def test_the_examples_of_a_campaign_are_campaigns() -> None:
    for given in (
        example("/api/v1/campaigns", "application/json"),
        yaml.safe_load(example("/api/v1/campaigns", "application/yaml")),
    ):
        assert [step.step for step in Campaign.model_validate(given).steps] == ["record", "identify"]
