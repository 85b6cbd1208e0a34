"""The pseudo-terminal that stands for the serial port; the only file that touches the operating system's tty.

The emulator keeps its own descriptor of the slave open, so a host that closes the port does not end it.
A pseudo-terminal has no baud: the rate that the host set is read from the slave's settings, and the line
model decides what the octets look like at that rate.
"""

import errno
import fcntl
import os
import struct
import termios
import time
import tty
from contextlib import suppress
from pathlib import Path

_TCGETS2 = 0x802C542A
"""ioctl that returns `struct termios2`, whose last two words are the plain input and output rates (Linux)."""
_PATIENCE_STEP_S = 0.001
_PATIENCE_STEPS = 200
_TERMIOS2 = struct.Struct("=4IB19s2I")
_BAUD_CODES = {getattr(termios, f"B{rate}"): rate for rate in (9600, 19200, 38400, 57600, 115200, 230400)}


class LinkPathError(OSError):
    """The link path is taken by something that is not a link of an emulator."""


class PtyPort:
    """A pseudo-terminal in raw mode with an optional symbolic link to its slave.

    Args:
        link: where hosts find the port; None to be found by the slave's own name only.
        baud: rate that the slave shows until a host sets another.
    """

    def __init__(self, link: Path | None, baud: int) -> None:
        self._link = link
        self._baud = baud
        self._master = -1
        self._slave = -1
        self.name = ""
        self.open()

    def open(self) -> None:
        """Create the pseudo-terminal and the link to it."""
        self._master, self._slave = os.openpty()
        try:
            tty.setraw(self._slave)
            self._set_baud()
            os.set_blocking(self._master, False)
            self.name = os.ttyname(self._slave)
            self._make_link()
        except OSError:
            self.close()
            raise

    def close(self) -> None:
        """Remove the link and close both ends; the host sees the line drop."""
        if self._link is not None and self._link.is_symlink() and str(self._link.readlink()) == self.name:
            self._link.unlink()
        for descriptor in (self._slave, self._master):
            if descriptor >= 0:
                os.close(descriptor)
        self._master = self._slave = -1

    @property
    def is_open(self) -> bool:
        """Whether a host can find the port."""
        return self._master >= 0

    def fileno(self) -> int:
        """Return the master's descriptor, for `select`."""
        return self._master

    def read(self, limit: int) -> bytes:
        """Return the octets that the host has sent, without waiting; empty if there are none."""
        if self._master < 0:
            return b""
        try:
            return os.read(self._master, limit)
        except BlockingIOError:
            return b""

    def write(self, octets: bytes) -> int:
        """Pass octets to the host, without waiting; return how many there was room for, closed: all."""
        if self._master < 0:
            return len(octets)
        try:
            return os.write(self._master, octets)
        except BlockingIOError:
            return 0

    def close_when_read(self) -> None:
        """Close once the host has read what was written, or will not; a close throws the rest away."""
        for _ in range(_PATIENCE_STEPS):
            answer = fcntl.ioctl(self._slave, termios.FIONREAD, b"\0" * 4)
            if struct.unpack("=i", answer)[0] == 0:
                break
            time.sleep(_PATIENCE_STEP_S)
        self.close()

    def host_baud(self) -> int:
        """Return the rate that is set on the slave's side, also where it is none of the named ones."""
        try:
            answer = fcntl.ioctl(self._slave, _TCGETS2, b"\0" * _TERMIOS2.size)
        except OSError:
            code: int = termios.tcgetattr(self._slave)[5]
            return _BAUD_CODES.get(code, code)
        return int(_TERMIOS2.unpack(answer)[7])

    def _set_baud(self) -> None:
        codes = {rate: code for code, rate in _BAUD_CODES.items()}
        settings = termios.tcgetattr(self._slave)
        settings[4] = settings[5] = codes[self._baud]
        termios.tcsetattr(self._slave, termios.TCSANOW, settings)

    def _make_link(self) -> None:
        if self._link is None:
            return
        if self._link.exists() and not self._link.is_symlink():
            raise LinkPathError(
                errno.EEXIST, "not a symbolic link: choose another --link path", str(self._link)
            )
        self._link.parent.mkdir(parents=True, exist_ok=True)
        fresh = self._link.with_name(f".{self._link.name}.{os.getpid()}")
        with suppress(FileNotFoundError):
            fresh.unlink()
        fresh.symlink_to(self.name)
        fresh.replace(self._link)
