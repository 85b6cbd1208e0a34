"""Serial lines and pseudo-terminals by pySerial, opened for this process alone."""

import errno
import logging
from pathlib import Path

import serial

from daq.errors import PortError
from daq.transport.descriptor_reader import DescriptorReader
from daq.transport.interface import Transport

_LOG = logging.getLogger(__name__)
_LATENCY_TIMER = "/sys/bus/usb-serial/devices/{name}/latency_timer"


class SerialTransport(Transport):
    """One serial port, locked against other processes."""

    def __init__(self, path: str, baud: int, *, poll_s: float = 0.02) -> None:
        try:
            self._port = serial.Serial(
                path, baud, timeout=0, write_timeout=1.0, exclusive=True, xonxoff=False, rtscts=False
            )
        except (OSError, ValueError) as error:
            raise PortError(_explain_open(path, baud, error)) from error
        self._path = path
        self._reader = DescriptorReader(self._port.fileno(), poll_s)
        _ask_low_latency(self._port)

    def read(self, gather_s: float) -> bytes:
        """Wait for octets; see `Transport.read`."""
        try:
            data = self._reader.read(gather_s)
        except (OSError, ValueError) as error:  # ValueError: the descriptor of a closed port
            raise PortError(f"{self._path}: port lost while reading ({error}); check the cable") from error
        if data is None:
            raise PortError(f"{self._path}: port lost while reading (end of file); check the cable")
        return data

    def write(self, data: bytes) -> None:
        """Send all octets; a line that takes none for a second counts as lost."""
        try:
            self._port.write(data)
        except (OSError, TypeError) as error:
            raise PortError(f"{self._path}: port lost while writing ({error}); check the cable") from error

    def wake(self) -> None:
        """Let a waiting `read` return."""
        self._reader.wake()

    def close(self) -> None:
        """Close the port and release the lock."""
        self._reader.close()
        self._port.close()

    def change_baud(self, baud: int) -> None:
        """Go on at `baud`; octets under way at the old rate are lost."""
        try:
            self._port.baudrate = baud
        except (OSError, ValueError) as error:
            raise PortError(
                f"{self._path} cannot run at {baud} baud ({error}); choose another rate"
            ) from error


def latency_timer_warning(path: str) -> str | None:
    """Return a warning when the port is an FTDI adapter whose latency timer is above 1 ms, else None."""
    name = Path(path).resolve().name
    timer = Path(_LATENCY_TIMER.format(name=name))
    if not timer.exists():
        return None
    latency_ms = int(timer.read_text(encoding="ascii"))
    if latency_ms <= 1:
        return None
    return f"{path}: USB latency timer is {latency_ms} ms, so replies come late; write 1 to {timer}"


def _ask_low_latency(port: serial.Serial) -> None:
    try:
        port.set_low_latency_mode(True)
    except (OSError, ValueError, NotImplementedError, AttributeError):
        _LOG.debug("%s has no low latency mode", port.port)


def _explain_open(path: str, baud: int, error: Exception) -> str:
    number = getattr(error, "errno", None)
    if number in (errno.EAGAIN, errno.EBUSY) or "lock port" in str(error):
        return f"{path} is taken by another program; close it there, or choose another port"
    if number == errno.ENOENT:
        return f"{path} does not exist"
    if number == errno.EACCES:
        return f"{path}: no permission; add the user to the group that owns the port (often 'dialout')"
    return f"{path} cannot be opened as a serial port at {baud} baud: {error}"
