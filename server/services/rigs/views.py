"""What a rig tells about itself, as plain records: the API turns them into JSON, the page shows them."""

from dataclasses import dataclass

from daq.driver.link_statistics import LinkStatistics
from daq.driver.rig import Rig as DriverRig
from daq.protocol.codes import DriveState
from daq.protocol.dictionary import Dictionary
from daq.protocol.dictionary_entries import FaultText, Parameter
from server.services.rigs.lease import LeaseView
from server.services.rigs.worker import ConnectionState


@dataclass(frozen=True, slots=True, kw_only=True)
class FaultView:
    """One latched fault with the controller's own text and remedy."""

    name: str
    text: str
    remedy: str


@dataclass(frozen=True, slots=True, kw_only=True)
class DriveView:
    """The drive, from the controller's last STATUS.

    Attributes:
        state: lower-case name of a `DriveState`.
        faults: what is latched.
        lease_left_ms: what is left of the drive's lease.
        tick: controller tick of this status, 32 bits.
        bus_voltage_v: DC link.
        temperature_degc: power stage.
    """

    state: str
    faults: tuple[FaultView, ...]
    lease_left_ms: int
    tick: int
    bus_voltage_v: float
    temperature_degc: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ControllerView:
    """What the controller says of itself."""

    device: str
    firmware: str
    serial_number: int
    protocol: int
    tick_hz: int
    baud: int
    reboots: int


@dataclass(frozen=True, slots=True, kw_only=True)
class RigView:
    """One rig at a glance; `controller` and `drive` only while connected."""

    id: str
    description: str
    url: str
    emulated: bool
    connection: ConnectionState
    trouble: str
    armed: bool
    busy_with: str | None
    viewers: int
    lease: LeaseView | None
    warnings: tuple[str, ...]
    controller: ControllerView | None
    drive: DriveView | None


@dataclass(frozen=True, slots=True, kw_only=True)
class ParameterView:
    """A controller parameter with its unit and limits, all SI; `value` is the one in force."""

    name: str
    unit: str
    value: float
    minimum: float
    maximum: float
    default: float
    writable: bool
    writable_armed: bool
    doc: str


@dataclass(frozen=True, slots=True, kw_only=True)
class CaptureRequest:
    """What to capture and when.

    Attributes:
        layout: name of a layout of the controller's dictionary.
        trigger: `now`, `level` (a channel rises through a level) or `fault` (the drive trips).
        decimation: controller ticks per captured sample.
        pretrigger_percent: share of the buffer kept from before the trigger.
        column: SI column that triggers, for `level` only.
        level: of that column, in its unit, for `level` only.
    """

    layout: str = "phases"
    trigger: str = "now"
    decimation: int = 1
    pretrigger_percent: int = 50
    column: str = ""
    level: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class CaptureView:
    """A finished capture: columns in SI, one value a captured sample."""

    trigger_tick: int
    sample_time_s: float
    columns: dict[str, list[float]]


def controller_view(driver: DriverRig) -> ControllerView:
    """Describe the controller."""
    hello = driver.hello
    return ControllerView(
        device=driver.dictionary.device,
        firmware=driver.dictionary.firmware,
        serial_number=hello.serial_number,
        protocol=hello.version,
        tick_hz=hello.tick_hz,
        baud=driver.baud,
        reboots=driver.reboots,
    )


def drive_view(driver: DriverRig) -> DriveView | None:
    """Describe the drive; None before the first STATUS."""
    status = driver.status
    if status is None:
        return None
    return DriveView(
        state=state_name(status.state),
        faults=fault_views(status.faults, driver.dictionary),
        lease_left_ms=status.lease_left_ms,
        tick=status.tick,
        bus_voltage_v=status.bus_decivolt / 10.0,
        temperature_degc=status.temperature_decicelsius / 10.0,
    )


def state_name(state: int) -> str:
    """Return the lower-case name of a drive state."""
    return DriveState(state).name.lower() if state in tuple(DriveState) else f"unknown_{state}"


def fault_views(faults: int, dictionary: Dictionary) -> tuple[FaultView, ...]:
    """Return the latched faults of a fault word."""
    known = {fault.bit: fault for fault in dictionary.faults}
    return tuple(_fault_view(bit, known) for bit in range(16) if faults >> bit & 1)


def parameter_view(parameter: Parameter, value: float) -> ParameterView:
    """Describe a parameter with its value in force."""
    return ParameterView(
        name=parameter.name,
        unit=parameter.unit,
        value=value,
        minimum=parameter.minimum,
        maximum=parameter.maximum,
        default=parameter.default,
        writable=parameter.writable,
        writable_armed=parameter.writable_armed,
        doc=parameter.doc,
    )


def link_figures(statistics: LinkStatistics) -> dict[str, float]:
    """Return the numbers of a link record by name, for metrics."""
    names = (
        "octets",
        "frames",
        "bad_frames",
        "commands_retried",
        "commands_lost",
        "samples_lost",
        "queue_dropped_frames",
        "reconnects",
        "controller_rx_errors",
        "controller_tx_drops",
    )
    return {name: float(getattr(statistics, name)) for name in names}


def _fault_view(bit: int, known: dict[int, FaultText]) -> FaultView:
    fault = known.get(bit)
    if fault is None:
        return FaultView(
            name=f"bit_{bit}", text="The controller's dictionary does not explain it.", remedy=""
        )
    return FaultView(name=fault.name, text=fault.text, remedy=fault.remedy)
