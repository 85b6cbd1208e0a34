"""What both clients do alike with a request and its answer."""

import json
import os
from collections.abc import Mapping
from typing import Any

import httpx

from jointscope_client.calls import Call
from jointscope_client.errors import UnreachableError, make_problem

URL_VARIABLE, TOKEN_VARIABLE = "JOINTSCOPE_URL", "JOINTSCOPE_TOKEN"
DEFAULT_URL = "http://127.0.0.1:8000"
PIECE = 1 << 20


def settings(url: str | None, token: str | None) -> tuple[str, dict[str, str]]:
    """Return address and headers; what is not given comes from the environment."""
    secret = token or os.environ.get(TOKEN_VARIABLE)
    headers = {} if secret is None else {"Authorization": f"Bearer {secret}"}
    return (url or os.environ.get(URL_VARIABLE) or DEFAULT_URL).rstrip("/"), headers


def arguments(call: Call[Any]) -> dict[str, Any]:  # arguments of httpx
    """Return the arguments of a request, without its body from a file."""
    found: dict[str, Any] = {
        "method": call.method,
        "url": call.path,
        "params": {name: value for name, value in call.params.items() if value is not None},
        "headers": dict(call.headers),
    }
    if call.json is not None:
        found["json"] = call.json
    if call.content is not None:
        found["content"] = call.content
    return found


def check(answer: httpx.Response) -> None:
    """Raise the problem that an answer tells; its body must have been read.

    Raises:
        ProblemError: the service refused.
    """
    if not answer.is_success:
        raise make_problem(refusal(answer.status_code, answer.content))


def refusal(status: int, body: bytes | bytearray | None) -> dict[str, Any]:  # JSON values
    """Return the problem document that an answer holds, or what stands for one that is none."""
    text = (body or b"").decode(errors="replace")
    try:
        content = json.loads(text)
    except ValueError:
        content = None
    if not isinstance(content, Mapping):
        content = {"detail": text[:500]}
    return {"status": status, **content}


def unreachable(url: str, error: httpx.HTTPError) -> UnreachableError:
    """Return the error for a service that does not answer."""
    return UnreachableError(
        f"{url} does not answer: {error or type(error).__name__}; is `jointscope serve` running there?"
    )
