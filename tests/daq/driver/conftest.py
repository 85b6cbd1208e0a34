"""A controller in memory: the protocol's device side with a few lines of behaviour, no thread of its own."""

import threading
import time
from collections.abc import Callable, Iterator

import pytest

from daq.driver.handshake import Handshake
from daq.driver.options import RigOptions
from daq.driver.port_thread import PortThread
from daq.driver.rig import Rig
from daq.driver.sink import SinkTap
from daq.errors import PortError
from daq.protocol import commands, replies
from daq.protocol.codes import DriveState, StatusCode
from daq.protocol.device_link import DeviceLink
from daq.protocol.dictionary import Dictionary, build_dictionary, dictionary_crc
from daq.protocol.dictionary_entries import Channel, CountType, FaultText, Layout, Parameter
from daq.protocol.message import Command, Reply, Report
from daq.protocol.reports import Stream
from daq.protocol.round_trip import LinkOptions
from daq.protocol.stream import SampleBlock
from daq.transport.interface import Transport

DEFAULTS = {
    "current_limit_A": 2.0, "speed_limit_rad_s": 180.0, "travel_min_rad": -29.8, "travel_max_rad": 29.8,
    "rated_current_A": 1.26, "i2t_time_s": 10.0, "ramp_time_s": 0.05, "lease_default_s": 0.25,
    "centring_gain_A_rad": 0.01, "centring_bandwidth_Hz": 0.005, "flux_current_A": 0.4455,
    "current_loop_bandwidth_Hz": 150.0, "bus_voltage_V": 540.0, "temperature_degC": 25.0, "over_current_A": 3.0,
}  # fmt: skip
PARAMETERS = tuple(
    Parameter(
        id=number, name=name, unit="SI", scale=1e-4, minimum=-1000.0, maximum=1000.0, default=value, writable=True,
        writable_armed=False, doc="",
    )
    for number, (name, value) in enumerate(DEFAULTS.items(), start=1)
)  # fmt: skip
CHANNELS = tuple(
    Channel(name=name, column=name, unit="A", type=CountType.I16, scale=2**-13, offset=0.0)
    for name in ("current_ref", "current")
)
POSITION = Channel(
    name="position", column="position_rad", unit="rad", type=CountType.U16, scale=1e-3, offset=0.0
)
DICTIONARY = Dictionary(
    device="stub", firmware="1", parameters=PARAMETERS, channels=(*CHANNELS, POSITION), generators=(),
    layouts=(
        Layout(id=1, name="control", channels=("current_ref", "current", "position")),
        Layout(id=2, name="lean", channels=("current", "position")),
    ),
    faults=(FaultText(bit=0, name="over_current", text="A current was too large.", remedy="Look for a short."),),
)  # fmt: skip
Answer = Callable[[Command], Reply]


