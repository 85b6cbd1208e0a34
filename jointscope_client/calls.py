"""Each operation of the service as a value: what to send, and how to read the answer. No I/O here.

Both clients perform the same calls, so an operation is written down once.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Generic, TypeVar
from urllib.parse import quote

import httpx

from jointscope_client import records
from jointscope_client.samples import ARROW_TYPE, Samples, read_arrow

T = TypeVar("T")
API = "/api/v1"
LEASE_HEADER = "Jointscope-Lease"
YAML_TYPE = "application/yaml"
Params = Mapping[str, Any]  # text, numbers, flags, and lists of them


@dataclass(frozen=True, slots=True, kw_only=True)
class Call(Generic[T]):
    """One request.

    Attributes:
        method, path: path below the service's address.
        read: makes the result of the answer.
        params: query; None values are left out.
        json: body as JSON.
        content: body as octets.
        file: body from a file, streamed.
        headers: beside the token.
    """

    method: str
    path: str
    read: Callable[[httpx.Response], T]
    params: Params = field(default_factory=dict)
    json: object = None
    content: bytes | None = None
    file: Path | None = None
    headers: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class Page(Generic[T]):
    """A page of a list, and the query that continues it; None at the end."""

    items: list[T]
    following: Params | None


def path_of(*parts: str) -> str:
    """Return an address below /api/v1; each part is quoted."""
    return "/".join([API, *(quote(part, safe="") for part in parts)])


def nothing(answer: httpx.Response) -> None:
    """Read an answer without content."""


def as_json(answer: httpx.Response) -> Any:  # JSON values
    """Read an answer as it is."""
    return answer.json()


def as_text(answer: httpx.Response) -> str:
    """Read an answer as text."""
    return answer.text


def one(read: Callable[[records.Json], T]) -> Callable[[httpx.Response], T]:
    """Return what reads one record."""
    return lambda answer: read(answer.json())


def many(read: Callable[[records.Json], T]) -> Callable[[httpx.Response], list[T]]:
    """Return what reads a list that comes as one page."""
    return lambda answer: [read(each) for each in answer.json()["items"]]


def page(read: Callable[[records.Json], T], params: Params) -> Callable[[httpx.Response], Page[T]]:
    """Return what reads a page; the service's lists continue by `cursor` or by `next_X`, sent back as `X`."""

    def read_page(answer: httpx.Response) -> Page[T]:
        content = answer.json()
        marks = {
            key.removeprefix("next_"): value
            for key, value in content.items()
            if key.startswith("next_") or key == "cursor"
        }
        going_on = bool(marks) and all(value is not None for value in marks.values())
        return Page(
            items=[read(each) for each in content["items"]],
            following={**params, **marks} if going_on else None,
        )

    return read_page


def get(path: str, read: Callable[[httpx.Response], T], params: Params | None = None) -> Call[T]:
    """Return a GET."""
    return Call(method="GET", path=path, read=read, params=params or {})


def post(path: str, read: Callable[[httpx.Response], T], json: object = None, **headers: str) -> Call[T]:
    """Return a POST."""
    return Call(method="POST", path=path, read=read, json=json, headers=headers)


def with_lease(lease_id: str) -> dict[str, str]:
    """Return the header that shows a lease."""
    return {LEASE_HEADER: lease_id}


def listing(name: str, read: Callable[[records.Json], T], params: Params) -> Call[Page[T]]:
    """Return the call for one page of a list."""
    return get(path_of(name), page(read, params), params)


def take_lease(rig_id: str, ttl_s: float, take_over: bool) -> Call[str]:
    """Return the call whose result is the lease's id."""
    body = {"ttl_s": ttl_s, "take_over": take_over}
    return post(path_of("rigs", rig_id, "lease"), lambda answer: str(answer.json()["id"]), body)


def renew_lease(rig_id: str, lease_id: str) -> Call[None]:
    """Return the call that holds on to a lease."""
    path = path_of("rigs", rig_id, "lease")
    return Call(method="PUT", path=path, read=nothing, json={}, headers=with_lease(lease_id))


def release_lease(rig_id: str, lease_id: str) -> Call[None]:
    """Return the call that gives a lease back."""
    return Call(
        method="DELETE", path=path_of("rigs", rig_id, "lease"), read=nothing, headers=with_lease(lease_id)
    )


def write_parameter(rig_id: str, lease_id: str, name: str, value: float) -> Call[records.Parameter]:
    """Return the call that writes a controller parameter."""
    return Call(
        method="PUT",
        path=path_of("rigs", rig_id, "parameters", name),
        read=one(records.read_parameter),
        json={"value": value},
        headers=with_lease(lease_id),
    )


def samples(recording_id: str, params: Params) -> Call[Samples]:
    """Return the call for samples of a recording."""
    return Call(
        method="GET",
        path=path_of("recordings", recording_id, "samples"),
        read=lambda answer: read_arrow(answer.content),
        params=params,
        headers={"Accept": ARROW_TYPE},
    )


def upload(
    path: Path, name: str | None, mappings: Sequence[str], leave_out: Sequence[str]
) -> Call[records.RecordingInfo]:
    """Return the call that uploads a measured file."""
    params = {"file": path.name, "name": name, "map": list(mappings), "leave_out": list(leave_out)}
    return Call(
        method="POST",
        path=path_of("recordings"),
        read=one(records.read_recording),
        params=params,
        file=path,
        headers={"Content-Type": "application/octet-stream"},
    )


def add_model(text: str, note: str, parent: str | None) -> Call[records.Model]:
    """Return the call that uploads a model file's text."""
    return Call(
        method="POST",
        path=path_of("models"),
        read=one(records.read_model),
        params={"note": note, "parent": parent},
        content=text.encode(),
        headers={"Content-Type": YAML_TYPE},
    )


def submit_campaign(text: str, params: Params, read: Callable[[httpx.Response], T]) -> Call[T]:
    """Return the call that submits a campaign file's text."""
    return Call(
        method="POST",
        path=path_of("campaigns"),
        read=read,
        params=params,
        content=text.encode(),
        headers={"Content-Type": YAML_TYPE},
    )
