"""True parameters in the catalogue's own names, as far as its law is the one that the emulator integrates.

What the catalogue writes in another form (a Maxwell model against a bristle, a dead time inside a closed current loop)
has no true value here and is not scored. `derived` holds what a parameter pair fixes together: of a drift with a time
constant far beyond the record only the change until its end can be known.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from benchmarks.blind.excitation import DURATION_S
from mock_dsp.scenario.rig_constants import RigConstants
from mock_dsp.scenario.schema import Effect

Values = Mapping[str, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class JointFigures:
    """The rig at the motor shaft: kg m^2 and N m s/rad, of motor with pulley and of the load behind the belt."""

    motor_inertia: float
    load_inertia: float
    motor_viscous: float
    load_viscous: float
    ratio: float

    @property
    def inertia(self) -> float:
        """All that turns."""
        return self.motor_inertia + self.load_inertia

    @property
    def viscous(self) -> float:
        """All viscous friction."""
        return self.motor_viscous + self.load_viscous


@dataclass(frozen=True, slots=True, kw_only=True)
class Truth:
    """True values: of catalogue parameters, and of what they fix together."""

    parameters: dict[str, float] = field(default_factory=dict)
    derived: dict[str, float] = field(default_factory=dict)


def joint_figures(rig: RigConstants) -> JointFigures:
    """Return what the rig's constants come to at the motor shaft."""
    motor, mechanics = rig.motor, rig.mechanics
    squared = mechanics.belt_ratio**2
    return JointFigures(
        motor_inertia=motor.inertia_kg_m2 + mechanics.pulley_inertia_kg_m2,
        load_inertia=mechanics.joint_inertia_kg_m2 / squared,
        motor_viscous=motor.viscous_friction_nm_s_rad + mechanics.pulley_viscous_friction_nm_s_rad,
        load_viscous=mechanics.joint_viscous_friction_nm_s_rad / squared,
        ratio=mechanics.belt_ratio,
    )


def true_values(effect: Effect, joint: JointFigures) -> Truth:
    """Return an effect's true values in the catalogue's names; empty where the laws differ."""
    values = effect.complete_parameters
    if effect.id in _RENAMED:
        return Truth(parameters={new: values[old] for new, old in _RENAMED[effect.id].items()})
    return _CONVERTED[effect.id](values, joint) if effect.id in _CONVERTED else Truth()


def change_until_end(change: float, time_constant_s: float) -> float:
    """Return how far a first-order drift has come at the end of a record."""
    return -change * math.expm1(-DURATION_S / time_constant_s)


def _shaft(v: Values, joint: JointFigures) -> dict[str, float]:
    share = joint.load_inertia / joint.inertia
    reduced = joint.inertia * share * (1.0 - share)
    stiffness = v["stiffness_nm_rad"]
    return {
        "load_share": share,
        "stiffness": stiffness,
        "damping_ratio": v["damping_nm_s_rad"] / (2.0 * math.sqrt(stiffness * reduced)),
        "friction_share": joint.load_viscous / joint.viscous,
    }


def _wave(amplitude: float, phase: float, wave: float) -> dict[str, float]:
    """Return the parts of amplitude * sin(wave * angle + phase)."""
    return {"sine": amplitude * math.cos(phase), "cosine": amplitude * math.sin(phase), "wave_number": wave}


def _swing(v: Values, joint: JointFigures) -> dict[str, float]:
    part = v["fraction"] * joint.load_inertia / joint.inertia
    # cos(a + phase) = sin(a + phase + pi/2)
    return _wave(part, v["phase_rad"] + 0.5 * math.pi, 1.0 / joint.ratio)


def _bent(v: Values) -> dict[str, float]:
    wave = v["cycles"] / 10.0
    # The model's angle begins where the potentiometer says; the true one begins at 0, where it errs already.
    first = v["amplitude_rad"] * math.sin(v["phase_rad"])
    return _wave(v["amplitude_rad"], v["phase_rad"] - wave * first, wave)


def _warming(v: Values, joint: JointFigures) -> dict[str, float]:
    part = v["fraction"] * joint.load_viscous / joint.viscous
    return {"change_until_end": change_until_end(part, v["time_constant_s"])}


_RENAMED: Mapping[str, Mapping[str, str]] = {
    "coulomb_friction": {"level": "torque_nm"},
    "asymmetric_coulomb_friction": {"level_positive": "positive_nm", "level_negative": "negative_nm"},
    "quadratic_drag": {"coefficient": "coefficient_nm_s2_rad2"},
    "load_torque_offset": {"torque": "torque_nm"},
    "load_dependent_friction": {"coefficient": "coefficient"},
    "presliding_hysteresis": {"level": "torque_nm"},
    "end_stop": {
        "high": "upper_rad", "low": "lower_rad", "stiffness": "stiffness_nm_rad", "damping": "damping_nm_s_rad",
    },
    "torque_saturation": {"limit": "limit_nm"},
    "transport_delay": {"delay": "delay_s"},
    "current_loop_lag": {"time_constant": "time_constant_s"},
    "current_saturation": {"limit": "limit_a"},
    "current_sensor_offset": {"offset": "monitor_offset_a"},
    "current_sensor_gain": {"gain": "monitor_gain"},
    "speed_filter_lag": {"time_constant": "time_constant_s"},
}  # fmt: skip
_CONVERTED: Mapping[str, Callable[[Values, JointFigures], Truth]] = {
    "asymmetric_viscous_friction": lambda v, _: Truth(
        parameters={"half_difference": 0.5 * (v["positive_nm_s_rad"] - v["negative_nm_s_rad"])}
    ),
    "stribeck_friction": lambda v, _: Truth(
        parameters={
            "coulomb_level": v["coulomb_nm"],
            "static_excess": v["static_nm"] - v["coulomb_nm"],
            "stribeck_speed": v["speed_rad_s"],
            "exponent": 2.0,
        }
    ),
    "gravity_unbalance": lambda v, j: Truth(
        parameters=_wave(v["amplitude_nm"], v["phase_rad"], 1.0 / j.ratio)
    ),
    # The emulator's ripple drives, the catalogue's opposes.
    "torque_ripple": lambda v, _: Truth(
        parameters=_wave(-v["amplitude_nm"], v["phase_rad"], v["harmonic"]) | {"with_current": 0.0}
    ),
    "backlash": lambda v, j: Truth(parameters={"gap": v["gap_rad"], **_shaft(v, j)}),
    "belt_compliance": lambda v, j: Truth(parameters=_shaft(v, j)),
    "position_dependent_inertia": lambda v, j: Truth(parameters=_swing(v, j) | {"reaction": 1.0}),
    "viscous_friction_drift": lambda v, j: Truth(derived=_warming(v, j)),
    "torque_constant_drift": lambda v, _: Truth(
        derived={"change_until_end": change_until_end(v["fraction"], v["time_constant_s"])}
    ),
    "potentiometer_nonlinearity": lambda v, _: Truth(parameters=_bent(v)),
    "rectified_speed_sensor": lambda _, __: Truth(parameters={"share": 1.0}),
}