class StubController:
    """What a controller does, as far as the driver can see it; tests change its attributes and `answers`."""

    def __init__(self) -> None:
        self.link = DeviceLink()
        self.octets = build_dictionary(DICTIONARY)
        self.session = 7
        self.version = 1
        self.bauds: tuple[int, ...] = (115_200, 937_500)
        self.working_bauds: tuple[int, ...] = (115_200, 937_500)
        self.baud = 115_200
        self.announced_crc: int | None = None
        self.tick = 1000
        self.seen: list[Command] = []
        self.raw = {parameter.id: parameter.to_raw(parameter.default) for parameter in PARAMETERS}
        self.silent: set[type[Command]] = set()
        ok = StatusCode.OK
        self.answers: dict[type[Command], Answer] = {
            commands.Hello: self.introduce,
            commands.DictRead: self.serve_dictionary,
            commands.Ping: self.tell_time,
            commands.SetBaud: self.set_baud,
            commands.EventAck: lambda c: replies.EventAckReply(status=ok, event=getattr(c, "event", 0)),
            commands.LinkStats: lambda c: replies.LinkStatsReply(
                status=ok, rx_frames=0, rx_crc_errors=0, rx_malformed=0, rx_overruns=0, rx_unknown=0,
                tx_frames=0, tx_octets=0, tx_drops=0, isr_max_us=30,
            ),
            commands.ParamGet: self.get_parameter,
            commands.ParamSet: self.set_parameter,
            commands.StreamConfig: lambda c: replies.StreamConfigReply(status=ok, layout=1, divisor=1, batch=25),
            commands.StreamStart: lambda c: replies.StreamStartReply(status=ok, tick=self.tick),
            commands.StreamStop: lambda c: replies.StreamStopReply(status=ok, tick=self.tick),
            commands.Arm: lambda c: replies.ArmReply(status=ok, lease_ms=getattr(c, "lease_ms", 0)),
            commands.KeepAlive: lambda c: replies.KeepAliveReply(status=ok, lease_left_ms=100),
            commands.Disarm: lambda c: replies.DisarmReply(status=ok),
            commands.Estop: lambda c: replies.EstopReply(status=ok),
            commands.ClearFault: lambda c: replies.ClearFaultReply(status=ok, faults=0),
            commands.Run: lambda c: replies.RunReply(status=ok, start_tick=self.tick),
        }  # fmt: skip

    def introduce(self, command: Command) -> Reply:
        """Answer HELLO."""
        assert isinstance(command, commands.Hello)
        if not command.proto_min <= self.version <= command.proto_max:
            return replies.Refusal(command=commands.Hello.TYPE, status=StatusCode.UNSUPPORTED_VERSION)
        crc = dictionary_crc(self.octets) if self.announced_crc is None else self.announced_crc
        return replies.HelloReply(
            status=StatusCode.OK, version=self.version, cookie=command.cookie, dictionary_crc=crc,
            dictionary_octets=len(self.octets), tick_hz=2500, pwm_hz=2500, session=self.session,
            serial_number=1, firmware=1, rx_credits=512, max_frame=254, bauds=self.bauds,
        )  # fmt: skip

    def tell_time(self, command: Command) -> Reply:
        """Answer PING."""
        assert isinstance(command, commands.Ping)
        return replies.PingReply(status=StatusCode.OK, cookie=command.cookie, tick=self.tick, subtick=0)

    def serve_dictionary(self, command: Command) -> Reply:
        """Answer DICT_READ."""
        assert isinstance(command, commands.DictRead)
        data = self.octets[command.offset : command.offset + command.count]
        total = len(self.octets)
        return replies.DictReadReply(status=StatusCode.OK, offset=command.offset, total=total, data=data)

    def set_baud(self, command: Command) -> Reply:
        """Answer SET_BAUD; the rate that the line does not carry is never taken."""
        assert isinstance(command, commands.SetBaud)
        if command.baud in self.working_bauds:
            self.baud = command.baud
        return replies.SetBaudReply(status=StatusCode.OK, baud=command.baud)

    def get_parameter(self, command: Command) -> Reply:
        """Answer PARAM_GET."""
        assert isinstance(command, commands.ParamGet)
        return replies.ParamGetReply(
            status=StatusCode.OK, parameter=command.parameter, raw=self.raw[command.parameter]
        )

    def set_parameter(self, command: Command) -> Reply:
        """Answer PARAM_SET; nothing above 3 SI units is taken."""
        assert isinstance(command, commands.ParamSet)
        self.raw[command.parameter] = min(command.raw, 30_000)
        status = StatusCode.OK if self.raw[command.parameter] == command.raw else StatusCode.CLAMPED
        return replies.ParamSetReply(
            status=status, parameter=command.parameter, raw=self.raw[command.parameter]
        )

    def handle(self, data: bytes) -> None:
        """Execute received octets."""
        for seq, command in self.link.receive(data):
            self.seen.append(command)
            if type(command) not in self.silent:
                self.link.reply(seq, self.answers[type(command)](command))

    def count(self, kind: type[Command]) -> int:
        """Return how many commands of a kind were executed."""
        return sum(isinstance(command, kind) for command in self.seen)

    def samples(self, frames: int, state: DriveState = DriveState.IDLE, faults: int = 0) -> list[Report]:
        """Return the next stream frames of 25 samples each."""
        reports: list[Report] = []
        for _ in range(frames):
            reports.append(
                Stream(layout=1, batch=25, tick0=self.tick, status=int(state) | faults, samples=bytes(150))
            )
            self.tick += 25
        return reports


