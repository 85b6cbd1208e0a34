"""Serial line behind a TCP socket (`socket://host:port`): a serial server on the network."""

import socket
from typing import ClassVar

from daq.errors import PortError
from daq.transport.descriptor_reader import DescriptorReader
from daq.transport.interface import Transport


class SocketTransport(Transport):
    """One TCP connection; the rate of the line behind it is the server's business."""

    has_rate: ClassVar[bool] = False

    def __init__(self, host: str, port: int, *, poll_s: float = 0.02, connect_timeout_s: float = 3.0) -> None:
        self._name = f"socket://{host}:{port}"
        try:
            self._socket = socket.create_connection((host, port), timeout=connect_timeout_s)
        except OSError as error:
            raise PortError(
                f"{self._name} does not answer ({error}); is the serial server running?"
            ) from error
        # Commands are a few dozen octets: waiting to fill a packet would only delay them.
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._socket.settimeout(1.0)
        self._reader = DescriptorReader(self._socket.fileno(), poll_s)

    def read(self, gather_s: float) -> bytes:
        """Wait for octets; see `Transport.read`."""
        try:
            data = self._reader.read(gather_s)
        except (OSError, ValueError) as error:  # ValueError: the descriptor of a closed socket
            raise PortError(f"{self._name}: connection lost while reading ({error})") from error
        if data is None:
            raise PortError(f"{self._name}: the other side closed the connection")
        return data

    def write(self, data: bytes) -> None:
        """Send all octets; a peer that takes none for a second counts as lost."""
        try:
            self._socket.sendall(data)
        except OSError as error:
            raise PortError(f"{self._name}: connection lost while writing ({error})") from error

    def wake(self) -> None:
        """Let a waiting `read` return."""
        self._reader.wake()

    def close(self) -> None:
        """Close the connection."""
        self._reader.close()
        self._socket.close()

    def change_baud(self, baud: int) -> None:
        """Do nothing: the server behind the socket sets its own rate."""
