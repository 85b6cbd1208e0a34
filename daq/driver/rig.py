"""A rig as scripts and services see it: open it, read and write parameters, stream, drive, stop.

All calls may come from any thread; those that send a command wait for its reply. The data task, and nobody else,
calls `next_blocks` and `keep_alive`.
"""

import time
from contextlib import suppress
from dataclasses import replace
from functools import partial
from types import TracebackType

from daq.driver.batch_gathering import BatchGathering
from daq.driver.discovery import describe_devices, list_devices
from daq.driver.drive import Drive
from daq.driver.handshake import Handshake, expect
from daq.driver.link_statistics import LinkStatistics
from daq.driver.options import RigOptions, StreamPlan
from daq.driver.parameters import Parameters
from daq.driver.port_thread import PortThread
from daq.driver.refusals import check_reply
from daq.driver.sink import RecordSink, SinkTap
from daq.driver.wave_upload import upload_table
from daq.driver.wire_budget import WireBudget, plan_wire
from daq.errors import DaqError, DeviceFaultError, DeviceRefusedError, PortError
from daq.excitation.spec import Excitation, Table
from daq.protocol.codes import StatusCode
from daq.protocol.commands import RunAbort, StreamConfig, StreamStart, StreamStop
from daq.protocol.dictionary import Dictionary
from daq.protocol.message import Command, Reply
from daq.protocol.replies import (
    HelloReply,
    RunAbortReply,
    RunReply,
    StreamConfigReply,
    StreamStartReply,
    StreamStopReply,
)
from daq.protocol.reports import Event, Status
from daq.protocol.stream import SampleBlock, StreamAssembler
from daq.transport.opening import open_transport
from daq.transport.serial_port import latency_timer_warning


