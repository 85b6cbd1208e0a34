"""Limits the body of every request: what is too large is refused by its length, or as soon as too much has come."""

from starlette.exceptions import HTTPException
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from server.api.problems import MEDIA_TYPE, Kind, problem_text

UPLOAD_PATH = "/api/v1/recordings"
MAX_OCTETS = 4 * 1024 * 1024
TOO_LARGE = Kind(
    name="too-large",
    title="The body is too large",
    status=413,
    remedy="send less: cut or compress the file, or let whoever runs the service raise its limit",
)


class BodyLimit:
    """ASGI middleware.

    Args:
        app: what is protected.
        upload_octets: largest upload of a measured file; every other body may have `MAX_OCTETS`.
    """

    def __init__(self, app: ASGIApp, upload_octets: int) -> None:
        self._app = app
        self._upload_octets = upload_octets

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        limit = self._upload_octets if scope["path"] == UPLOAD_PATH else MAX_OCTETS
        stated = dict(scope["headers"]).get(b"content-length", b"0")
        if stated.isdigit() and int(stated) > limit:
            await _refuse(scope["path"], int(stated), limit, send)
            return
        await self._app(scope, _counted(receive, limit), send)


def _counted(receive: Receive, limit: int) -> Receive:
    total = 0

    async def counted() -> Message:
        nonlocal total
        message = await receive()
        total += len(message.get("body", b""))
        if total > limit:
            raise HTTPException(413, f"the body has more than {limit:,} octets")
        return message

    return counted


async def _refuse(path: str, octets: int, limit: int, send: Send) -> None:
    body = problem_text(path, TOO_LARGE, f"a body of {octets:,} octets is refused; {limit:,} are allowed")
    headers = [(b"content-type", MEDIA_TYPE.encode()), (b"content-length", str(len(body)).encode())]
    await send({"type": "http.response.start", "status": TOO_LARGE.status, "headers": headers})
    await send({"type": "http.response.body", "body": body})
