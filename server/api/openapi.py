"""The OpenAPI document: FastAPI's, with the one error shape instead of FastAPI's own, for every operation."""

from collections.abc import Mapping
from typing import Any

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi

from server.api.examples.answers import answer_examples
from server.api.examples.requests import BODIES, DOCUMENTS
from server.api.problems import MEDIA_TYPE, Problem

DESCRIPTION = (
    "Identification sessions, campaigns and analyses of motor-driven robot joints. Every address below /api/v1 "
    "needs a bearer token; every error is a problem document (RFC 9457) with a stable type, the field, the value "
    "and the remedy."
)
_PROBLEM_REF = {"content": {MEDIA_TYPE: {"schema": {"$ref": "#/components/schemas/Problem"}}}}
_EVERYWHERE = {
    "404": "There is no such thing.",
    "503": "The service or the rig cannot answer now.",
}
_BEHIND_A_TOKEN = {
    "400": "The request broke off.",
    "401": "No valid token.",
    "403": "The token may not do that.",
    "409": "Not possible in the present state.",
    "413": "The request is too large.",
    "422": "The request is wrong.",
    "429": "Too many wrong tokens.",
}
Json = dict[str, Any]  # JSON values


def install(app: FastAPI) -> None:
    """Let `app` serve the document that `build` makes."""

    def openapi() -> Json:
        if app.openapi_schema is None:
            app.openapi_schema = build(app)
        return app.openapi_schema

    app.openapi = openapi  # type: ignore[method-assign]  # FastAPI's documented way to change the document


def build(app: FastAPI) -> Json:
    """Return the document of all routes of `app`."""
    document = get_openapi(title=app.title, version=app.version, description=DESCRIPTION, routes=app.routes)
    answers = answer_examples()
    for path, operations in document["paths"].items():
        for operation in operations.values():
            _add_problems(operation, open_to_all=not path.startswith("/api/"))
            _add_examples(operation, path, answers)
    schemas = document.setdefault("components", {}).setdefault("schemas", {})
    for name in ("HTTPValidationError", "ValidationError"):
        schemas.pop(name, None)
    schemas["Problem"] = Problem.model_json_schema(ref_template="#/components/schemas/{model}")
    return document


def _add_examples(operation: Json, path: str, answers: Mapping[str, Json]) -> None:
    """Show whole bodies: of requests, and of answers that a schema of ours describes."""
    for media_type, content in operation.get("requestBody", {}).get("content", {}).items():
        found = BODIES.get(_schema_name(content), DOCUMENTS.get((path, media_type)))
        if found is not None:
            content["example"] = found
    for status, response in operation["responses"].items():
        for content in response.get("content", {}).values() if status.startswith("2") else ():
            if (found := answers.get(_schema_name(content))) is not None:
                content["example"] = found


def _schema_name(content: Json) -> str:
    """Return the name of a body's schema, the first where there are several; empty without one."""
    schema = content.get("schema", {})
    chosen = schema.get("anyOf", [schema])[0]
    return str(chosen.get("$ref", "")).rpartition("/")[2]


def _add_problems(operation: Json, *, open_to_all: bool) -> None:
    """Document every problem; what FastAPI says of 422 is not what this service answers."""
    responses = operation["responses"]
    responses.pop("422", None)
    # No 4XX or 5XX for everything: a check against this document must be able to fail. 500 is a defect, not an answer.
    problems = _EVERYWHERE if open_to_all else _EVERYWHERE | _BEHIND_A_TOKEN
    for status, words in sorted(problems.items()):
        responses[status] = {"description": words, **_PROBLEM_REF}