class StubPort(Transport):
    """The port that leads to a stub controller; octets sent at another rate than its own are lost."""

    def __init__(self, controller: StubController, baud: int) -> None:
        self._controller = controller
        self._inbox = bytearray()
        self._changed = threading.Condition()
        self._woken = self._pulled = False
        self.baud = baud

    def read(self, gather_s: float) -> bytes:
        """Wait for what the controller sends."""
        with self._changed:
            self._changed.wait_for(lambda: self._inbox or self._woken or self._pulled, 0.02)
            self._woken = False
            if self._pulled:
                raise PortError("stub: cable pulled")
            data = bytes(self._inbox)
            self._inbox.clear()
        return data

    def write(self, data: bytes) -> None:
        """Have the controller execute octets sent at its rate."""
        with self._changed:
            if self.baud == self._controller.baud:
                self._controller.handle(data)
                self._inbox += self._controller.link.take_output()

    def report(self, *reports: Report) -> None:
        """Have the controller send something by itself."""
        with self._changed:
            for report in reports:
                self._controller.link.send(report)
            self._inbox += self._controller.link.take_output()
            self._changed.notify_all()

    def inject(self, octets: bytes) -> None:
        """Put octets on the line that are no frame."""
        with self._changed:
            self._inbox += octets
            self._changed.notify_all()

    def pull_cable(self) -> None:
        """Let the next read fail."""
        with self._changed:
            self._pulled = True
            self._changed.notify_all()

    def wake(self) -> None:
        """Let a waiting read return."""
        with self._changed:
            self._woken = True
            self._changed.notify_all()

    def close(self) -> None:
        """Let later reads fail."""
        self.pull_cable()

    def change_baud(self, baud: int) -> None:
        """Send and hear at another rate."""
        self.baud = baud


class Bench:
    """A stub controller, the ports opened to it, and a clock that jumps while a handshake waits."""

    def __init__(self) -> None:
        self.controller = StubController()
        self.ports: list[StubPort] = []
        self.refuse_opening = 0
        self.now_ns = 10**12
        self.options = RigOptions(link=LinkOptions(rto_initial_ns=25_000_000))

    def open_port(self, baud: int) -> Transport:
        """Open another port, unless the test forbids it for a while."""
        if self.refuse_opening:
            self.refuse_opening -= 1
            raise PortError("stub: no such port")
        self.ports.append(StubPort(self.controller, baud))
        return self.ports[-1]

    @property
    def port(self) -> StubPort:
        """The port in use."""
        return self.ports[-1]

    def clock_ns(self) -> int:
        """Return a time that advances by 10 ms each time it is asked for."""
        self.now_ns += 10_000_000
        return self.now_ns

    def handshake(self) -> Handshake:
        """Return a handshake on this bench."""
        return Handshake(self.open_port, "stub", self.options, self.clock_ns)

    @staticmethod
    def pull(rig: Rig, samples: int) -> list[SampleBlock]:
        """Return blocks until `samples` samples have come, at most for ten seconds."""
        blocks: list[SampleBlock] = []
        for _ in range(200):
            blocks += rig.next_blocks(0.05)
            if sum(block.ticks.size for block in blocks) >= samples:
                break
        return blocks

    @staticmethod
    def wait_until(condition: Callable[[], bool], rig: Rig) -> bool:
        """Poll a condition while the rig's thread works, at most for ten seconds."""
        tries = 200
        while not condition() and (tries := tries - 1):
            rig.next_blocks(0.05)
        return condition()


@pytest.fixture
def bench() -> Bench:
    return Bench()


@pytest.fixture
def open_stub(bench: Bench) -> Iterator[Callable[[], Rig]]:
    """Return a function that opens a rig on the bench; rigs are closed at the end."""
    rigs: list[Rig] = []

    def open_it() -> Rig:
        handshake = Handshake(bench.open_port, "stub", bench.options, time.monotonic_ns)
        connection = handshake.connect(bench.options.start_baud, SinkTap())
        port = PortThread(connection, handshake, bench.options, time.monotonic_ns)
        port.start()
        rigs.append(Rig(port, bench.options))
        return rigs[-1]

    yield open_it
    for rig in rigs:
        rig.close()
