"""One rig of the service: its file, its data task, its operator lease, and what may be asked of it.

Nothing here waits for samples. Calls that ask the controller block for its reply: the API runs them in threads.
"""

from concurrent.futures import Future
from pathlib import Path
from typing import TypeVar

from daq.driver.capture import CapturePlan, read_capture, start_capture
from daq.driver.link_statistics import LinkStatistics
from daq.driver.rig import Rig as DriverRig
from daq.protocol.reports import Event
from daq.protocol.stream import SampleBlock
from server.config.rig import EMULATE, Rig
from server.services.errors import BusyError, InvalidValueError, NotFoundError
from server.services.events import EventLog, ServiceEvent
from server.services.rig_access import RigHooks
from server.services.rigs.calibrated import capture_plan, channel_columns, to_columns
from server.services.rigs.fanout import Fanout
from server.services.rigs.happenings import describe_event
from server.services.rigs.lease import Grant, LeaseEnd, OperatorLease
from server.services.rigs.lease_ledger import LeaseLedger
from server.services.rigs.views import (
    CaptureRequest,
    CaptureView,
    ParameterView,
    RigView,
    controller_view,
    drive_view,
    link_figures,
    parameter_view,
)
from server.services.rigs.worker import ConnectionState, RigJob, RigWorker
from server.services.tokens import Principal

T = TypeVar("T")
CONNECT_WAIT_S = 60.0


