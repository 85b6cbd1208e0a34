"""The table of hidden effects: their parameters, units, ranges and meaning.

Adding an effect is one entry here, its equation in a kernel of `mock_dsp.physics`, and a line in
`docs/emulator.md`. This file knows no equations. All torques, angles and speeds are at the motor shaft.
"""

from dataclasses import dataclass
from enum import StrEnum
from types import MappingProxyType


class Port(StrEnum):
    """Where an effect acts."""

    TORQUE = "torque"
    CURRENT = "current"
    SENSOR = "sensor"


@dataclass(frozen=True, slots=True)
class EffectParameter:
    """One number of an effect.

    Attributes:
        name: Key in the scenario file; ends in the unit.
        unit: SI unit, `1` for a ratio.
        minimum: Least value accepted.
        maximum: Greatest value accepted.
        default: Value when the scenario file does not give it.
        draw: Range from which a sealed scenario draws.
    """

    name: str
    unit: str
    minimum: float
    maximum: float
    default: float
    draw: tuple[float, float]


@dataclass(frozen=True, slots=True)
class EffectSpec:
    """What one effect is: its port, its numbers and its meaning in a sentence.

    Attributes:
        port: Where it acts.
        text: The effect in words.
        parameters: Its numbers; none for an effect that is only on or off.
        catalogued: Whether the effect is one of those an analysis may look for by name.
    """

    port: Port
    text: str
    parameters: tuple[EffectParameter, ...] = ()
    catalogued: bool = True


_P = EffectParameter
_ANGLE = 3.141592653589793

