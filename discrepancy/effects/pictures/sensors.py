"""Pictures of sensors: what they read over what is there."""

import numpy as np

from discrepancy.effects.pictures.joint import (
    CURRENT,
    INERTIA,
    SPEED,
    TORQUE_CONSTANT,
    TURN,
    joint,
    simulate,
    typical,
)
from discrepancy.effects.pictures.spec import FloatArray, Line, Look, Note, Panel, Picture
from discrepancy.effects.spec import Effect
from discrepancy.simulation import slots as s

_ALL = np.linspace(0.0, 1.0, 161)
_CURRENT, _READING = "current of the motor, A", "reading, A"


def _free(effect: Effect | None = None, values: dict[str, float] | None = None) -> FloatArray:
    """Return the joint without friction, which keeps its speed at no current."""
    vector = joint(effect, values)
    vector[s.VISCOUS] = 0.0
    return vector


def _read_current(effect: Effect, values: dict[str, float]) -> Line:
    currents = CURRENT * (2.0 * _ALL - 1.0)
    return Line(x=currents, y=simulate(joint(effect, values), _ALL, currents)[2], name="reading")


def _true_current() -> Line:
    currents = CURRENT * np.linspace(-1.0, 1.0, 3)
    return Line(x=currents, y=currents, name="true", look=Look.WITHOUT)


def _read_wrongly(effect: Effect, values: dict[str, float], words: str, title: str) -> Picture:
    """Show the reading over the current, beside the true one."""
    panel = Panel(
        x=_CURRENT, y=_READING, lines=(_true_current(), _read_current(effect, values)), levels=(0.0,), places=(0.0,),
        notes=(Note(x=0.03 * CURRENT, y=-0.4 * CURRENT, text=words),),
    )  # fmt: skip
    return Picture(title=title, panels=(panel,), values=values)


def current_sensor_offset(effect: Effect) -> Picture:
    """Show a straight line beside the origin."""
    values = typical(effect, offset=0.1 * CURRENT)
    title = "The current sensor reads a constant too much"
    return _read_wrongly(effect, values, "reads offset at no current", title)


def current_sensor_gain(effect: Effect) -> Picture:
    """Show a straight line of another slope."""
    values = typical(effect, gain=1.2)
    return _read_wrongly(effect, values, "slope: gain", "The current sensor reads in the wrong scale")


def potentiometer_nonlinearity(effect: Effect) -> Picture:
    """Show the error of the angle, and what it makes of a constant speed."""
    values = typical(effect, sine=0.02, cosine=0.0, wave_number=1.0)
    speed = 0.5 * SPEED
    time = 2.0 * TURN / speed * _ALL
    rest = np.zeros(time.size)
    true_speed, angle, _ = simulate(_free(), time, rest, speed=speed, angle=-TURN)
    read_speed, read_angle, _ = simulate(_free(effect, values), time, rest, speed=speed, angle=-TURN)
    first = Panel(
        x="angle, rad",
        y="error of the angle, rad",
        lines=(Line(x=angle, y=read_angle - angle),),
        levels=(0.0,),
    )
    lines = (
        Line(x=angle, y=true_speed, name="true", look=Look.WITHOUT),
        Line(x=angle, y=read_speed, name="reading"),
    )
    second = Panel(x="angle, rad", y="speed, rad/s", lines=lines)
    return Picture(
        title="A potentiometer that is not straight: wrong angle, wrong speed",
        panels=(first, second), values=values,
    )  # fmt: skip


def speed_filter_lag(effect: Effect) -> Picture:
    """Show a speed that ramps up and down, and its reading behind it."""
    values = typical(effect, time_constant=0.02, angle_too=0.0)
    time = np.linspace(0.0, 0.4, 401)
    rate = 0.5 * SPEED / 0.05
    ramps = np.where((time >= 0.05) & (time < 0.1), 1.0, 0.0) - np.where(
        (time >= 0.2) & (time < 0.3), 1.0, 0.0
    )
    command = INERTIA / TORQUE_CONSTANT * rate * ramps
    true_speed, read = (simulate(v, time, command)[0] for v in (_free(), _free(effect, values)))
    lines = (
        Line(x=time, y=true_speed, name="true", look=Look.WITHOUT),
        Line(x=time, y=read, name="reading"),
    )
    panel = Panel(
        x="time, s", y="speed, rad/s", lines=lines,
        notes=(Note(x=0.02, y=-0.3 * SPEED, text="on a ramp: late by time_constant"),),
    )  # fmt: skip
    return Picture(title="The measured speed passes a first-order filter", panels=(panel,), values=values)


def rectified_speed_sensor(effect: Effect) -> Picture:
    """Show both shares of the starting grid over both signs of the speed."""
    values = typical(effect, share=1.0)
    push = np.full(_ALL.size, 2.0 * SPEED * INERTIA / TORQUE_CONSTANT)
    true_speed = simulate(_free(), _ALL, push, speed=-SPEED)[0]
    lines = [Line(x=true_speed, y=true_speed, name="true", look=Look.WITHOUT)]
    for share, look in ((0.1, Look.SECOND), (1.0, Look.FIRST)):
        read = simulate(_free(effect, {"share": share}), _ALL, push, speed=-SPEED)[0]
        lines.append(Line(x=true_speed, y=read, name=f"share {share:g}", look=look))
    panel = Panel(x="speed, rad/s", y="reading, rad/s", lines=tuple(lines), levels=(0.0,), places=(0.0,))
    return Picture(title="The speed sensor loses the sign", panels=(panel,), values=values)
