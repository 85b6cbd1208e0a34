"""Bodies that are no JSON of ours: files, written to disk as they come, and the texts of YAML files."""

from collections.abc import Callable
from typing import Any

from fastapi import Request
from starlette.concurrency import run_in_threadpool
from starlette.requests import ClientDisconnect

from server.api.problems import Kind, ProblemError

YAML_TYPE = "application/yaml"
OCTETS_TYPE = "application/octet-stream"
_PIECE = 1 << 20
_BROKEN_OFF = Kind(
    name="broken-off", title="The request broke off", status=400, remedy="send the whole body, then wait"
)


async def pour(request: Request, write: Callable[[bytes], None]) -> None:
    """Hand the body on in pieces, each in a thread, so that no disk holds up the event loop.

    Raises:
        ProblemError: the client went away (400).
    """
    pieces = bytearray()
    try:
        async for octets in request.stream():
            pieces += octets
            if len(pieces) >= _PIECE:
                await run_in_threadpool(write, bytes(pieces))
                pieces.clear()
    except ClientDisconnect as error:
        raise ProblemError(_BROKEN_OFF, "the client went away before the end of the body") from error
    await run_in_threadpool(write, bytes(pieces))


async def read_body(request: Request) -> bytes:
    """Return the whole body; its size is limited before it comes here."""
    try:
        return await request.body()
    except ClientDisconnect as error:
        raise ProblemError(_BROKEN_OFF, "the client went away before the end of the body") from error


def document_body(
    *media_types: str, schema: dict[str, Any], example: str | None = None
) -> dict[str, Any]:  # OpenAPI
    """Return what the OpenAPI document says of a body that an endpoint reads by itself."""
    content: dict[str, Any] = {"schema": schema}
    if example is not None:
        content["example"] = example
    return {"requestBody": {"required": True, "content": dict.fromkeys(media_types, content)}}
