"""Before the drive is switched on: where the joint stands, which limits hold, what the excitation will do."""

import time
from dataclasses import asdict, replace
from typing import Any

from daq.calibration.channels import calibrate_channels, counts_to_si
from daq.driver.options import RecordPlan, StreamPlan
from daq.driver.rig import Rig
from daq.errors import LinkTimeoutError
from daq.excitation.check import ExcitationReport, RigLimits, StartCondition, check_excitation
from daq.excitation.spec import Excitation, Setpoints
from daq.protocol.stream import SampleBlock

_POSITION = "position"
_PATIENCE_S = 2.0


def read_limits(rig: Rig, slew_limit_a_s: float) -> RigLimits:
    """Return the limits in force: the controller's own, and the slew limit that only the host knows."""
    read = rig.read_parameter
    return RigLimits(
        current_limit_a=read("current_limit_A"),
        rated_current_a=read("rated_current_A"),
        i2t_time_s=read("i2t_time_s"),
        flux_current_a=read("flux_current_A"),
        slew_limit_a_s=slew_limit_a_s,
        speed_limit_rad_s=read("speed_limit_rad_s"),
        travel_min_rad=read("travel_min_rad"),
        travel_max_rad=read("travel_max_rad"),
    )


def measure_position(rig: Rig, stream: StreamPlan) -> float:
    """Return where the joint stands, rad at the motor shaft, from the first samples of a short stream.

    Raises:
        LinkTimeoutError: No samples came.
    """
    rig.start_stream(stream)
    try:
        block = _first_samples(rig)
    finally:
        rig.stop_stream()
        rig.next_blocks(0.0)  # the rest of this stream is no part of a recording
    channel = rig.dictionary.channel(_POSITION)
    (calibration,) = calibrate_channels([channel], None)
    return float(counts_to_si(block.counts[_POSITION], calibration).mean())


def check_plan(rig: Rig, plan: RecordPlan) -> ExcitationReport:
    """Predict what the plan does to this rig, from where its joint stands now, and refuse what exceeds a limit.

    Raises:
        ExcitationLimitError: With quantity, value and limit.
    """
    limits = read_limits(rig, plan.slew_limit_a_s)
    start = StartCondition(
        position_rad=measure_position(rig, plan.stream),
        centring_gain_a_rad=rig.read_parameter("centring_gain_A_rad") if plan.centring else 0.0,
        centring_bandwidth_hz=rig.read_parameter("centring_bandwidth_Hz"),
        tick_hz=rig.hello.tick_hz,
    )
    return check_excitation(bounded(plan), limits, plan.nameplate, start)


def bounded(plan: RecordPlan) -> Excitation | Setpoints:
    """Return the plan's excitation with an end: an endless one plays as long as the recording lasts."""
    excitation = plan.excitation
    if isinstance(excitation, Excitation) and excitation.duration_s == 0.0:
        return replace(excitation, duration_s=plan.duration_s)
    return excitation


def describe_excitation(excitation: Excitation | Setpoints) -> dict[str, Any]:  # JSON values
    """Return an excitation as JSON values, its seed included, for a journal."""
    return {"kind": type(excitation).__name__.lower(), **asdict(excitation)}


def _first_samples(rig: Rig) -> SampleBlock:
    deadline_s = time.monotonic() + _PATIENCE_S
    while time.monotonic() < deadline_s:
        for block in rig.next_blocks(0.1):
            if block.ticks.size:
                return block
    raise LinkTimeoutError(
        f"the stream was started, but no sample came in {_PATIENCE_S:g} s; restart the controller"
    )
