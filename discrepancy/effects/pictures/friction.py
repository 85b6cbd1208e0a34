"""Pictures of friction and load: torques over the speed, and what friction remembers or takes from the load."""

import numpy as np
from numpy.typing import NDArray

from discrepancy.effects.alone import alone, opposing_torque, with_zero
from discrepancy.effects.pictures.joint import (
    CURRENT,
    INERTIA,
    SPEED,
    TORQUE_CONSTANT,
    VISCOUS,
    joint,
    typical,
)
from discrepancy.effects.pictures.spec import Line, Look, Note, Panel, Picture
from discrepancy.effects.spec import Effect
from discrepancy.simulation import slots as s

FloatArray = NDArray[np.float64]

OPPOSING = "opposing torque, N m"
_SPEED = "speed, rad/s"
_SPEEDS = with_zero(SPEED * np.linspace(-1.0, 1.0, 101) ** 3)
"""Close around zero, where friction changes most."""


def _over_speed(effect: Effect, **changed: float) -> FloatArray:
    return opposing_torque(alone(effect, joint(effect, typical(effect, **changed))), speed=_SPEEDS)


def coulomb_friction(effect: Effect) -> Picture:
    """Show the step at zero speed."""
    values = typical(effect)
    level = values["level"]
    panel = Panel(
        x=_SPEED, y=OPPOSING, lines=(Line(x=_SPEEDS, y=_over_speed(effect)),), levels=(-level, level),
        notes=(
            Note(x=-0.5 * SPEED, y=level, text="level"),
            Note(x=0.3, y=0.0, text="at rest: holds against the drive, up to the level"),
        ),
    )  # fmt: skip
    return Picture(
        title="Dry friction of one level, against the motion at any speed", panels=(panel,), values=values
    )


def asymmetric_coulomb_friction(effect: Effect) -> Picture:
    """Show the step that is not centred."""
    values = typical(effect, level_positive=0.6, level_negative=0.3)
    up, down = values["level_positive"], -values["level_negative"]
    panel = Panel(
        x=_SPEED, y=OPPOSING, lines=(Line(x=_SPEEDS, y=_over_speed(effect, **values)),), levels=(down, up),
        notes=(
            Note(x=-0.7 * SPEED, y=up, text="level_positive"),
            Note(x=0.2 * SPEED, y=down, text="level_negative"),
        ),
    )  # fmt: skip
    return Picture(title="Dry friction with one level for each direction", panels=(panel,), values=values)


def asymmetric_viscous_friction(effect: Effect) -> Picture:
    """Show the effect, and what it makes of the joint's own viscous friction."""
    values = typical(effect, half_difference=0.4 * VISCOUS)
    lines = (
        Line(x=_SPEEDS, y=opposing_torque(joint(), speed=_SPEEDS), name="B w without it", look=Look.WITHOUT),
        Line(
            x=_SPEEDS, y=opposing_torque(joint(effect, values), speed=_SPEEDS), name="B w with it",
            look=Look.SECOND,
        ),
        Line(x=_SPEEDS, y=_over_speed(effect, **values), name="the effect alone"),
    )  # fmt: skip
    panel = Panel(x=_SPEED, y=OPPOSING, lines=lines)
    return Picture(
        title="Viscous friction with one coefficient for each direction", panels=(panel,), values=values
    )


def stribeck_friction(effect: Effect) -> Picture:
    """Show both exponents of the starting grid, at the lower speeds."""
    values = typical(effect, exponent=2.0)
    speeds = 0.4 * _SPEEDS
    level, peak = values["coulomb_level"], values["coulomb_level"] + values["static_excess"]
    lines = []
    for exponent, look in ((1.0, Look.SECOND), (2.0, Look.FIRST)):
        vector = alone(effect, joint(effect, {**values, "exponent": exponent}))
        torque = opposing_torque(vector, speed=speeds)
        lines.append(Line(x=speeds, y=torque, name=f"exponent {exponent:g}", look=look))
    notes = (
        Note(x=-0.05 * SPEED, y=peak, text="coulomb_level + static_excess", align="right"),
        Note(x=-0.05 * SPEED, y=level, text="coulomb_level", align="right"),
        Note(x=values["stribeck_speed"], y=-0.9 * peak, text=" stribeck_speed"),
    )
    panel = Panel(
        x=_SPEED,
        y=OPPOSING,
        lines=tuple(lines),
        notes=notes,
        levels=(level, peak),
        places=(values["stribeck_speed"],),
    )
    return Picture(
        title="Dry friction that falls from break-away as the speed rises", panels=(panel,), values=values
    )


def quadratic_drag(effect: Effect) -> Picture:
    """Show the parabola of either sign."""
    panel = Panel(x=_SPEED, y=OPPOSING, lines=(Line(x=_SPEEDS, y=_over_speed(effect)),))
    return Picture(
        title="Drag that grows with the square of the speed", panels=(panel,), values=typical(effect)
    )


