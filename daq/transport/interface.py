"""What the driver needs from a port: octets in, octets out, a way to wake the reader, a way to close."""

from abc import ABC, abstractmethod
from typing import ClassVar


class Transport(ABC):
    """A port that one thread reads and writes; only `wake` may be called from another one.

    Every method but `close` raises `PortError` when the port is gone (cable pulled, peer closed).

    Attributes:
        has_rate: Whether `change_baud` does anything; false where somebody else sets the rate of the line.
    """

    has_rate: ClassVar[bool] = True

    @abstractmethod
    def read(self, gather_s: float) -> bytes:
        """Wait for octets and return all that are there.

        Args:
            gather_s: When octets arrive after a pause at least this long, wait so long again for the rest of
                them: one wake-up per frame instead of one per octet. 0 returns at once.

        Returns:
            The octets; empty after the poll interval or after `wake`.
        """

    @abstractmethod
    def write(self, data: bytes) -> None:
        """Send all octets."""

    @abstractmethod
    def wake(self) -> None:
        """Let a `read` that is waiting in another thread return now."""

    @abstractmethod
    def close(self) -> None:
        """Give the port back; more than once does no harm."""

    @abstractmethod
    def change_baud(self, baud: int) -> None:
        """Go on at another rate; ports without a rate take any."""
