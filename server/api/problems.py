"""The one shape of every error: RFC 9457 problem details, `application/problem+json`.

`type` is stable and names the kind of problem (`/problems/lease`); `detail` says what happened here; `field` and
`value` say what of the request is wrong; `remedy` says what to do. Routers raise the services' errors and never
build these.
"""

import logging
import re
from dataclasses import dataclass
from http import HTTPStatus
from typing import Any

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from pydantic import BaseModel, Field
from starlette.exceptions import HTTPException

import daq.errors as daq_errors
from server import errors as server_errors
from server.services import errors as service_errors

MEDIA_TYPE = "application/problem+json"
_LOG = logging.getLogger(__name__)


class Problem(BaseModel):
    """Problem details (RFC 9457)."""

    type: str = Field(description="Stable name of the kind of problem.", examples=["/problems/lease"])
    title: str = Field(description="The kind of problem in a few words.")
    status: int = Field(description="HTTP status.")
    detail: str = Field(description="What happened here, for people.")
    instance: str = Field(description="Path of the request.")
    field: str | None = Field(default=None, description="What of the request is wrong.")
    value: str | None = Field(default=None, description="The value that stood there.")
    remedy: str = Field(description="What to do about it.")


@dataclass(frozen=True, slots=True, kw_only=True)
class Kind:
    """A kind of problem; `remedy` stands in where the error itself has none."""

    name: str
    title: str
    status: int
    remedy: str


UNAUTHENTICATED = Kind(
    name="unauthenticated",
    title="A valid token is needed",
    status=401,
    remedy="send `Authorization: Bearer TOKEN`; `jointscope token create` makes one",
)
FORBIDDEN = Kind(
    name="forbidden",
    title="This token may not do that",
    status=403,
    remedy="use a token with the scope named, or ask an admin for one",
)
VALIDATION = Kind(
    name="invalid-request",
    title="The request is wrong",
    status=422,
    remedy="correct the field named; /docs lists what is allowed",
)
INTERNAL = Kind(
    name="internal",
    title="The service failed",
    status=500,
    remedy="this is an error of the program: report it with the service's log",
)

# The first entry that an error is an instance of decides: subclasses stand before their parents.
KINDS: tuple[tuple[type[Exception], Kind], ...] = (
    (service_errors.NotFoundError, Kind(name="not-found", title="Not found", status=404, remedy="")),
    (
        service_errors.LeaseError,
        Kind(name="lease", title="The rig's lease is not yours", status=409, remedy=""),
    ),
    (service_errors.BusyError, Kind(name="busy", title="The rig is at work", status=409, remedy="")),
    (
        service_errors.ConflictError,
        Kind(name="conflict", title="Not possible in this state", status=409, remedy=""),
    ),
    (
        service_errors.InvalidValueError,
        Kind(name="invalid-value", title="A value is not allowed", status=422, remedy=""),
    ),
    (
        server_errors.InputError,
        Kind(
            name="invalid-input",
            title="The input is wrong",
            status=422,
            remedy="correct what the detail names",
        ),
    ),
    (
        server_errors.RigTrippedError,
        Kind(
            name="tripped",
            title="The drive tripped",
            status=409,
            remedy="remove the cause, then clear the fault",
        ),
    ),
    (
        daq_errors.DeviceFaultError,
        Kind(
            name="drive-fault",
            title="A fault is latched",
            status=409,
            remedy="remove the cause, then clear the fault",
        ),
    ),
    (
        daq_errors.DeviceRefusedError,
        Kind(name="refused", title="The controller refused", status=409, remedy="do what the detail says"),
    ),
    (
        daq_errors.ExcitationLimitError,
        Kind(
            name="beyond-limit",
            title="A limit of the rig would be exceeded",
            status=422,
            remedy="make it smaller",
        ),
    ),
    (
        daq_errors.WireBudgetError,
        Kind(
            name="wire-budget",
            title="The stream does not fit the line",
            status=422,
            remedy="take what the detail proposes",
        ),
    ),
    (
        daq_errors.RecordingError,
        Kind(name="recording", title="The recording is of no use here", status=422, remedy="see the detail"),
    ),
    (
        daq_errors.LinkTimeoutError,
        Kind(
            name="no-answer",
            title="The controller does not answer",
            status=503,
            remedy="check supply and cable",
        ),
    ),
    (
        daq_errors.DaqError,
        Kind(
            name="rig-unreachable",
            title="The rig cannot be reached",
            status=503,
            remedy="check port and cable",
        ),
    ),
    (
        service_errors.StorageError,
        Kind(
            name="storage",
            title="The database does not answer",
            status=503,
            remedy="try again; if it stays, look at the database server, or for space on the disk",
        ),
    ),
    (
        server_errors.RunFailedError,
        Kind(name="run-failed", title="The run failed", status=503, remedy="see the detail, then try again"),
    ),
)
_HTTP_TITLES = {
    404: ("not-found", "Not found"),
    405: ("method-not-allowed", "No such method here"),
    413: ("too-large", "The request is too large"),
}


