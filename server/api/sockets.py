"""Serves one WebSocket: what it is sent, what it says, and when it is given up.

Sending waits for the network and for nothing else; a client that takes nothing for `STALL_S` is given up. Until then
its own bounded queue drops the oldest: nobody else notices it.
"""

import asyncio
import contextlib
import json
from collections.abc import AsyncIterator, Awaitable, Callable

from starlette.websockets import WebSocket, WebSocketDisconnect

from server.api.gate import SUBPROTOCOL
from server.services.container import Services

STALL_S = 10.0
TOKEN_CHECK_S = 2.0
GOING_AWAY = 1001
POLICY = 1008
Parcel = bytes | str
Listen = Callable[[str], Awaitable[None]]


async def serve_socket(socket: WebSocket, parcels: AsyncIterator[Parcel], listen: Listen) -> None:
    """Accept the socket, send all parcels, and hand what the client says to `listen`, until either side ends it."""
    offered = socket.scope.get("subprotocols", ())
    await socket.accept(subprotocol=SUBPROTOCOL if SUBPROTOCOL in offered else None)
    sending = asyncio.create_task(_send_all(socket, parcels))
    tasks = (sending, asyncio.create_task(_hear(socket, listen)), asyncio.create_task(_watch_token(socket)))
    try:
        await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for task in tasks:
            task.cancel()
        ended = await asyncio.gather(*tasks, return_exceptions=True)
    services: Services = socket.app.state.services
    services.figures.viewers_given_up.add(isinstance(ended[0], TimeoutError))
    for error in ended:
        if isinstance(error, Exception) and not isinstance(error, WebSocketDisconnect | TimeoutError):
            raise error


async def ignore(text: str) -> None:
    """Take what a client says where there is nothing to say."""


def to_text(message: object) -> str:
    """Return a JSON value as the text of a message."""
    return json.dumps(message, separators=(",", ":"), allow_nan=False)


async def _send_all(socket: WebSocket, parcels: AsyncIterator[Parcel]) -> None:
    async with contextlib.aclosing(parcels) as source:  # type: ignore[type-var]  # iterators here are generators
        async for parcel in source:
            async with asyncio.timeout(STALL_S):
                if isinstance(parcel, str):
                    await socket.send_text(parcel)
                else:
                    await socket.send_bytes(parcel)
    async with asyncio.timeout(STALL_S):
        await socket.close(GOING_AWAY, "nothing more comes")


async def _watch_token(socket: WebSocket) -> None:
    """End when the token that opened the socket is revoked or has expired."""
    services: Services = socket.app.state.services
    token_id, loop = socket.state.principal.token_id, asyncio.get_running_loop()
    while True:
        await asyncio.sleep(TOKEN_CHECK_S)
        if not await loop.run_in_executor(socket.app.state.urgent, services.tokens.still_valid, token_id):
            async with asyncio.timeout(STALL_S):
                await socket.close(POLICY, "the token is no longer valid")
            return


async def _hear(socket: WebSocket, listen: Listen) -> None:
    while True:
        message = await socket.receive()
        if message["type"] == "websocket.disconnect":
            return
        text = message.get("text")
        await listen(text if text is not None else "")
