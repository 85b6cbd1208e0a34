"""From a URL to an open transport."""

from collections.abc import Callable
from urllib.parse import urlsplit

from daq.errors import PortError
from daq.transport.interface import Transport
from daq.transport.serial_port import SerialTransport
from daq.transport.socket_port import SocketTransport


def open_transport(url: str, baud: int) -> Transport:
    """Open the port that `url` names.

    Args:
        url: `/dev/ttyUSB0`, `serial:///dev/ttyUSB0`, `COM3`, a pseudo-terminal's path or link, or `socket://host:port`.
        baud: Line rate to start with, 1/s.

    Raises:
        PortError: Unknown kind of URL, port that does not exist, is taken, or cannot run at this rate.
    """
    scheme, separator, _ = url.partition("://")
    if not separator:
        return SerialTransport(url, baud)
    opener = TRANSPORTS.get(scheme)
    if opener is None:
        raise PortError(
            f"{url}: unknown kind of port '{scheme}'; use {', '.join(TRANSPORTS)} or a device path"
        )
    return opener(url, baud)


def _open_serial(url: str, baud: int) -> Transport:
    return SerialTransport(urlsplit(url).path, baud)


def _open_socket(url: str, baud: int) -> Transport:
    parts = urlsplit(url)
    try:
        port = parts.port
    except ValueError:
        port = None
    if not parts.hostname or port is None:
        raise PortError(
            f"{url}: host or port is missing; write socket://host:port, for example socket://rig1:4001"
        )
    return SocketTransport(parts.hostname, port)


TRANSPORTS: dict[str, Callable[[str, int], Transport]] = {"serial": _open_serial, "socket": _open_socket}