class ProblemError(Exception):
    """A problem that the HTTP layer itself finds: authentication, headers, sizes."""

    def __init__(
        self, kind: Kind, detail: str, *, field: str | None = None, headers: dict[str, str] | None = None
    ) -> None:
        super().__init__(detail)
        self.kind = kind
        self.field = field
        self.headers = headers


def install(app: FastAPI) -> None:
    """Let every error of `app` leave it as a problem document."""
    app.add_exception_handler(ProblemError, _on_problem)
    app.add_exception_handler(RequestValidationError, _on_validation)
    app.add_exception_handler(HTTPException, _on_http)
    for error, _ in KINDS:
        app.add_exception_handler(error, _on_service)
    app.add_exception_handler(Exception, _on_unexpected)


def problem_response(request: Request, kind: Kind, detail: str, **more: Any) -> JSONResponse:  # JSON values
    """Return the answer for one problem; `more`: field, value, remedy, headers."""
    headers = more.pop("headers", None)
    problem = Problem(
        type=f"/problems/{kind.name}",
        title=kind.title,
        status=kind.status,
        detail=detail,
        instance=request.url.path,
        remedy=more.pop("remedy", None) or kind.remedy,
        **more,
    )
    content = problem.model_dump(exclude_none=True)
    return JSONResponse(content, status_code=kind.status, media_type=MEDIA_TYPE, headers=headers)


async def _on_problem(request: Request, error: Exception) -> JSONResponse:
    if not isinstance(error, ProblemError):
        raise error
    return problem_response(request, error.kind, str(error), field=error.field, headers=error.headers)


async def _on_service(request: Request, error: Exception) -> JSONResponse:
    kind = next(kind for kinds, kind in KINDS if isinstance(error, kinds))
    field, value = getattr(error, "field", None), getattr(error, "value", None)
    location = getattr(error, "location", None)
    if field is None and location is not None:
        field = location.field
    remedy = getattr(error, "remedy", None)
    text = str(error.args[0]) if error.args else str(error)
    return problem_response(
        request, kind, text, field=field, value=None if value is None else str(value), remedy=remedy
    )


async def _on_validation(request: Request, error: Exception) -> JSONResponse:
    if not isinstance(error, RequestValidationError):
        raise error
    first = error.errors()[0]
    where, *names = [str(part) for part in first["loc"]]
    field = ".".join(names) or where
    value = first.get("input")
    shown = None if isinstance(value, dict | list) else str(value)[:200]
    return problem_response(
        request, VALIDATION, f"{field}: {first['msg']} ({where})", field=field, value=shown
    )


async def _on_http(request: Request, error: Exception) -> JSONResponse:
    if not isinstance(error, HTTPException):
        raise error
    if error.status_code == HTTPStatus.BAD_REQUEST:
        # FastAPI's only one: a body that is no text. Broken JSON is 422, so is this.
        return problem_response(request, VALIDATION, "body: not readable as JSON in UTF-8", field="body")
    name, title = _HTTP_TITLES.get(error.status_code, ("http", "The request cannot be answered"))
    kind = Kind(name=name, title=title, status=error.status_code, remedy="see /docs for what there is")
    detail = f"{request.method} {request.url.path}: {error.detail}"
    headers = dict(error.headers or {})
    if error.status_code == HTTPStatus.METHOD_NOT_ALLOWED:
        headers["Allow"] = ", ".join(sorted(_methods_of(request)))
    return problem_response(request, kind, detail, headers=headers or None)


def _methods_of(request: Request) -> set[str]:
    """Return all methods of the request's path; the router knows only those of the first route that matches."""
    paths, methods = request.app.openapi()["paths"], set[str]()
    if request.url.path in paths:  # before a path of the same form with a name in it
        return {method.upper() for method in paths[request.url.path]}
    for template, operations in paths.items():
        parts = [r"[^/]+" if part.startswith("{") else re.escape(part) for part in template.split("/")]
        if re.fullmatch("/".join(parts), request.url.path):
            methods.update(method.upper() for method in operations)
    return methods or {"GET"}


async def _on_unexpected(request: Request, error: Exception) -> JSONResponse:
    _LOG.error("%s %s failed", request.method, request.url.path, exc_info=error)
    return problem_response(
        request, INTERNAL, f"{type(error).__name__} in {request.method} {request.url.path}"
    )