class ServedRig:
    """A rig that the service holds.

    Args:
        rig: its file's content.
        path: the file.
        events: told what happens.
        ledger: where leases are written down.
    """

    def __init__(self, rig: Rig, path: Path, events: EventLog, ledger: LeaseLedger) -> None:
        self.rig = rig
        self.path = path
        self.samples: Fanout[SampleBlock] = Fanout()
        self.lease = OperatorLease(self._tell_lease_end)
        hooks = RigHooks(may_keep_alive=self.lease.is_live, on_event=self._hear)
        self.worker = RigWorker(rig, path, hooks, self.samples)
        self._events = events
        self._ledger = ledger
        self._capture: CapturePlan | None = None
        self._told = ConnectionState.DISCONNECTED

    @property
    def id(self) -> str:
        """Name in paths and tables."""
        return self.rig.name

    def view(self) -> RigView:
        """Describe the rig; never waits."""
        driver, worker = self.worker.open_driver, self.worker
        trouble = str(worker.failure or "") if driver is None else driver.link_statistics().cause
        return RigView(
            id=self.id,
            description=self.rig.description,
            url=self.rig.link.url,
            emulated=self.rig.link.url == EMULATE,
            connection=worker.connection,
            trouble=trouble,
            armed=driver is not None and driver.armed,
            busy_with=worker.busy_with,
            viewers=self.samples.subscribers,
            lease=self.lease.view(),
            warnings=() if driver is None else driver.warnings,
            controller=None if driver is None else controller_view(driver),
            drive=None if driver is None else drive_view(driver),
        )

    def connect(self, wait_s: float = CONNECT_WAIT_S) -> RigView:
        """Open the rig; returns when it is open, or still at it after `wait_s`.

        Raises:
            InputError: no such port, or nobody there.
            DaqError: what the controller refused.
        """
        self.worker.start()
        self.worker.wait_connected(wait_s)
        self.watch()
        return self.view()

    def disconnect(self) -> RigView:
        """Give the port back.

        Raises:
            BusyError: the rig is at work.
        """
        if self.worker.busy_with is not None:
            raise BusyError(f"rig {self.id} is busy with {self.worker.busy_with}", "stop it first")
        self.worker.close()
        self.watch()
        return self.view()

    def close(self) -> None:
        """Stop work, ramp down, give the port back; at the end of the service."""
        self.worker.close()
        self.samples.close()

    def perform(self, job: RigJob[T], lease_id: str) -> "Future[T]":
        """Do work on the rig under a live operator lease; see `RigWorker.perform`.

        Raises:
            LeaseError: the lease is not live.
            ConflictError: not connected, or busy.
        """
        self.lease.check(lease_id)
        return self.worker.perform(job)

    def acquire(self, who: Principal, ttl_s: float) -> Grant:
        """Take the lease of a rig that nobody holds.

        Raises:
            LeaseError: somebody holds it.
        """
        return self._begin_lease(self.lease.acquire(who, ttl_s))

    def take_over(self, who: Principal, ttl_s: float) -> Grant:
        """Take the lease from its holder, after the drive has come to rest."""
        return self._begin_lease(self.lease.take_over(who, ttl_s, self.worker.come_to_rest))

    def release(self, lease_id: str) -> None:
        """Give the lease back, after the drive has come to rest.

        Raises:
            LeaseError: it has ended, or is somebody else's.
        """
        self.lease.check(lease_id)
        self.worker.come_to_rest()
        self.lease.release(lease_id)

    def parameters(self) -> list[ParameterView]:
        """Read all parameters from the controller."""
        driver = self.worker.driver
        values = driver.parameters.read_all()
        return [parameter_view(each, values[each.name]) for each in driver.dictionary.parameters]

    def parameter(self, name: str) -> ParameterView:
        """Read one parameter.

        Raises:
            NotFoundError: the controller has no such parameter.
        """
        driver = self.worker.driver
        try:
            entry = driver.dictionary.parameter(name)
        except KeyError as error:
            raise NotFoundError("parameter", name, str(error.args[0])) from error
        return parameter_view(entry, driver.read_parameter(name))

    def write_parameter(self, name: str, value: float) -> ParameterView:
        """Write a parameter, SI, and return it with the value now in force.

        Raises:
            NotFoundError: the controller has no such parameter.
            InvalidValueError: the value lies outside the controller's range.
            DeviceRefusedError: read-only, or locked while the drive is armed.
        """
        driver, entry = self.worker.driver, self.parameter(name)
        try:
            in_force = driver.write_parameter(name, value)
        except ValueError as error:
            allowed = f"[{entry.minimum:g}, {entry.maximum:g}] {entry.unit}"
            raise InvalidValueError(
                str(error), field="value", value=value, remedy=f"give a value in {allowed}"
            ) from error
        return parameter_view(driver.dictionary.parameter(name), in_force)

    def link_figures(self) -> dict[str, float]:
        """Return the link's numbers by name, for metrics; none while the rig is not connected."""
        driver = self.worker.open_driver
        return {} if driver is None else link_figures(driver.link_statistics())

    def link_statistics(self) -> LinkStatistics:
        """Return the link's last record, at most a second old."""
        return self.worker.driver.link_statistics()

    def start_capture(self, request: CaptureRequest) -> int:
        """Arm the capture buffer and return how many samples it will hold.

        Raises:
            InvalidValueError: no such layout or column.
            DeviceRefusedError: the controller refuses the plan.
        """
        driver = self.worker.driver
        plan = capture_plan(request, driver.dictionary, channel_columns(driver, self.rig))
        depth = start_capture(plan, driver.dictionary, driver.ask)
        self._capture = plan
        return depth

    def read_capture(self) -> CaptureView | None:
        """Return the capture in SI, None while it is not complete.

        Raises:
            NotFoundError: none was started.
        """
        driver, plan = self.worker.driver, self._capture
        if plan is None:
            raise NotFoundError("capture", self.id, "start one by POST to the same address")
        capture = read_capture(plan, driver.dictionary, driver.ask)
        if capture is None:
            return None
        columns = to_columns(capture.counts, channel_columns(driver, self.rig))
        return CaptureView(
            trigger_tick=capture.trigger_tick,
            sample_time_s=plan.decimation / driver.hello.tick_hz,
            columns={name: values.tolist() for name, values in columns.items()},
        )

    def estop(self) -> None:
        """Switch the drive off at once and latch; needs no lease, and answers while the rig is at work."""
        self.worker.driver.estop()

    def clear_fault(self) -> None:
        """Leave a latched fault or safe state.

        Raises:
            DeviceFaultError: what is still present.
        """
        self.worker.driver.clear_fault()

    def watch(self) -> None:
        """Look at lease and connection, and tell what has changed; called some ten times a second."""
        self.lease.expire()
        now = self.worker.connection
        if now is not self._told:
            before, self._told = self._told, now
            detail = f": {self.worker.failure}" if self.worker.failure is not None else ""
            self.tell("rig.connection", f"rig {self.id} is {now}{detail}", before=before, connection=now)

    def tell(self, kind: str, text: str, **data: object) -> None:
        """Store an event that the host noticed."""
        self._events.publish(ServiceEvent(rig_id=self.id, kind=kind, text=text, data=data))

    def _hear(self, event: Event) -> None:
        driver: DriverRig | None = self.worker.open_driver
        dictionary = None if driver is None else driver.dictionary
        self._events.publish(describe_event(self.id, event, dictionary))

    def _begin_lease(self, grant: Grant) -> Grant:
        self._ledger.begin(self.id, grant)
        self.tell(
            "lease.acquired",
            f"{grant.holder} holds the rig",
            holder=grant.holder,
            token_id=grant.token_id,
            ttl_s=grant.ttl_s,
        )
        return grant

    def _tell_lease_end(self, grant: Grant, how: LeaseEnd) -> None:
        self._ledger.end(grant, how)
        self.tell(
            f"lease.{how}",
            f"the lease of {grant.holder} has ended: {how.replace('_', ' ')}",
            holder=grant.holder,
            token_id=grant.token_id,
        )
