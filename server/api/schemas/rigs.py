"""Rigs as JSON."""

from typing import Annotated, Literal

from pydantic import Field, StrictBool

from server.api.schemas.base import Answer, Request
from server.services.rigs.lease import MAX_TTL_S, MIN_TTL_S
from server.services.rigs.worker import ConnectionState


class FaultAnswer(Answer):
    """One latched fault."""

    name: str = Field(examples=["over_current"])
    text: str = Field(description="The controller's own words.")
    remedy: str = Field(description="What the controller says to do.")


class DriveAnswer(Answer):
    """The drive, from the controller's last status; ten a second."""

    state: str = Field(examples=["idle"], description="idle, armed, running, ramping, safe_timeout or fault.")
    faults: list[FaultAnswer]
    lease_left_ms: int = Field(description="What is left of the drive's own lease, ms.")
    tick: int = Field(description="Controller tick of this status, 32 bits.")
    bus_voltage_v: float = Field(examples=[540.0])
    temperature_degc: float = Field(examples=[31.5])


class ControllerAnswer(Answer):
    """What the controller says of itself."""

    device: str
    firmware: str
    serial_number: int
    protocol: int
    tick_hz: int = Field(examples=[2500])
    baud: int = Field(examples=[937500])
    reboots: int = Field(description="Restarts since it was connected.")


class LeaseAnswer(Answer):
    """Who holds a rig; the lease's id is known to its holder alone."""

    holder: str = Field(description="Name of the token that holds it.", examples=["lab bench 2"])
    token_id: str
    expires_in_s: float = Field(examples=[8.7])


class RigAnswer(Answer):
    """One rig at a glance."""

    id: str = Field(examples=["emulated"])
    description: str
    url: str = Field(description="Port, or `emulate`.", examples=["/dev/ttyUSB0"])
    emulated: bool
    connection: ConnectionState
    trouble: str = Field(description="What goes wrong now, in plain words; empty when nothing does.")
    armed: bool = Field(description="Whether the service has switched the drive on.")
    busy_with: str | None = Field(description="What the rig is at work on.")
    viewers: int = Field(description="How many watch its samples.")
    lease: LeaseAnswer | None
    warnings: list[str]
    controller: ControllerAnswer | None = Field(description="Only while connected.")
    drive: DriveAnswer | None = Field(description="Only while connected.")


class RigList(Answer):
    """All rigs."""

    items: list[RigAnswer]


class ParameterAnswer(Answer):
    """A controller parameter, all values SI."""

    name: str = Field(examples=["current_limit_A"])
    unit: str = Field(examples=["A"])
    value: float = Field(description="In force now.", examples=[2.0])
    minimum: float
    maximum: float
    default: float
    writable: bool
    writable_armed: bool = Field(description="Whether it may change while the drive is on.")
    doc: str


class ParameterList(Answer):
    """All parameters of a controller."""

    items: list[ParameterAnswer]


class ParameterWrite(Request):
    """A new value."""

    value: float = Field(description="SI, in the parameter's unit.", examples=[1.5])


class LinkAnswer(Answer):
    """The link's last record, at most a second old; counters start at 0 with the connection and only go up."""

    baud: int
    octets: int
    frames: int
    bad_frames: int = Field(description="Dropped for a wrong CRC, stuffing or length.")
    commands_retried: int
    commands_lost: int
    samples_lost: int
    queue_dropped_frames: int
    reconnects: int
    stall_s: float = Field(description="Longest time that the reader was kept from the port in that second.")
    octets_per_s: float
    controller_rx_errors: int
    controller_tx_drops: int
    controller_isr_max_us: int
    cause: str = Field(description="What went wrong in that second, in plain words.")


class CaptureBody(Request):
    """What to capture and when."""

    layout: str = Field(default="phases", max_length=80, examples=["phases"])
    trigger: Literal["now", "level", "fault"] = "now"
    decimation: Annotated[int, Field(ge=1, le=65535)] = 1
    pretrigger_percent: Annotated[int, Field(ge=0, le=100)] = 50
    column: str = Field(default="", max_length=80, description="SI column that triggers; for `level` only.")
    level: float = Field(default=0.0, description="In that column's unit; for `level` only.")


class CaptureStarted(Answer):
    """The buffer is armed."""

    samples: int = Field(description="How many samples it will hold.", examples=[819])


class CaptureAnswer(Answer):
    """A capture, if it is complete."""

    complete: bool
    trigger_tick: int | None = Field(default=None, description="Controller tick of the trigger, 32 bits.")
    sample_time_s: float | None = None
    columns: dict[str, list[float]] = Field(default_factory=dict, description="SI, one value a sample.")


class LeaseBody(Request):
    """A wish for the lease."""

    ttl_s: Annotated[float, Field(ge=MIN_TTL_S, le=MAX_TTL_S)] = Field(
        default=10.0, description="It ends so long after the last renewal, s."
    )
    take_over: StrictBool = Field(
        default=False, description="Take it from its holder; the drive ramps down first."
    )


class LeaseGranted(Answer):
    """The lease is yours."""

    id: str = Field(description="Send it as the header Jointscope-Lease; keep it to yourself.")
    holder: str
    ttl_s: float
    expires_in_s: float


class LeaseRenewal(Request):
    """Hold on to the lease."""

    ttl_s: Annotated[float, Field(ge=MIN_TTL_S, le=MAX_TTL_S)] | None = Field(
        default=None, description="A new length; the old one stays otherwise."
    )
