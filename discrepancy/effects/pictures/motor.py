"""Pictures of the drive and the motor: the current that comes, the torque that it makes."""

import numpy as np

from discrepancy.effects.pictures.joint import CURRENT, TORQUE_CONSTANT, joint, simulate, typical
from discrepancy.effects.pictures.spec import FloatArray, Line, Look, Note, Panel, Picture
from discrepancy.effects.spec import Effect
from discrepancy.simulation.kernels.laws import limit_current, motor_torque

_ASKED, _TIME = "commanded current, A", "time, s"
_CURRENTS = CURRENT * np.linspace(-1.0, 1.0, 161)


def _torques(vector: FloatArray, currents: FloatArray) -> FloatArray:
    return np.array([motor_torque(vector, current, 0.0) for current in currents])


def torque_saturation(effect: Effect) -> Picture:
    """Show a soft and a hard limit of the torque over the current."""
    values = typical(effect, limit=1.2, exponent=2.0)
    lines = [Line(x=_CURRENTS, y=_torques(joint(), _CURRENTS), name="Kt i", look=Look.WITHOUT)]
    for exponent, look in ((12.0, Look.SECOND), (2.0, Look.FIRST)):
        vector = joint(effect, {**values, "exponent": exponent})
        lines.append(
            Line(x=_CURRENTS, y=_torques(vector, _CURRENTS), name=f"exponent {exponent:g}", look=look)
        )
    limit = values["limit"]
    panel = Panel(
        x="current, A", y="torque of the motor, N m", lines=tuple(lines), levels=(-limit, limit),
        notes=(Note(x=-CURRENT, y=limit, text="limit"),),
    )  # fmt: skip
    return Picture(title="Torque that stops growing with the current", panels=(panel,), values=values)


def torque_constant_drift(effect: Effect) -> Picture:
    """Show the torque of constant currents over the time."""
    values = typical(effect, change=-0.3)
    time, vector = np.linspace(0.0, 60.0, 121), joint(effect, values)
    lines = []
    for current, look in ((0.5 * CURRENT, Look.FIRST), (-0.5 * CURRENT, Look.SECOND)):
        plain = np.full(time.size, TORQUE_CONSTANT * current)
        lines.append(Line(x=time, y=plain, look=Look.WITHOUT, name="without it" if current > 0.0 else ""))
        torque = np.array([motor_torque(vector, current, t) for t in time])
        lines.append(Line(x=time, y=torque, look=look, name=f"at {current:+g} A"))
    panel = Panel(
        x=_TIME, y="torque of the motor, N m", lines=tuple(lines), places=(values["time_constant"],),
        notes=(Note(x=values["time_constant"], y=0.0, text=" time_constant"),),
    )  # fmt: skip
    return Picture(title="Torque constant that changes as the motor warms up", panels=(panel,), values=values)


def _limited(vector: FloatArray) -> FloatArray:
    return np.array([limit_current(vector, current) for current in _CURRENTS])


def current_saturation(effect: Effect) -> Picture:
    """Show the current that comes over the one that was asked for."""
    values = typical(effect)
    limit = values["limit"]
    lines = (
        Line(x=_CURRENTS, y=_limited(joint()), name="without it", look=Look.WITHOUT),
        Line(x=_CURRENTS, y=_limited(joint(effect, values)), name="with it"),
    )
    panel = Panel(
        x=_ASKED, y="current of the motor, A", lines=lines, levels=(-limit, limit),
        notes=(Note(x=-CURRENT, y=limit, text="limit"),),
    )  # fmt: skip
    return Picture(title="The drive clips the current", panels=(panel,), values=values)


def inverter_dead_time(effect: Effect) -> Picture:
    """Show the current that comes over the one that was asked for, for both widths of the starting grid."""
    values = typical(effect, width=1.0)
    lost = values["lost_current"]
    lines = [Line(x=_CURRENTS, y=_limited(joint()), name="without it", look=Look.WITHOUT)]
    for width, look in ((3.0, Look.SECOND), (1.0, Look.FIRST)):
        vector = joint(effect, {**values, "width": width})
        lines.append(Line(x=_CURRENTS, y=_limited(vector), name=f"width {width:g}", look=look))
    panel = Panel(
        x=_ASKED, y="current of the motor, A", lines=tuple(lines), places=(-lost, lost),
        notes=(Note(x=lost, y=-0.75 * CURRENT, text=" lost_current"),),
    )  # fmt: skip
    return Picture(
        title="Dead time of the inverter: a dead zone, then a constant loss", panels=(panel,), values=values
    )


def _steps(effect: Effect, values: dict[str, float]) -> tuple[Line, Line]:
    """Return the command, both its edges, and the current that follows."""
    time = np.linspace(0.0, 0.4, 401)
    command = 0.5 * CURRENT * (np.where(time < 0.05, 0.0, 1.0) - np.where(time < 0.2, 0.0, 2.0))
    return (
        Line(x=time, y=command, name="command", look=Look.WITHOUT),
        Line(x=time, y=simulate(joint(effect, values), time, command)[2], name="current"),
    )


def _followed(effect: Effect, parameter: str, words: str, title: str) -> Picture:
    """Show both edges of the command and the current behind it; `parameter` is the time by which it is late."""
    values = typical(effect)
    late = 0.05 + values[parameter]
    panel = Panel(
        x=_TIME, y="current, A", lines=_steps(effect, values), places=(0.05, late),
        notes=(Note(x=late, y=-1.0, text=words),),
    )  # fmt: skip
    return Picture(title=title, panels=(panel,), values=values)


def transport_delay(effect: Effect) -> Picture:
    """Show a step up and a step down that come later."""
    return _followed(effect, "delay", " delay", "The command acts later, unchanged in shape")


def current_loop_lag(effect: Effect) -> Picture:
    """Show a step up and a step down that come gradually."""
    title = "The current follows its command through a first-order lag"
    return _followed(effect, "time_constant", " time_constant (63 %)", title)
