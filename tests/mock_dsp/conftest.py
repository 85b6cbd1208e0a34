"""A controller's program and a host in one memory: no port, no clock, a plant that obeys at once."""

import zlib
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from daq.protocol.codes import CURRENT_COUNT_A, DriveState, EventCode, FaultBit
from daq.protocol.commands import Arm, Hello, Run
from daq.protocol.dictionary import build_dictionary
from daq.protocol.host_link import HostLink
from daq.protocol.message import Command, Reply
from daq.protocol.messages import decode_message
from daq.protocol.replies import ArmReply, HelloReply
from daq.protocol.reports import Event, Status, Stream
from mock_dsp.control.parameters import FastLoopParameters
from mock_dsp.program.controller import Controller
from mock_dsp.program.dictionary import DICTIONARY
from mock_dsp.program.line_counters import LineCounters
from mock_dsp.program.parameters import ParameterStore
from mock_dsp.program.state import Identity

SESSION = 7
TICK_NS = 400_000
ROOM = 100_000


@dataclass(frozen=True, slots=True, kw_only=True)
class FakeTrace:
    """Words of a block; see `mock_dsp.program.plant.Trace`."""

    ticks_done: int
    trip: FaultBit | None
    limited: NDArray[np.bool_]
    current_ref_counts: NDArray[np.int16]
    current_counts: NDArray[np.int16]
    position_counts: NDArray[np.uint16]
    phase_a_counts: NDArray[np.int16]
    phase_b_counts: NDArray[np.int16]
    speed_counts: NDArray[np.int16]


class FakePlant:
    """A plant that follows its reference exactly and counts ticks in the position channel.

    Attributes:
        tick: ticks run so far.
        trip_tick: tick after which `trip` strikes, once.
        conditions: limits that the program finds violated.
        parameters: what the program set last.
    """

    def __init__(self) -> None:
        self.tick = 0
        self.trip_tick: int | None = None
        self.trip = FaultBit.OVER_CURRENT
        self.conditions: tuple[FaultBit, ...] = ()
        self.parameters = FastLoopParameters()
        self.bus_voltage_v = 540.0
        self.temperature_degc = 31.5
        self.reference_a: list[NDArray[np.float64]] = []
        self.weight: list[NDArray[np.float64]] = []

    def set_parameters(self, parameters: FastLoopParameters) -> None:
        """Take settings."""
        self.parameters = parameters

    def run(self, reference_a: NDArray[np.float64], centring_weight: NDArray[np.float64]) -> FakeTrace:
        """Advance, and stop after the tick that trips."""
        n = len(reference_a)
        trip = None
        if self.trip_tick is not None and self.tick <= self.trip_tick < self.tick + n:
            n = self.trip_tick - self.tick + 1
            trip, self.trip_tick = self.trip, None
        self.reference_a.append(reference_a[:n])
        self.weight.append(centring_weight[:n])
        limit = self.parameters.current_limit_a
        clipped = np.clip(reference_a[:n], -limit, limit)
        counts = np.floor(clipped / CURRENT_COUNT_A + 0.5).astype(np.int16)
        position = (np.arange(self.tick, self.tick + n) & 0xFFFF).astype(np.uint16)
        self.tick += n
        return FakeTrace(
            ticks_done=n,
            trip=trip,
            limited=np.abs(reference_a[:n]) > limit,
            current_ref_counts=counts,
            current_counts=counts,
            position_counts=position,
            phase_a_counts=counts,
            phase_b_counts=-counts,
            speed_counts=np.zeros(n, dtype=np.int16),
        )

    def played(self) -> NDArray[np.float64]:
        """Return every reference so far, one a tick."""
        return np.concatenate(self.reference_a)


