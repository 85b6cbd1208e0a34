"""What a rig file allows a proposed experiment to do: the same checks that `jointscope run` makes before it starts."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from daq.errors import ExcitationLimitError
from daq.excitation.check import MotionPredictor, Nameplate, check_excitation
from server.config.campaign import RecordStep
from server.config.rig import Rig
from server.services.limits import rig_joint, rig_limits, start_condition

if TYPE_CHECKING:
    from discrepancy.design.limits import RigLimits

LONGEST_S = 80.0
TRAVEL_SHARE = 0.9
"""Part of the travel that a proposal may plan with: joint and rival models are not known to the last degree."""


def design_limits(rig: Rig, longest_s: float = LONGEST_S) -> "RigLimits":
    """Return the limits of a rig file, with the whole check of a plan behind them.

    Args:
        rig: its file's content.
        longest_s: longest record that may be proposed, s.
    """
    from discrepancy.design.limits import RigLimits

    joint = rig_joint(rig)
    return RigLimits(
        amplitude=rig.limits.current_A,
        travel_low=TRAVEL_SHARE * rig.limits.travel_min_rad,
        travel_high=TRAVEL_SHARE * rig.limits.travel_max_rad,
        speed=rig.limits.speed_rad_s,
        longest_s=longest_s,
        admits=lambda excitation, duration_s: admits(rig, joint, excitation, duration_s),
    )


def admits(
    rig: Rig,
    joint: Nameplate | MotionPredictor,
    excitation: Mapping[str, Any],  # Any: values of a campaign's keys
    duration_s: float,
) -> bool:
    """Return whether a record of this excitation would pass the checks of a plan."""
    try:
        step = RecordStep.model_validate(
            {"step": "record", "name": "next", "duration_s": duration_s, "excitation": dict(excitation)}
        )
        start = start_condition(rig.parameters, centring=step.centring)
        check_excitation(step.excitation.to_spec(duration_s), rig_limits(rig), joint, start)
    except (ExcitationLimitError, ValidationError, ValueError):
        return False
    return True
