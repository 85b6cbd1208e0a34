"""Serves one WebSocket: what it is sent, what it says, and when it is given up.

Sending waits for the network and for nothing else; a client that takes nothing for `STALL_S` is given up. Until then
its own bounded queue drops the oldest: nobody else notices it. Whoever came with a token that is revoked meanwhile is
sent away.
"""

import asyncio
import json
from collections.abc import AsyncGenerator, Awaitable, Callable
from contextlib import aclosing

from starlette.websockets import WebSocket, WebSocketDisconnect

from server.api.gate import SUBPROTOCOL
from server.services.container import Services

STALL_S = 10.0
CHECK_S = 2.0
GOING_AWAY = 1001
POLICY = 1008
_NO_PONG = 1011
Parcel = bytes | str
Listen = Callable[[str], Awaitable[None]]


async def serve_socket(socket: WebSocket, parcels: AsyncGenerator[Parcel, None], listen: Listen) -> None:
    """Accept the socket, send all parcels, and hand what the client says to `listen`, until either side ends it."""
    offered = socket.scope.get("subprotocols", ())
    await socket.accept(subprotocol=SUBPROTOCOL if SUBPROTOCOL in offered else None)
    connection = _Connection(socket)
    tasks = [
        asyncio.create_task(work)
        for work in (connection.send_all(parcels), connection.hear(listen), connection.watch())
    ]
    try:
        await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for task in tasks:
            task.cancel()
        ended = await asyncio.gather(*tasks, return_exceptions=True)
    for error in ended:
        if isinstance(error, Exception) and not isinstance(error, WebSocketDisconnect | TimeoutError):
            raise error


async def ignore(text: str) -> None:
    """Take what a client says where there is nothing to say."""


def to_text(message: object) -> str:
    """Return a JSON value as the text of a message."""
    return json.dumps(message, separators=(",", ":"), allow_nan=False)


class _Connection:
    """The three tasks of a connection; the first that ends, ends it."""

    def __init__(self, socket: WebSocket) -> None:
        self._socket = socket
        self._services: Services = socket.app.state.services
        self._loop = asyncio.get_running_loop()
        self._sending_since_s: float | None = None

    async def send_all(self, parcels: AsyncGenerator[Parcel, None]) -> None:
        """Send parcel by parcel; `watch` looks at how long one takes, which costs less than a timeout for each."""
        async with aclosing(parcels):
            async for parcel in parcels:
                self._sending_since_s = self._loop.time()
                await self._send(parcel)
                self._sending_since_s = None
        await self._close(GOING_AWAY, "nothing more comes")

    async def hear(self, listen: Listen) -> None:
        """Take what the client says until it leaves."""
        while True:
            message = await self._socket.receive()
            if message["type"] == "websocket.disconnect":
                return
            await listen(message.get("text") or "")

    async def watch(self) -> None:
        """End when the client takes nothing any more, or its token is revoked or has expired."""
        token_id = self._socket.state.principal.token_id
        urgent = self._socket.app.state.urgent
        while True:
            await asyncio.sleep(CHECK_S)
            if self._sending_since_s is not None and self._loop.time() - self._sending_since_s > STALL_S:
                self._services.figures.viewers_given_up.add()
                return
            if not await self._loop.run_in_executor(urgent, self._services.tokens.still_valid, token_id):
                await self._close(POLICY, "the token is no longer valid")
                return

    async def _send(self, parcel: Parcel) -> None:
        try:
            if isinstance(parcel, str):
                await self._socket.send_text(parcel)
            else:
                await self._socket.send_bytes(parcel)
        except (
            RuntimeError
        ) as error:  # the server closed it: the client answered no ping, and `hear` is about to know
            raise WebSocketDisconnect(_NO_PONG) from error

    async def _close(self, code: int, reason: str) -> None:
        async with asyncio.timeout(CHECK_S):
            await self._socket.close(code, reason)