def load_torque_offset(effect: Effect) -> Picture:
    """Show a constant."""
    values = typical(effect)
    panel = Panel(
        x=_SPEED, y=OPPOSING, lines=(Line(x=_SPEEDS, y=_over_speed(effect)),), levels=(0.0,),
        notes=(Note(x=-0.9 * SPEED, y=values["torque"], text="torque: the same at rest and in both directions"),),
    )  # fmt: skip
    return Picture(title="A constant load, whatever the joint does", panels=(panel,), values=values)


def load_dependent_friction(effect: Effect) -> Picture:
    """Show friction over the motor's torque for both directions: driving and braking branches."""
    values = typical(effect)
    vector = joint(effect, values)
    vector[s.VISCOUS] = 0.0
    most = TORQUE_CONSTANT * CURRENT
    rates = np.linspace(-1.0, 1.0, 301) * 2.0 * most / INERTIA
    lines = []
    for speed, look, name in ((1.0, Look.FIRST, "w > 0"), (-1.0, Look.SECOND, "w < 0")):
        motor = opposing_torque(vector, speed=np.full(rates.size, speed), acceleration=rates)
        shown = np.abs(motor) <= most
        lines.append(Line(x=motor[shown], y=(motor - INERTIA * rates)[shown], name=name, look=look))
    side, high = 0.65 * most, 0.7 * most * values["coefficient"]
    notes = (
        Note(x=-side, y=high, text="braking"), Note(x=side, y=high, text="driving", align="right"),
        Note(x=-side, y=-1.3 * high, text="driving"), Note(x=side, y=-1.3 * high, text="braking", align="right"),
    )  # fmt: skip
    panel = Panel(
        x="torque of the motor, N m",
        y="opposing friction, N m",
        lines=tuple(lines),
        notes=notes,
        levels=(0.0,),
    )
    return Picture(
        title="Dry friction in proportion to the torque that is carried", panels=(panel,), values=values
    )


def presliding_hysteresis(effect: Effect) -> Picture:
    """Show the loop over the angle for the three forms of the law, for one also where it begins and a small loop."""
    values = typical(effect, exponent=1.0)
    bend = values["level"] / values["stiffness"]
    large, small = [4.0, -4.0, 4.0], [1.5, 4.0]
    lines = []
    for exponent, look, turns in (
        (3.0, Look.THIRD, large), (2.0, Look.SECOND, large), (1.0, Look.FIRST, large + small),
    ):  # fmt: skip
        time, angle = _zigzag(bend * np.array([0.0, *turns]), bend / 25.0)
        middle = 0.5 * (angle[1:] + angle[:-1])
        first = 0 if look is Look.FIRST else int(np.argmax(angle))
        vector = alone(effect, joint(effect, {**values, "exponent": exponent}))
        # The kernel moves the springs by speed times step: the speeds that lead from one angle to the next.
        torque = opposing_torque(vector, speed=np.diff(angle), time=time[1:])
        lines.append(Line(x=middle[first:], y=torque[first:], name=f"exponent {exponent:g}", look=look))
    level = values["level"]
    panel = Panel(
        x="angle, rad", y=OPPOSING, lines=tuple(lines), levels=(-level, level),
        notes=(Note(x=-4.0 * bend, y=level, text="level"),),
    )  # fmt: skip
    return Picture(
        title="Friction that follows the travel after a reversal (slope at first: stiffness)",
        panels=(panel,), values=values,
    )  # fmt: skip


def _zigzag(corners: FloatArray, step: float) -> tuple[FloatArray, FloatArray]:
    """Return times a second apart, s, and angles, rad, that run from corner to corner in equal steps."""
    parts = [corners[:1]]
    for a, b in zip(corners, corners[1:], strict=False):
        parts.append(np.linspace(a, b, round(abs(b - a) / step) + 1)[1:])
    angle = np.concatenate(parts)
    return np.arange(angle.size, dtype=np.float64), angle


def viscous_friction_drift(effect: Effect) -> Picture:
    """Show the torque at constant speeds over the time, with and without the effect."""
    values = typical(effect, change=-0.4)
    time = np.linspace(0.0, 60.0, 121)
    lines = []
    for speed, look in ((0.5 * SPEED, Look.FIRST), (-0.5 * SPEED, Look.SECOND)):
        plain = opposing_torque(joint(), speed=speed, time=time)
        lines.append(Line(x=time, y=plain, look=Look.WITHOUT, name="without it" if speed > 0.0 else ""))
        torque = opposing_torque(joint(effect, values), speed=speed, time=time)
        lines.append(Line(x=time, y=torque, look=look, name=f"at {speed:+.0f} rad/s"))
    panel = Panel(
        x="time, s", y="viscous friction, N m", lines=tuple(lines), places=(values["time_constant"],),
        notes=(Note(x=values["time_constant"], y=0.0, text=" time_constant"),),
    )  # fmt: skip
    return Picture(
        title="Viscous friction that changes as the grease warms up", panels=(panel,), values=values
    )