class Bench:
    """A host and a controller whose octets reach each other at once.

    Attributes:
        plant: behind the controller.
        line: losses of the line; nobody loses anything here unless a test counts it up.
        flash: parameters kept over a restart.
    """

    def __init__(self) -> None:
        self.plant = FakePlant()
        self.line = LineCounters()
        self.flash: dict[int, int] = {}
        self.host = HostLink()
        self.events: list[Event] = []
        self.statuses: list[Status] = []
        self.frames: list[Stream] = []
        self._waited_ns = 0
        self.boot(SESSION)

    def boot(self, session: int) -> None:
        """Start the controller anew."""
        dictionary = build_dictionary(DICTIONARY)
        identity = Identity(session=session, dictionary=dictionary, dictionary_crc=zlib.crc32(dictionary))
        self.controller = Controller(identity, self.plant, self.flash, self.line)

    def ask(self, command: Command) -> Reply:
        """Send a command and return its reply, without letting time pass."""
        ticket = self.host.submit(command, self._t_ns)
        for _ in range(12):
            for answered, reply in self._exchange():
                if answered == ticket:
                    return reply
            # A second HELLO makes the controller forget what waits: the host repeats it after its time-out.
            self._waited_ns += 500_000_000
            self.host.poll(self._t_ns)
        raise AssertionError(f"no reply to {command}")

    def status_of(self, command: Command) -> int:
        """Send a command and return the status of its reply."""
        return self.ask(command).status

    def run_ticks(self, ticks: int) -> None:
        """Let time pass."""
        self.controller.advance(ticks)
        self._exchange()

    def greet(self) -> HelloReply:
        """Open a session."""
        reply = self.ask(Hello(proto_min=1, proto_max=1, cookie=99))
        assert isinstance(reply, HelloReply)
        return reply

    def arm(self, lease_ms: int = 2000) -> Reply:
        """Open a session and arm."""
        self.greet()
        return self.ask(
            Arm(session=SESSION, lease_ms=lease_ms, limits_crc=ParameterStore(self.flash).limits_crc())
        )

    def event_codes(self) -> list[EventCode]:
        """Return the codes of the events received so far, repetitions left out."""
        return [EventCode(event.code) for event in self.events]

    def drive_state(self) -> DriveState:
        """Drive state as the newest STATE event tells it."""
        states = [event.arg for event in self.events if event.code == EventCode.STATE]
        return DriveState(states[-1]) if states else DriveState.IDLE

    @property
    def _t_ns(self) -> int:
        return self.plant.tick * TICK_NS + self._waited_ns

    def _exchange(self) -> list[tuple[int, Reply]]:
        self.controller.receive(self.host.take_output())
        self.controller.serve(ROOM)
        octets = b"".join(frame.octets for frame in self.controller.take_frames())
        received = self.host.receive(octets, self._t_ns)
        self.events += received.events
        self.statuses += received.statuses
        for body in received.streams:
            _, message = decode_message(body)
            if isinstance(message, Stream):
                self.frames.append(message)
        return received.replies


@pytest.fixture
def fake_plant() -> FakePlant:
    """A plant that obeys at once."""
    return FakePlant()


@pytest.fixture
def bench() -> Bench:
    """A controller just booted, and a host."""
    return Bench()


@pytest.fixture
def make_bench() -> Callable[[], Bench]:
    """Make a fresh controller and host for each example of a property."""
    return Bench


@pytest.fixture
def armed(bench: Bench) -> Bench:
    """The same with a session open and the drive armed for 2 s."""
    reply = bench.arm()
    assert isinstance(reply, ArmReply) and reply.lease_ms == 2000
    return bench


RunMaker = Callable[..., Run]


@pytest.fixture
def make_run() -> RunMaker:
    """Make a RUN command: a sine of 1 A and 100 ticks unless told otherwise."""

    def make(**fields: int) -> Run:
        values = {
            "generator": 1,
            "flags": 0,
            "amplitude_ua": 1_000_000,
            "offset_ua": 0,
            "period_ticks": 100,
            "duration_ticks": 0,
            "phase": 0,
            "ramp_ticks": 0,
            "p1": 0,
            "p2": 0,
            "p3": 0,
            "p4": 0,
            "start_tick": 0,
        }
        return Run(**(values | fields))

    return make
