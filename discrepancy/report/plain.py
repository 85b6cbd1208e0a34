"""Every effect in the words of somebody who knows motors: what it is called, and what it does to the joint."""

from collections.abc import Mapping, Sequence

from discrepancy.effects.table import EFFECTS

PLAIN: Mapping[str, tuple[str, str]] = {
    "coulomb_friction": (
        "dry (Coulomb) friction",
        "a constant torque against the motion, which also holds the joint at rest",
    ),
    "asymmetric_coulomb_friction": (
        "dry friction that depends on the direction",
        "dry friction with one level forwards and another backwards",
    ),
    "asymmetric_viscous_friction": (
        "viscous friction that depends on the direction",
        "drag proportional to the speed, stronger one way than the other",
    ),
    "stribeck_friction": (
        "dry friction with break-away (Stribeck)",
        "dry friction that is larger at standstill and falls as the joint gets going",
    ),
    "quadratic_drag": ("quadratic drag", "a drag that grows with the square of the speed, like a fan's"),
    "load_torque_offset": ("constant load torque", "a torque that always pulls the same way"),
    "load_dependent_friction": (
        "load-dependent friction",
        "dry friction that grows with the torque transmitted, as in gears",
    ),
    "gravity_unbalance": (
        "gravity on an unbalanced arm",
        "the arm's own weight, which pulls differently at each angle",
    ),
    "torque_ripple": ("torque ripple", "a torque that repeats several times per motor turn (cogging, slots)"),
    "backlash": ("backlash", "free play between motor and load: for a moment the motor turns alone"),
    "belt_compliance": ("an elastic belt", "motor and load joined by a spring instead of rigidly"),
    "presliding_hysteresis": (
        "presliding friction",
        "friction that first bends like a spring and only then slides",
    ),
    "viscous_friction_drift": (
        "viscous friction that drifts",
        "viscous friction that changes as the joint warms up",
    ),
    "position_dependent_inertia": (
        "inertia that depends on the angle",
        "a mass that is harder to accelerate in some positions",
    ),
    "end_stop": ("an end stop", "an elastic stop inside the travel"),
    "torque_saturation": ("torque saturation", "torque that stops growing with the current"),
    "torque_constant_drift": ("a torque constant that drifts", "less (or more) torque per ampere with time"),
    "transport_delay": ("a delay", "the drive acts a fixed time after the command"),
    "current_loop_lag": ("a slow current loop", "the current follows its reference only gradually"),
    "current_saturation": ("a current limit", "the current stops at a limit below what is asked"),
    "inverter_dead_time": ("inverter dead time", "a little current is lost around each zero crossing"),
    "current_sensor_offset": (
        "an offset of the current sensor",
        "the sensor shows current where there is none",
    ),
    "current_sensor_gain": ("a wrong gain of the current sensor", "the sensor's scale is off"),
    "potentiometer_nonlinearity": (
        "a nonlinear potentiometer",
        "the angle reading bends away from the true angle along the travel",
    ),
    "speed_filter_lag": (
        "a lag of the speed signal",
        "the speed reading follows the true speed only gradually",
    ),
    "rectified_speed_sensor": (
        "a speed sensor without sign",
        "the sensor shows the magnitude of the speed only",
    ),
}

_QUANTITIES: Mapping[str, str] = {
    "speed": "speed",
    "position": "position",
    "current": "current",
    "torque": "torque",
    "force": "force",
    "acceleration": "acceleration",
    "time": "time since the start",
    "frequency": "rate of change of the input",
}


def called(effect: str) -> str:
    """Return what an effect is called, in words; its id with spaces if it has no entry."""
    return PLAIN.get(effect, (effect.replace("_", " "), ""))[0]


def does(effect: str) -> str:
    """Return what an effect does, empty if it has no entry."""
    return PLAIN.get(effect, ("", ""))[1]


def called_together(entry: str | Sequence[str]) -> str:
    """Return one equivalent in words: an effect, or several that act together."""
    return called(entry) if isinstance(entry, str) else " together with ".join(called(e) for e in entry)


def quantity_name(column: str) -> str:
    """Return what a column (`speed_rad_s`) measures, in words; the column's own name if it is foreign."""
    return next((word for start, word in _QUANTITIES.items() if column.startswith(start)), column)


def parameter_meaning(effect: str, name: str) -> str:
    """Return what a parameter of an effect means, from the catalogue."""
    return next((p.meaning for p in EFFECTS[effect].parameters if p.name == name), parameter_name(name))


def parameter_name(name: str) -> str:
    """Return a parameter's name as words."""
    return name.replace("_", " ")


def join_words(words: Sequence[str], last: str = "and") -> str:
    """Join words as a sentence does: a, b and c."""
    if len(words) < 2:
        return "".join(words)
    return f"{', '.join(words[:-1])} {last} {words[-1]}"