class Rig:
    """One controller, owned by this process until `close`; made by `open_rig`.

    Args:
        port: The thread that owns the port, started.
        options: As given to `open_rig`.
    """

    def __init__(self, port: PortThread, options: RigOptions) -> None:
        self._port = port
        self._options = options
        self._assembler = StreamAssembler(self.dictionary)
        self.parameters = Parameters(self.dictionary, self.ask)
        self._drive = Drive(port, self.parameters, time.monotonic_ns, options.may_keep_alive)
        self._gathering = BatchGathering(self.hello.tick_hz)
        self._newest_tick: int | None = None

    def __enter__(self) -> "Rig":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Switch the drive off if it is on, and give the port back."""
        if self.armed:
            # With the link gone there is no way to ask; the controller's lease switches the drive off by itself.
            with suppress(DaqError):
                self.disarm()
        self._port.close()

    @property
    def hello(self) -> HelloReply:
        """What the controller says of itself; after a restart, what it said then."""
        return self._port.connection.hello

    @property
    def dictionary(self) -> Dictionary:
        """The controller's dictionary."""
        return self._port.connection.dictionary

    @property
    def dictionary_octets(self) -> bytes:
        """The dictionary as the controller serves it, for the journal's header."""
        return self._port.connection.dictionary_octets

    @property
    def baud(self) -> int:
        """Rate in use, 1/s."""
        return self._port.connection.baud

    @property
    def warnings(self) -> tuple[str, ...]:
        """What did not go as wished while opening, in words."""
        return self._port.connection.warnings

    @property
    def status(self) -> Status | None:
        """The controller's last STATUS, ten a second; None before the first."""
        return self._port.status

    @property
    def link_up(self) -> bool:
        """False while a lost port is being looked for, and after it was given up."""
        return self._port.link_up

    @property
    def reboots(self) -> int:
        """Times the controller has restarted since the rig was opened."""
        return self._port.reboots

    @property
    def armed(self) -> bool:
        """Whether this rig object holds the drive's lease, as far as it knows."""
        return self._drive.armed

    @property
    def lease_refusal(self) -> DeviceRefusedError | None:
        """Why the controller renewed the lease no more; None while all is well."""
        return self._drive.lease_refusal

    def link_statistics(self) -> LinkStatistics:
        """Return the last record of the link, at most a second old."""
        return self._port.monitor.statistics

    def events(self) -> list[Event]:
        """Return the controller's events since the last call."""
        return self._port.take_events()

    def attach(self, sink: RecordSink) -> None:
        """Let `sink` have every octet from now on, before it is decoded."""
        self._port.tap.attach(sink)

    def detach(self) -> None:
        """Take the sink off again."""
        self._port.tap.detach()

    def ask(self, command: Command, detail: str = "") -> Reply:
        """Send a command and return its reply.

        Args:
            command: What to send.
            detail: Value and limit concerned, for the message of a refusal.

        Raises:
            DeviceFaultError: It refused because a fault is latched.
            DeviceRefusedError: It refused for another reason.
            LinkTimeoutError: No reply after the last try.
            PortError: The port is lost.
        """
        reply = self._port.ask(command)
        if reply.status in (StatusCode.FAULT_LATCHED, StatusCode.ESTOP_LATCHED):
            raise self.latched_fault()
        check_reply(command, reply, detail)
        return reply

    def read_parameter(self, name: str) -> float:
        """Return a parameter's value in force, SI; see `Parameters.read`."""
        return self.parameters.read(name)

    def write_parameter(self, name: str, value_si: float) -> float:
        """Write a parameter and return the value now in force, SI; see `Parameters.write`."""
        return self.parameters.write(name, value_si)

    def start_stream(self, plan: StreamPlan) -> WireBudget:
        """Start streaming what `plan` says, if it fits the line.

        Raises:
            WireBudgetError: It does not; the message proposes a stream that does.
            DeviceRefusedError: The controller cannot send this.
        """
        limit = self._options.line_use_limit
        budget = plan_wire(plan, self.dictionary, baud=self.baud, tick_hz=self.hello.tick_hz, limit=limit)
        # A host that died may have left a stream running, which would be refused another configuration.
        expect(self.ask(StreamStop()), StreamStopReply)
        command = StreamConfig(layout=budget.layout_id, divisor=budget.divisor, batch=budget.batch)
        expect(self.ask(command), StreamConfigReply)
        expect(self.ask(StreamStart()), StreamStartReply)
        return budget

    def stop_stream(self) -> None:
        """Stop streaming; what is under way still comes by `next_blocks`."""
        expect(self.ask(StreamStop()), StreamStopReply)

    def next_blocks(self, timeout_s: float) -> list[SampleBlock]:
        """Return the samples received since the last call, waiting up to `timeout_s` for the first.

        Raises:
            JournalWriteError: The sink could not keep what was received.
            PortError: The port is lost for good.
        """
        self._port.frames.wait(timeout_s)
        self._gathering.pause()
        frames = self._port.frames.take()
        if self._port.tap.failure is not None:
            raise self._port.tap.failure
        if not frames and self._port.failure is not None:
            raise self._port.failure
        blocks = self._assembler.feed(frames)
        self._port.samples_lost = self._assembler.counters.missing_samples
        for block in blocks:
            if block.ticks.size:
                self._newest_tick = int(block.ticks[-1])
                self._gathering.note_samples(self._newest_tick)
        return blocks

    def arm(self, lease_ms: int = 250) -> int:
        """Switch the drive on under a lease and return the lease granted, ms.

        From now on somebody must call `keep_alive` at each batch of data, or the drive ramps down by itself.

        Raises:
            DeviceFaultError: A fault is latched.
            DeviceRefusedError: Another refusal, for example of the lease's length.
        """
        return self._drive.arm(lease_ms)

    def keep_alive(self) -> None:
        """Renew the drive's lease if a quarter of it is over; called by the task that handles the data.

        Does nothing while the drive is off. Does not wait for the reply: `lease_refusal` tells of a refusal.
        """
        self._drive.keep_alive(self._newest_tick)

    def run(self, excitation: Excitation, *, centring: bool = True, start_tick: int = 0) -> int:
        """Play an excitation (uploading its table first) and return the tick of its first value.

        Raises:
            ValueError: A field lies outside what the generator can play.
            DeviceRefusedError: Drive not armed, or beyond the controller's own limits.
        """
        command = excitation.to_run_command(self.hello.tick_hz, centring=centring, start_tick=start_tick)
        if isinstance(excitation, Table):
            upload_table(excitation, self.ask)
        peak_a = abs(excitation.amplitude_a) + abs(excitation.offset_a)
        reply = self.ask(
            command, f"peak {peak_a:g} A, ramp {excitation.ramp_s:g} s, run {excitation.duration_s:g} s"
        )
        return expect(reply, RunReply).start_tick

    def abort(self) -> int:
        """Ramp the excitation to zero, leave the drive armed, and return the tick at which the ramp began."""
        return expect(self.ask(RunAbort()), RunAbortReply).tick

    def disarm(self) -> None:
        """Ramp to zero and switch the drive off."""
        self._drive.disarm()

    def estop(self) -> None:
        """Switch the drive off at once, in any state; latched until `clear_fault`. Sent three times over.

        This is a convenience beside a wired emergency stop, not a replacement for it.
        """
        self._drive.estop()

    def clear_fault(self) -> None:
        """Leave the fault or the safe state, once the cause is gone.

        Raises:
            DeviceFaultError: Faults that are still present.
        """
        self._drive.clear_fault()

    def latched_fault(self, tick: int | None = None) -> DeviceFaultError:
        """Return the error that names the faults of the last STATUS with the controller's texts and remedies."""
        return self._drive.latched_fault(tick)


def open_rig(url: str, options: RigOptions | None = None) -> Rig:
    """Open the controller at `url` for this process alone.

    Args:
        url: `/dev/ttyUSB0`, a pseudo-terminal's path or link, or `socket://host:port`.
        options: How to reach it; defaults suit the documented controller.

    Raises:
        PortError: No such port (the message lists those found), taken, or nobody understandable there.
        ProtocolVersionError: The controller speaks no protocol version of ours.
        DictionaryError: Its dictionary is not what it announced.
    """
    options = options or RigOptions()
    handshake = Handshake(partial(open_transport, url), url, options, time.monotonic_ns)
    try:
        connection = handshake.connect(options.start_baud, SinkTap())
    except PortError as error:
        if "does not exist" not in str(error):
            raise
        raise PortError(f"{error}; {describe_devices(list_devices())}") from error
    latency = latency_timer_warning(url)
    if latency is not None:
        connection = replace(connection, warnings=(*connection.warnings, latency))
    port = PortThread(connection, handshake, options, time.monotonic_ns)
    port.start()
    return Rig(port, options)
