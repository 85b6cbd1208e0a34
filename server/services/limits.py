"""From a rig file to what `daq.excitation.check` judges with."""

from collections.abc import Mapping

from daq.excitation.check import MotionPredictor, Nameplate, RigLimits, StartCondition
from server.config.rig import Rig

TICK_HZ = 2500
# What controllers start with (docs/protocol.md); a rig file's `parameters` or a `set` step replace them.
CENTRING_GAIN = ("centring_gain_A_rad", 0.01)
CENTRING_BANDWIDTH = ("centring_bandwidth_Hz", 0.005)


def rig_limits(rig: Rig) -> RigLimits:
    """Return the limits that the host holds an excitation against."""
    limits = rig.limits
    return RigLimits(
        current_limit_a=limits.current_A,
        rated_current_a=limits.rated_current_A,
        i2t_time_s=limits.i2t_time_s,
        flux_current_a=rig.nameplate.flux_current_A,
        slew_limit_a_s=limits.slew_A_s,
        speed_limit_rad_s=limits.speed_rad_s,
        travel_min_rad=limits.travel_min_rad,
        travel_max_rad=limits.travel_max_rad,
    )


def rig_joint(rig: Rig) -> Nameplate | MotionPredictor:
    """Return what predicts travel and speed: the joint model of the rig file, else its nameplate.

    Raises:
        InputError: no such model file, or not a model.
    """
    if rig.model is None:
        return rig_nameplate(rig)
    from server.services.model_prediction import read_predictor

    return read_predictor(rig.model)


def rig_nameplate(rig: Rig) -> Nameplate:
    """Return the linear model that predicts travel and speed."""
    plate = rig.nameplate
    return Nameplate(
        inertia_kg_m2=plate.inertia_kg_m2,
        viscous_friction_nm_s_rad=plate.viscous_friction_N_m_s_rad,
        torque_constant_nm_a=plate.torque_constant_N_m_A,
    )


def start_condition(
    parameters: Mapping[str, float], *, centring: bool, position_rad: float = 0.0
) -> StartCondition:
    """Return how a run begins.

    Args:
        parameters: controller parameters that are known to differ from what controllers start with, SI.
        centring: whether the centring loop is on.
        position_rad: motor shaft, from the centre of travel.
    """
    gain = parameters.get(*CENTRING_GAIN)
    return StartCondition(
        position_rad=position_rad,
        centring_gain_a_rad=gain if centring else 0.0,
        centring_bandwidth_hz=parameters.get(*CENTRING_BANDWIDTH),
        tick_hz=TICK_HZ,
    )
