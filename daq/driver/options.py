"""What a caller may choose about a rig, a stream and a recording."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from daq.excitation.check import MotionPredictor, Nameplate
from daq.excitation.spec import Excitation, Setpoints
from daq.protocol.reports import Event
from daq.protocol.round_trip import LinkOptions


@dataclass(frozen=True, slots=True, kw_only=True)
class RigOptions:
    """How to reach a controller.

    Attributes:
        baud: Rate to work at, 1/s; must be one that the controller announces.
        start_baud: Rate that controllers start with, 1/s.
        cache_dir: Folder for dictionaries of known controllers; None keeps none.
        reconnect_s: How long to look for a port that was lost, s; 0 gives up at once.
        gather_s: How long to wait for the rest of a frame on a slow line, s.
        queue_frames: Frames that may wait for the data task; beyond that they are dropped and counted.
        line_use_limit: Largest share of the line that a stream may take.
        link: Waiting times and tries of commands.
        may_keep_alive: Asked before each keep-alive; a no lets the drive's lease expire. None always permits.
        on_event: Told of every event of the controller; runs in the port thread, so it must not wait.
    """

    baud: int = 937_500
    start_baud: int = 115_200
    cache_dir: Path | None = None
    reconnect_s: float = 10.0
    gather_s: float = 0.003
    queue_frames: int = 60_000
    line_use_limit: float = 0.8
    link: LinkOptions = field(default_factory=LinkOptions)
    may_keep_alive: Callable[[], bool] | None = None
    on_event: Callable[[Event], None] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class StreamPlan:
    """What the controller shall send.

    Attributes:
        layout: Name of a layout of the dictionary.
        divisor: Controller ticks per sample.
        batch: Samples per frame; None takes 25, or as many as a frame holds.
    """

    layout: str = "control"
    divisor: int = 1
    batch: int | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordPlan:
    """One recording with the drive on.

    Attributes:
        excitation: What is played.
        duration_s: Length of the recording from the excitation's first tick, s.
        nameplate: The joint as documented, or who knows it better, to predict where the excitation takes it.
        slew_limit_a_s: Steepest change of the reference that belt and gear bear, A/s.
        stream: What is recorded.
        centring: Hold the joint's mean position by the controller's slow loop.
        lease_ms: Time after which the controller switches off by itself when it hears nothing, ms.
    """

    excitation: Excitation | Setpoints
    duration_s: float
    nameplate: Nameplate | MotionPredictor
    slew_limit_a_s: float = 10_000.0
    stream: StreamPlan = field(default_factory=StreamPlan)
    centring: bool = True
    lease_ms: int = 250