EFFECTS: MappingProxyType[str, EffectSpec] = MappingProxyType(
    {
        "coulomb_friction": EffectSpec(
            Port.TORQUE,
            "Dry friction of constant magnitude; the joint sticks below it.",
            (_P("torque_nm", "N m", 0.0, 2.0, 0.15, (0.06, 0.25)),),
        ),
        "asymmetric_coulomb_friction": EffectSpec(
            Port.TORQUE,
            "Dry friction that differs between the two directions.",
            (
                _P("positive_nm", "N m", 0.0, 2.0, 0.20, (0.15, 0.28)),
                _P("negative_nm", "N m", 0.0, 2.0, 0.08, (0.03, 0.10)),
            ),
        ),
        "asymmetric_viscous_friction": EffectSpec(
            Port.TORQUE,
            "Extra viscous friction that differs between the two directions.",
            (
                _P("positive_nm_s_rad", "N m s/rad", -0.5, 5.0, 0.20, (0.10, 0.35)),
                _P("negative_nm_s_rad", "N m s/rad", -0.5, 5.0, 0.0, (-0.15, 0.0)),
            ),
        ),
        "stribeck_friction": EffectSpec(
            Port.TORQUE,
            "Dry friction falling from the static to the Coulomb level as exp(-(w/w_s)^2).",
            (
                _P("static_nm", "N m", 0.0, 2.0, 0.25, (0.20, 0.32)),
                _P("coulomb_nm", "N m", 0.0, 2.0, 0.12, (0.06, 0.15)),
                _P("speed_rad_s", "rad/s", 0.01, 10.0, 0.15, (0.08, 0.30)),
            ),
        ),
        "quadratic_drag": EffectSpec(
            Port.TORQUE,
            "Drag that grows with the square of the speed.",
            (_P("coefficient_nm_s2_rad2", "N m s^2/rad^2", 0.0, 10.0, 0.40, (0.15, 0.60)),),
        ),
        "load_torque_offset": EffectSpec(
            Port.TORQUE,
            "Constant load torque, against positive motion.",
            (_P("torque_nm", "N m", -1.0, 1.0, 0.06, (0.03, 0.10)),),
        ),
        "load_dependent_friction": EffectSpec(
            Port.TORQUE,
            "Dry friction in proportion to the magnitude of the transmitted torque.",
            (_P("coefficient", "1", 0.0, 0.9, 0.15, (0.08, 0.25)),),
        ),
        "gravity_unbalance": EffectSpec(
            Port.TORQUE,
            "Unbalanced mass on a tilted joint axis: amplitude * sin(joint angle + phase).",
            (
                _P("amplitude_nm", "N m", 0.0, 2.0, 0.12, (0.06, 0.20)),
                _P("phase_rad", "rad", -_ANGLE, _ANGLE, 0.5, (-_ANGLE, _ANGLE)),
            ),
        ),
        "torque_ripple": EffectSpec(
            Port.TORQUE,
            "Torque that varies with the motor angle: amplitude * sin(harmonic * angle + phase).",
            (
                _P("amplitude_nm", "N m", 0.0, 2.0, 0.10, (0.05, 0.15)),
                _P("harmonic", "1", 1.0, 48.0, 6.0, (1.0, 6.0)),
                _P("phase_rad", "rad", -_ANGLE, _ANGLE, 0.0, (-_ANGLE, _ANGLE)),
            ),
        ),
        "backlash": EffectSpec(
            Port.TORQUE,
            "Play between motor and joint; spring and damper at contact, nothing in the gap.",
            (
                _P("gap_rad", "rad", 0.0, 2.0, 0.15, (0.08, 0.30)),
                _P("stiffness_nm_rad", "N m/rad", 10.0, 1000.0, 200.0, (100.0, 300.0)),
                _P("damping_nm_s_rad", "N m s/rad", 0.01, 10.0, 1.0, (0.5, 1.5)),
            ),
        ),
        "belt_compliance": EffectSpec(
            Port.TORQUE,
            "Elastic belt between motor and joint.",
            (
                _P("stiffness_nm_rad", "N m/rad", 1.0, 1000.0, 20.0, (8.0, 30.0)),
                _P("damping_nm_s_rad", "N m s/rad", 0.0, 10.0, 0.20, (0.1, 0.4)),
            ),
        ),
        "presliding_hysteresis": EffectSpec(
            Port.TORQUE,
            "Elastic presliding friction with memory: four Maxwell slip elements that yield one by one.",
            (
                _P("torque_nm", "N m", 0.0, 2.0, 0.15, (0.08, 0.25)),
                _P("displacement_rad", "rad", 0.005, 5.0, 0.30, (0.1, 0.8)),
            ),
        ),
        "viscous_friction_drift": EffectSpec(
            Port.TORQUE,
            "Viscous friction that changes by a fraction as the joint warms up.",
            (
                _P("fraction", "1", -0.9, 5.0, -0.35, (-0.5, -0.2)),
                _P("time_constant_s", "s", 1.0, 1e4, 300.0, (100.0, 600.0)),
            ),
        ),
        "position_dependent_inertia": EffectSpec(
            Port.TORQUE,
            "Inertia that varies with the joint angle: J (1 + fraction * cos(joint angle + phase)).",
            (
                _P("fraction", "1", 0.0, 0.9, 0.40, (0.25, 0.6)),
                _P("phase_rad", "rad", -_ANGLE, _ANGLE, 0.0, (-_ANGLE, _ANGLE)),
            ),
        ),
        "end_stop": EffectSpec(
            Port.TORQUE,
            "Elastic stop that the joint meets inside its travel.",
            (
                _P("lower_rad", "rad", -31.0, 0.0, -1.5, (-2.0, -1.0)),
                _P("upper_rad", "rad", 0.0, 31.0, 1.5, (1.0, 2.0)),
                _P("stiffness_nm_rad", "N m/rad", 0.1, 500.0, 2.0, (0.5, 4.0)),
                _P("damping_nm_s_rad", "N m s/rad", 0.0, 50.0, 0.5, (0.2, 1.0)),
            ),
        ),
        "torque_saturation": EffectSpec(
            Port.TORQUE,
            "The transmitted torque is limited, as by a slipping clutch.",
            (_P("limit_nm", "N m", 0.05, 5.0, 0.40, (0.25, 0.6)),),
        ),
        "torque_constant_drift": EffectSpec(
            Port.TORQUE,
            "Torque per current that changes by a fraction as the motor warms up.",
            (
                _P("fraction", "1", -0.9, 1.0, -0.25, (-0.4, -0.15)),
                _P("time_constant_s", "s", 1.0, 1e4, 300.0, (100.0, 600.0)),
            ),
        ),
        "transport_delay": EffectSpec(
            Port.CURRENT,
            "Dead time between the commanded reference and the current loop, in whole 0.4 ms ticks.",
            (_P("delay_s", "s", 0.0, 0.2, 0.06, (0.02, 0.15)),),
        ),
        "current_loop_lag": EffectSpec(
            Port.CURRENT,
            "Current loop so slow that the current follows its reference as a first-order lag.",
            (_P("time_constant_s", "s", 0.001, 2.0, 0.06, (0.02, 0.15)),),
        ),
        "current_saturation": EffectSpec(
            Port.CURRENT,
            "Torque-producing current limited below the commanded reference.",
            (_P("limit_a", "A", 0.05, 2.0, 0.40, (0.25, 0.6)),),
        ),
        "inverter_dead_time": EffectSpec(
            Port.CURRENT,
            "Dead time of the bridge beyond the 2 us that the controller compensates.",
            (_P("extra_s", "s", 0.0, 2e-5, 1.2e-5, (8e-6, 1.8e-5)),),
        ),
        "current_sensor_offset": EffectSpec(
            Port.SENSOR,
            "Offset of the recorded i_q (monitoring channel), or of a Hall sensor inside the loop.",
            (
                _P("monitor_offset_a", "A", -1.0, 1.0, 0.06, (0.03, 0.10)),
                _P("hall_offset_phase_a_a", "A", -1.0, 1.0, 0.0, (0.0, 0.0)),
                _P("hall_offset_phase_b_a", "A", -1.0, 1.0, 0.0, (0.0, 0.0)),
            ),
        ),
        "current_sensor_gain": EffectSpec(
            Port.SENSOR,
            "Gain of the recorded currents (monitoring channel), or of the Hall sensors inside the loop.",
            (
                _P("monitor_gain", "1", 0.5, 2.0, 1.15, (1.08, 1.25)),
                _P("hall_gain", "1", 0.5, 2.0, 1.0, (1.0, 1.0)),
            ),
        ),
        "potentiometer_nonlinearity": EffectSpec(
            Port.SENSOR,
            "Deviation of the potentiometer: amplitude * sin(2 pi cycles * angle / ten turns + phase).",
            (
                _P("amplitude_rad", "rad", 0.0, 2.0, 0.40, (0.2, 0.5)),
                _P("cycles", "1", 0.5, 40.0, 6.0, (4.0, 10.0)),
                _P("phase_rad", "rad", -_ANGLE, _ANGLE, 0.0, (-_ANGLE, _ANGLE)),
            ),
        ),
        "speed_filter_lag": EffectSpec(
            Port.SENSOR,
            "Slow analogue low-pass at the wiper: position, and every speed made from it, lag.",
            (_P("time_constant_s", "s", 0.001, 2.0, 0.06, (0.02, 0.15)),),
        ),
        "rectified_speed_sensor": EffectSpec(
            Port.SENSOR,
            "The controller's own speed shows the magnitude only, as a tacho with a rectifier does.",
        ),
        "eddy_current_brake": EffectSpec(
            Port.TORQUE,
            "Drag 2 peak (w/wc) / (1 + (w/wc)^2), which falls again above wc.",
            (
                _P("peak_nm", "N m", 0.0, 2.0, 0.25, (0.15, 0.35)),
                _P("critical_speed_rad_s", "rad/s", 0.01, 50.0, 0.20, (0.1, 0.35)),
            ),
            catalogued=False,
        ),
        "rotor_heating": EffectSpec(
            Port.CURRENT,
            "Rotor resistance rises with heat (copper loss, one time constant) and detunes the slip; "
            "`fraction` is the rise at rated current with the fan standing nearly still.",
            (
                _P("fraction", "1", 0.0, 3.0, 1.5, (1.0, 2.0)),
                _P("time_constant_s", "s", 1.0, 1e4, 100.0, (60.0, 300.0)),
            ),
            catalogued=False,
        ),
        "sticky_spot": EffectSpec(
            Port.TORQUE,
            "Dry friction in a band of motor angles only (raised cosine of full width).",
            (
                _P("torque_nm", "N m", 0.0, 2.0, 0.30, (0.2, 0.4)),
                _P("centre_rad", "rad", -30.0, 30.0, 0.5, (-0.5, 0.5)),
                _P("width_rad", "rad", 0.1, 20.0, 2.0, (1.5, 3.0)),
            ),
            catalogued=False,
        ),
    }
)
