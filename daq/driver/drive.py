"""The drive: switched on under a lease, kept on by the data task alone, switched off by anybody."""

from collections.abc import Callable
from functools import partial

from daq.driver.conversation import Clock
from daq.driver.handshake import expect
from daq.driver.lease import Lease
from daq.driver.parameters import Parameters
from daq.driver.port_thread import PortThread
from daq.driver.refusals import check_reply, fault_error
from daq.errors import DaqError, DeviceFaultError, DeviceRefusedError
from daq.protocol.codes import DriveState, StatusCode
from daq.protocol.commands import Arm, ClearFault, Disarm, Estop, KeepAlive
from daq.protocol.message import Reply
from daq.protocol.replies import ArmReply, ClearFaultReply

_MAX_KEEP_ALIVES = 2
"""Keep-alives under way at once: enough to survive one lost frame, few enough to leave the line to others."""


class Drive:
    """The lease of one controller's drive.

    Args:
        port: How to reach the controller.
        parameters: Its parameters: ARM must prove that we know its limits.
        clock_ns: Host monotonic clock, ns.
        permit: Asked before each keep-alive; a no lets the lease expire. None always permits.
    """

    def __init__(
        self,
        port: PortThread,
        parameters: Parameters,
        clock_ns: Clock,
        permit: Callable[[], bool] | None = None,
    ) -> None:
        self._port = port
        self._parameters = parameters
        self._clock_ns = clock_ns
        self._permit = permit
        self._under_way = 0
        self._disarmed = False
        self.lease: Lease | None = None
        self.lease_refusal: DeviceRefusedError | None = None

    @property
    def armed(self) -> bool:
        """Whether the drive was switched on and not off again, as far as we know."""
        return self.lease is not None and not self._disarmed

    def arm(self, lease_ms: int) -> int:
        """Switch the drive on and return the lease granted, ms; see `Rig.arm`."""
        session = self._port.connection.hello.session
        command = Arm(session=session, lease_ms=lease_ms, limits_crc=self._parameters.limits_crc())
        reply = self._port.ask(command)
        if reply.status in (StatusCode.FAULT_LATCHED, StatusCode.ESTOP_LATCHED):
            raise self.latched_fault()
        check_reply(command, reply, f"lease_ms={lease_ms}")
        granted_ms = expect(reply, ArmReply).lease_ms
        self.lease_refusal, self._disarmed = None, False
        self.lease = Lease(session, granted_ms, self._port.connection.hello.tick_hz, self._clock_ns())
        return granted_ms

    def keep_alive(self, tick: int | None) -> None:
        """Renew the lease if a quarter of it is over; see `Rig.keep_alive`."""
        lease, t_ns = self.lease, self._clock_ns()
        if lease is None or self._under_way >= _MAX_KEEP_ALIVES or not self._port.link_up:
            return
        if lease.is_due(tick, t_ns) and (self._permit is None or self._permit()):
            lease.renew(tick, t_ns)
            self._under_way += 1
            command = KeepAlive(session=lease.session)
            self._port.post(command, partial(self._settle, command, lease))

    def disarm(self) -> None:
        """Ramp to zero and switch off.

        The ramp still runs under the lease, which `keep_alive` goes on to renew: without that, a ramp as long as what
        is left of the lease would end in the latched safe state. The controller's refusal shows that it rests.
        """
        self._disarmed = True
        try:
            self._ask(Disarm())
        except DaqError:
            self._disarmed = False
            raise

    def estop(self) -> None:
        """Switch off at once and latch."""
        self.lease = None
        self._ask(Estop())

    def clear_fault(self) -> None:
        """Leave the fault or the safe state; DeviceFaultError names what is still present."""
        command = ClearFault()
        reply = self._port.ask(command)
        if isinstance(reply, ClearFaultReply) and reply.faults:
            raise fault_error(reply.faults, self._port.connection.dictionary)
        check_reply(command, reply)

    def latched_fault(self, tick: int | None = None) -> DeviceFaultError:
        """Return the error that names the faults of the last STATUS."""
        status = self._port.status
        if status is not None and status.state == DriveState.SAFE_TIMEOUT:
            return DeviceFaultError(
                "the drive is in its safe state, because its lease ran out (a host died, or was too slow); "
                "see that the rig is safe, then clear the fault",
                faults=status.faults,
                tick=tick,
            )
        return fault_error(status.faults if status else 0, self._port.connection.dictionary, tick)

    def _ask(self, command: Disarm | Estop) -> None:
        """Send a command that is refused only if something is badly wrong."""
        check_reply(command, self._port.ask(command))

    def _settle(self, command: KeepAlive, lease: Lease, outcome: Reply | DaqError, t_ns: int) -> None:
        """Take what came of a keep-alive; runs in the port thread."""
        self._under_way -= 1
        if isinstance(outcome, Reply) and self.lease is lease:
            try:
                check_reply(command, outcome)
            except DeviceRefusedError as refusal:
                self.lease = None
                self.lease_refusal = None if self._disarmed else refusal
