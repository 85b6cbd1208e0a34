"""A port and the host's link together, driven by whoever calls: no thread, no policy.

The opening handshake runs on it alone; afterwards the port thread drives it turn by turn.
"""

from collections.abc import Callable

from daq.driver.refusals import check_reply
from daq.driver.sink import SinkTap
from daq.errors import LinkTimeoutError
from daq.protocol.host_link import HostLink
from daq.protocol.link_records import LinkInput
from daq.protocol.message import Command, Reply
from daq.protocol.round_trip import LinkOptions
from daq.transport.interface import Transport

Clock = Callable[[], int]


class Conversation:
    """One open port, from opening to closing or loss.

    Args:
        transport: The port.
        options: Waiting times of the link.
        tap: Where received octets go before they are decoded.
        clock_ns: Host monotonic clock, ns.
    """

    def __init__(self, transport: Transport, options: LinkOptions, tap: SinkTap, clock_ns: Clock) -> None:
        self.transport = transport
        self.link = HostLink(options)
        self.tap = tap
        self.overheard: list[LinkInput] = []
        """What came in while `ask` waited for its reply: the port thread starts with it."""
        self._clock_ns = clock_ns

    def turn(self, gather_s: float) -> tuple[LinkInput, int]:
        """Send what waits, read what is there, and let the tap have it before it is decoded.

        Returns:
            What came in, and the host time at which it was read, ns.

        Raises:
            PortError: The port is gone.
        """
        output = self.link.take_output()
        if output:
            self.transport.write(output)
        data = self.transport.read(gather_s)
        t_ns = self._clock_ns()
        if data:
            self.tap.append(data)
        return self.link.receive(data, t_ns), t_ns

    def ask(self, command: Command) -> Reply:
        """Send a command and drive the port until its reply is there.

        Raises:
            LinkTimeoutError: No reply after the last try.
            DeviceRefusedError: The reply is a refusal.
        """
        ticket = self.link.submit(command, self._clock_ns())
        while True:
            found, t_ns = self.turn(0.0)
            self.overheard.append(found)
            for answered, reply in found.replies:
                if answered == ticket:
                    check_reply(command, reply)
                    return reply
            for lost in self.link.poll(t_ns):
                if lost.ticket == ticket:
                    raise LinkTimeoutError(describe_silence(command, lost.tries))

    def close(self) -> None:
        """Give the port back."""
        self.transport.close()


def describe_silence(command: Command, tries: int) -> str:
    """Return the message for a command without reply."""
    name = type(command).__name__
    return (
        f"no reply to {name} after {tries} tries; check the cable, the controller's supply and the baud rate"
    )
