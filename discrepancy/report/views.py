"""Over which variable each effect is drawn, and in which quantity its law shows as a curve."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum


class Signal(Enum):
    """A variable of the joint that a law is drawn over. Values: (name in words, rotary unit, linear unit)."""

    SPEED = ("speed", "rad/s", "m/s")
    POSITION = ("position", "rad", "m")
    INPUT = ("input", "A", "A")
    ACCELERATION = ("acceleration", "rad/s²", "m/s²")
    TIME = ("time since the start", "s", "s")
    SLOPE = ("rate of change of the input", "A/s", "A/s")
    ONE = ("one", "", "")
    DIRECTION = ("direction", "", "")


@dataclass(frozen=True, slots=True, kw_only=True)
class View:
    """How an effect is drawn.

    Attributes:
        x: variable of the x axis.
        per: the missing torque is divided by this variable, cell by cell: a coefficient is drawn, not a torque.
        what: y axis in words.
        unit: unit of y (rotary, linear).
        exact: True where the law depends on x alone, so that it can be drawn without simulating.
        output: True where the error of the output is drawn, not a torque.
    """

    x: Signal
    per: Signal = Signal.ONE
    what: str = "load missing in the model"
    unit: tuple[str, str] = ("N m", "N")
    exact: bool = False
    output: bool = False


_OVER_SPEED = View(x=Signal.SPEED, exact=True)
_OVER_POSITION = View(x=Signal.POSITION, exact=True)
_OVER_INPUT = View(x=Signal.INPUT)
_OVER_SLOPE = View(x=Signal.SLOPE)

VIEWS: Mapping[str, View] = {
    "coulomb_friction": _OVER_SPEED,
    "asymmetric_coulomb_friction": _OVER_SPEED,
    "asymmetric_viscous_friction": _OVER_SPEED,
    "stribeck_friction": _OVER_SPEED,
    "quadratic_drag": _OVER_SPEED,
    "load_torque_offset": _OVER_SPEED,
    "load_dependent_friction": View(
        x=Signal.INPUT, per=Signal.DIRECTION, what="friction level missing in the model"
    ),
    "gravity_unbalance": _OVER_POSITION,
    "torque_ripple": View(x=Signal.POSITION),
    "backlash": View(x=Signal.SPEED),
    "belt_compliance": View(x=Signal.ACCELERATION),
    "presliding_hysteresis": View(x=Signal.SPEED),
    "viscous_friction_drift": View(
        x=Signal.TIME, per=Signal.SPEED, what="change of the viscous friction", unit=("N m s/rad", "N s/m")
    ),
    "position_dependent_inertia": View(
        x=Signal.POSITION, per=Signal.ACCELERATION, what="change of the inertia", unit=("kg m²", "kg")
    ),
    "end_stop": _OVER_POSITION,
    "torque_saturation": _OVER_INPUT,
    "torque_constant_drift": View(
        x=Signal.TIME, per=Signal.INPUT, what="lost torque per input", unit=("N m/A", "N/A")
    ),
    "transport_delay": _OVER_SLOPE,
    "current_loop_lag": _OVER_SLOPE,
    "current_saturation": _OVER_INPUT,
    "inverter_dead_time": _OVER_INPUT,
    "current_sensor_offset": _OVER_INPUT,
    "current_sensor_gain": _OVER_INPUT,
    "potentiometer_nonlinearity": View(x=Signal.POSITION, what="error of the output", output=True),
    "speed_filter_lag": View(x=Signal.ACCELERATION, what="error of the output", output=True),
    "rectified_speed_sensor": View(x=Signal.SPEED, what="error of the output", output=True),
}

SIGNAL_OF_DRIVER: Mapping[str, Signal] = {
    "speed": Signal.SPEED,
    "position": Signal.POSITION,
    "current": Signal.INPUT,
    "force": Signal.INPUT,
    "acceleration": Signal.ACCELERATION,
    "time": Signal.TIME,
    "frequency": Signal.SLOPE,
}


def signal_of(driver: str) -> Signal:
    """Return the signal that a driving column (`speed_rad_s`) stands for; the input for foreign names."""
    return next((s for name, s in SIGNAL_OF_DRIVER.items() if driver.startswith(name)), Signal.INPUT)
