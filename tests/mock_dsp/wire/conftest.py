"""An emulation with everything around it in memory: port, host, clock, plant."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import pytest

from daq.protocol.commands import Arm, Hello, Ping, SetBaud, StreamConfig, StreamStart
from daq.protocol.host_link import HostLink
from daq.protocol.link_records import LinkInput
from daq.protocol.replies import HelloReply
from daq.protocol.reports import Event, Status
from mock_dsp.program.controller import Controller
from mock_dsp.program.line_counters import LineCounters
from mock_dsp.program.parameters import ParameterStore
from mock_dsp.scenario.schema import Fault
from mock_dsp.wire.assembly import make_identity
from mock_dsp.wire.emulation import Emulation
from mock_dsp.wire.faults import FaultPlan

if TYPE_CHECKING:
    from collections.abc import Callable

    from tests.mock_dsp.conftest import FakePlant

TICK_HZ = 2500
MS = 1_000_000
START_BAUD = 115_200


class MemoryPort:
    """A port whose other end is the test; `room` is what the host's buffer still takes."""

    def __init__(self) -> None:
        self.baud = START_BAUD
        self.room = 1_000_000
        self.to_controller = b""
        self.to_host = b""
        self.is_open = True

    def open(self) -> None:
        """Come back."""
        self.is_open = True

    def close_when_read(self) -> None:
        """Drop the line."""
        self.is_open = False

    def fileno(self) -> int:
        """There is none: these tests do not wait."""
        return -1

    def host_baud(self) -> int:
        """Return the rate of the test's side."""
        return self.baud

    def read(self, limit: int) -> bytes:
        """Take what the test has sent."""
        octets, self.to_controller = self.to_controller[:limit], self.to_controller[limit:]
        return octets

    def write(self, octets: bytes) -> int:
        """Take what there is room for."""
        accepted = octets[: self.room] if self.is_open else octets
        self.room -= len(accepted)
        self.to_host += accepted
        return len(accepted)


class Rack:
    """An emulation with everything around it in memory."""

    def __init__(self, plant: FakePlant, speed: float, faults: tuple[Fault, ...] = ()) -> None:
        self.plant = plant
        self.port = MemoryPort()
        self.host = HostLink()
        self.t_ns = 0
        self.events: list[Event] = []
        self.statuses: list[Status] = []
        self.line = line = LineCounters()
        names = {fault.name for fault in faults}

        def boot(restarts: int) -> Controller:
            return Controller(make_identity(7 + restarts, names), plant, {}, line)

        plan = FaultPlan(faults, TICK_HZ)
        self.emulation = Emulation(boot, self.port, line, plan, speed=speed, clock_ns=lambda: self.t_ns)

    def spin(self, passes: int, pass_ns: int = 0) -> list[LinkInput]:
        """Do passes, each `pass_ns` after the one before, and let the host read after each."""
        inputs = []
        for _ in range(passes):
            self.t_ns += pass_ns
            self.port.to_controller += self.host.take_output()
            self.emulation.step()
            octets, self.port.to_host = self.port.to_host, b""
            received = self.host.receive(octets, self.t_ns)
            self.events += received.events
            self.statuses += received.statuses
            inputs.append(received)
        return inputs

    def ask(
        self, command: Hello | Ping | SetBaud | StreamConfig | StreamStart | Arm, pass_ns: int = 0
    ) -> object:
        """Return the reply to a command within 20 passes, None if none came."""
        ticket = self.host.submit(command, self.t_ns)
        for _ in range(20):
            for received in self.spin(1, pass_ns):
                for answered, reply in received.replies:
                    if answered == ticket:
                        return reply
        return None

    def stream_armed(self, lease_ms: int = 250) -> None:
        """Open a session, arm and stream at speed `max`."""
        hello = self.ask(Hello(proto_min=1, proto_max=1, cookie=1))
        assert isinstance(hello, HelloReply)
        self.ask(Arm(session=hello.session, lease_ms=lease_ms, limits_crc=ParameterStore({}).limits_crc()))
        self.ask(StreamStart())


@pytest.fixture
def make_rack(fake_plant: FakePlant) -> Callable[..., Rack]:
    def make(speed: float = math.inf, faults: tuple[Fault, ...] = ()) -> Rack:
        return Rack(fake_plant, speed, faults)

    return make


HELLO = Hello(proto_min=1, proto_max=1, cookie=1)
