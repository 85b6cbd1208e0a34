"""What stands before every address below /api/v1, HTTP and WebSocket alike: who asks, from which page, how much.

It runs before anything of the request is read, so that a stranger learns nothing from a body's mistakes and cannot fill
the memory. Who asks is left in the request's state for `dependencies.authenticate`. WebSockets are refused
before they are accepted, with the same problem documents.
"""

import asyncio
import math
from collections.abc import Iterable

from starlette.exceptions import HTTPException
from starlette.requests import HTTPConnection, Request
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from server.api.problems import FORBIDDEN, UNAUTHENTICATED, Kind, ProblemError, problem_response
from server.services.container import Services
from server.services.tokens import Principal

API = "/api/v1"
SUBPROTOCOL = "jointscope.v1"
TICKET = "ticket."
MAX_JSON_OCTETS = 1024 * 1024
_TOO_LARGE = Kind(
    name="too-large",
    title="The request is too large",
    status=413,
    remedy="send less; measured files go to POST /api/v1/recordings",
)

_TOO_MANY = Kind(
    name="too-many-attempts",
    title="Too many wrong tokens",
    status=429,
    remedy="wait as long as the header Retry-After says; a valid token is never refused for this",
)


class Gate:
    """ASGI middleware; see the head of this file.

    Args:
        app: what lies behind.
        uploads: paths whose bodies may be as large as the settings' `max_upload_octets`.
    """

    def __init__(self, app: ASGIApp, uploads: Iterable[str] = ()) -> None:
        self._app = app
        self._uploads = frozenset(uploads)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let a request pass, or answer it with a problem."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        try:
            if f"{scope['path']}/".startswith(f"{API}/"):
                scope.setdefault("state", {})["principal"] = await authenticate(HTTPConnection(scope))
            limited = receive if scope["type"] == "websocket" else self._limited(scope, receive)
        except ProblemError as error:
            # A Request is made of a WebSocket's scope as well: only its path is looked at.
            request = Request({**scope, "type": "http"})
            response = problem_response(
                request, error.kind, str(error), field=error.field, headers=error.headers
            )
            await response(scope, receive, send)
            return
        await self._app(scope, limited, send)

    def _limited(self, scope: Scope, receive: Receive) -> Receive:
        services: Services = scope["app"].state.services
        limit = services.settings.max_upload_octets if scope["path"] in self._uploads else MAX_JSON_OCTETS
        announced = dict(scope["headers"]).get(b"content-length", b"0")
        if announced.isdigit() and int(announced) > limit:
            raise ProblemError(_TOO_LARGE, f"{int(announced)} octets are more than {limit}", field="body")
        received = 0

        async def count() -> Message:
            nonlocal received
            message = await receive()
            received += len(message.get("body", b""))
            if received > limit:  # came in chunks, its length not announced
                raise HTTPException(_TOO_LARGE.status, f"the body is more than {limit} octets")
            return message

        return count


async def authenticate(connection: HTTPConnection) -> Principal:
    """Return who asks.

    Raises:
        ProblemError: no token, or one that is unknown, expired or revoked (401); a page of elsewhere (403).
    """
    services: Services = connection.app.state.services
    if connection.scope["type"] == "websocket":
        _check_origin(connection, services.settings.allowed_origins)
        if (ticket := _ticket(connection)) is not None:
            return _known(connection, services.tickets.redeem(ticket), "ticket")
    scheme, _, secret = connection.headers.get("authorization", "").partition(" ")
    if scheme.lower() != "bearer" or not secret.strip():
        raise ProblemError(
            UNAUTHENTICATED, "this address needs a token", headers={"WWW-Authenticate": "Bearer"}
        )
    found = services.tokens.recall(secret.strip())
    if found is None:
        loop, urgent = asyncio.get_running_loop(), connection.app.state.urgent
        found = await loop.run_in_executor(urgent, services.tokens.find, secret.strip())
    return _known(connection, found, "token")


def _known(connection: HTTPConnection, principal: Principal | None, what: str) -> Principal:
    if principal is None:
        services: Services = connection.app.state.services
        services.figures.tokens_refused.add()
        wait_s = services.attempts.note(connection.client.host if connection.client else "")
        if wait_s > 0.0:
            raise ProblemError(
                _TOO_MANY,
                f"too many wrong {what}s from here",
                headers={"Retry-After": str(math.ceil(wait_s))},
            )
        raise ProblemError(
            UNAUTHENTICATED,
            f"this {what} is unknown, expired or revoked",
            headers={"WWW-Authenticate": 'Bearer error="invalid_token"'},
        )
    return principal


def _ticket(connection: HTTPConnection) -> str | None:
    for protocol in connection.scope.get("subprotocols", ()):
        if protocol.startswith(TICKET):
            return str(protocol.removeprefix(TICKET))
    return None


def _check_origin(connection: HTTPConnection, allowed: tuple[str, ...]) -> None:
    """Refuse a WebSocket that another site's page opens; programs send no Origin and are known by their token."""
    origin = connection.headers.get("origin")
    own = connection.headers.get("host", "")
    if origin is None or origin in allowed or origin in (f"http://{own}", f"https://{own}"):
        return
    raise ProblemError(
        FORBIDDEN,
        f"pages of {origin} may not open live data here; start the service with --origin to allow them",
        field="Origin",
    )
