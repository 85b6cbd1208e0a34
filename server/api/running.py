"""Binds the port, tells the user where the service is, and runs it until a signal ends it in order."""

import asyncio
import contextlib
import ipaddress
import signal
import socket
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import uvicorn

from server.api.app import create_app
from server.errors import InputError, InputLocation
from server.services.container import Services, open_services
from server.services.settings import ServiceSettings
from server.services.tokens import Scope

_EXIT_POLL_S = 0.1
_GRACE_S = 10
# A client that takes nothing holds 16 KiB here, and not megabytes of old samples; after half a minute it is cut off.
_LINUX_OPTIONS = {"TCP_NOTSENT_LOWAT": 16 * 1024, "TCP_USER_TIMEOUT": 30_000}
_MAX_MESSAGE_OCTETS = 64 * 1024


@dataclass(frozen=True, slots=True, kw_only=True)
class Binding:
    """Where to listen; port 0 takes a free one."""

    host: str = "127.0.0.1"
    port: int = 8000


def run_service(settings: ServiceSettings, binding: Binding, tell: Callable[[str], None]) -> None:
    """Serve until Ctrl-C or SIGTERM; then rigs come to rest before the process ends.

    Args:
        settings: what the user chose.
        binding: where to listen.
        tell: takes lines for the user.

    Raises:
        InputError: port taken, address not this machine's, or not allowed without tokens.
    """
    with _noted_signals() as signals, _bound(binding) as listener:
        services = open_services(settings)
        try:
            address, token = _address(listener, binding.host), _first_token(services, binding)
        except BaseException:
            services.close()
            raise
        for note in services.started.notes:
            tell(note)
        tell(f"Jointscope is at {address}  (the API in words: {address}/docs)")
        if token is not None:
            tell(f"Admin token, shown this once: {token}")
        else:
            tell(f"Further tokens: jointscope token create --name NAME --data {settings.data_dir}")
        if signals:  # came before the server could obey them
            services.close()
            return
        asyncio.run(_serve(settings, services, listener))


async def _serve(settings: ServiceSettings, services: Services, listener: socket.socket) -> None:
    config = uvicorn.Config(
        create_app(settings, services),
        log_level="warning",
        timeout_graceful_shutdown=_GRACE_S,
        server_header=False,
        ws="websockets-sansio",
        ws_max_size=_MAX_MESSAGE_OCTETS,
        ws_per_message_deflate=False,  # measured values hardly shrink, and it costs more than all the rest
    )
    server = uvicorn.Server(config)
    watch = asyncio.create_task(_end_streams_at_exit(server, services))
    await server.serve(sockets=[listener])
    watch.cancel()
    with contextlib.suppress(asyncio.CancelledError):
        await watch


async def _end_streams_at_exit(server: uvicorn.Server, services: Services) -> None:
    """End the endless answers as soon as a signal came: the server waits for them before it closes the application."""
    while not server.should_exit:
        await asyncio.sleep(_EXIT_POLL_S)
    services.end_streams()


def _first_token(services: Services, binding: Binding) -> str | None:
    """Make the first token of a new data folder.

    Raises:
        InputError: the address can be reached from elsewhere and there is no token yet.
    """
    if services.tokens.any_valid():
        return None
    if not _is_loopback(binding.host):
        raise InputError(
            f"{binding.host} can be reached from other machines, and there is no token yet; make one first by: "
            f"jointscope token create --name NAME --scope admin --data {services.settings.data_dir}",
            InputLocation(field="--host"),
        )
    return services.tokens.create("first admin", (Scope.ADMIN,)).secret


def _is_loopback(host: str) -> bool:
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


@contextlib.contextmanager
def _bound(binding: Binding) -> Iterator[socket.socket]:
    try:
        family = socket.getaddrinfo(binding.host, binding.port, type=socket.SOCK_STREAM)[0][0]
        listener = socket.create_server((binding.host, binding.port), family=family, backlog=2048)
    except OSError as error:
        raise InputError(
            f"{binding.host} port {binding.port}: {error.strerror}; give another --port, or end what uses it",
            InputLocation(field="--port"),
        ) from error
    with listener:
        # Connections inherit these. asyncio does not set the first on a socket that it has not made itself; without it
        # every second answer on a connection waits 40 ms for an acknowledgement.
        listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        for option, value in _LINUX_OPTIONS.items():
            if hasattr(socket, option):
                listener.setsockopt(socket.IPPROTO_TCP, getattr(socket, option), value)
        yield listener


def _address(listener: socket.socket, host: str) -> str:
    port = listener.getsockname()[1]
    return f"http://[{host}]:{port}" if ":" in host else f"http://{host}:{port}"


@contextlib.contextmanager
def _noted_signals() -> Iterator[list[int]]:
    """Note signals instead of dying of them: the server obeys them itself, and raises them again at its end."""
    came: list[int] = []

    def note(number: int, frame: object) -> None:
        came.append(number)

    previous = {number: signal.signal(number, note) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield came
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)
