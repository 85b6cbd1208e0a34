"""Pictures of torques over the angle: weight, ripple, stops, an inertia that depends on where the joint stands."""

import numpy as np

from discrepancy.effects.alone import alone, opposing_torque
from discrepancy.effects.pictures.friction import OPPOSING
from discrepancy.effects.pictures.joint import CURRENT, SPEED, TURN, joint, typical
from discrepancy.effects.pictures.spec import Line, Look, Note, Panel, Picture
from discrepancy.effects.spec import Effect
from discrepancy.simulation import slots as s
from discrepancy.simulation.kernels.laws import ripple_torque

_ANGLE = "angle, rad"
_ANGLES = np.linspace(-TURN, TURN, 241)


def gravity_unbalance(effect: Effect) -> Picture:
    """Show two turns of the motor, for a joint that turns as often and for one behind a gear."""
    values = typical(effect, wave_number=1.0)
    angles = 2.0 * _ANGLES
    lines = []
    for wave, look in ((0.5, Look.SECOND), (1.0, Look.FIRST)):
        vector = alone(effect, joint(effect, {**values, "wave_number": wave}))
        lines.append(
            Line(x=angles, y=opposing_torque(vector, angle=angles), name=f"wave_number {wave:g}", look=look)
        )
    panel = Panel(x=_ANGLE, y=OPPOSING, lines=tuple(lines), levels=(0.0,))
    return Picture(
        title="Weight off the axis: one wave for each turn of the joint", panels=(panel,), values=values
    )


def torque_ripple(effect: Effect) -> Picture:
    """Show cogging, which is always there, beside the ripple of windings, which the current scales."""
    values = typical(effect, with_current=0.0)
    vector = alone(effect, joint(effect, values))
    cogging = Line(x=_ANGLES, y=opposing_torque(vector, angle=_ANGLES), name="at any current")
    first = Panel(x=_ANGLE, y=OPPOSING, lines=(cogging,), levels=(0.0,))
    wound = joint(effect, {**values, "with_current": 1.0})
    lines = []
    for current, look in ((-0.5 * CURRENT, Look.SECOND), (CURRENT, Look.FIRST)):
        torque = np.array([ripple_torque(wound, q, current) for q in _ANGLES])
        lines.append(Line(x=_ANGLES, y=torque, look=look, name=f"{current:+g} A"))
    second = Panel(x=_ANGLE, y=OPPOSING, lines=tuple(lines), levels=(0.0,))
    return Picture(
        title="Torque ripple: cogging (with_current 0), and of the windings (with_current 1)",
        panels=(first, second), values=values,
    )  # fmt: skip


def position_dependent_inertia(effect: Effect) -> Picture:
    """Show the torque that both signs of the acceleration need, and the reaction at constant speed."""
    values = typical(effect, sine=0.0, cosine=0.4, wave_number=1.0, reaction=1.0)
    vector, rate = joint(effect, values), 50.0
    vector[s.VISCOUS] = 0.0
    plain = opposing_torque(joint(), angle=_ANGLES, acceleration=rate)
    lines = (
        Line(x=_ANGLES, y=plain, look=Look.WITHOUT, name="without it"),
        Line(x=_ANGLES, y=-plain, look=Look.WITHOUT),
        Line(x=_ANGLES, y=opposing_torque(vector, angle=_ANGLES, acceleration=rate), name=f"{rate:+g} rad/s²"),
        Line(
            x=_ANGLES, y=opposing_torque(vector, angle=_ANGLES, acceleration=-rate), name=f"{-rate:+g} rad/s²",
            look=Look.SECOND,
        ),
        Line(
            x=_ANGLES, y=opposing_torque(vector, angle=_ANGLES, speed=SPEED),
            name=f"constant {SPEED:g} rad/s", look=Look.THIRD,
        ),
    )  # fmt: skip
    panel = Panel(x=_ANGLE, y="torque needed, N m", lines=lines)
    return Picture(
        title="Inertia that depends on the angle, with its reaction torque", panels=(panel,), values=values
    )


def end_stop(effect: Effect) -> Picture:
    """Show both stops, at rest and on the way in and out."""
    values = typical(effect, high=0.8 * TURN, low=-0.8 * TURN, stiffness=4.0, damping=0.1)
    vector = alone(effect, joint(effect, values))
    angles = np.unique(np.concatenate([_ANGLES, [values["low"], values["high"]]]))
    # The damping makes the force jump at the stop: a point just beyond it.
    angles = np.unique(np.concatenate([angles, [values["low"] - 1e-6, values["high"] + 1e-6]]))
    lines = [
        Line(
            x=angles, y=opposing_torque(vector, angle=angles, speed=speed), look=look,
            name=f"at {speed:+g} rad/s" if speed else "at rest",
        )
        for speed, look in ((0.5 * SPEED, Look.SECOND), (-0.5 * SPEED, Look.THIRD), (0.0, Look.FIRST))
    ]  # fmt: skip
    panel = Panel(
        x=_ANGLE, y=OPPOSING, lines=tuple(lines), places=(values["low"], values["high"]),
        notes=(
            Note(x=values["low"], y=0.5, text=" low"), Note(x=values["high"], y=-1.2, text="high ", align="right"),
            Note(x=0.0, y=0.12, text="never pulls", align="center"),
        ),
    )  # fmt: skip
    return Picture(
        title="Mechanical stops: a spring and a damper beyond one angle", panels=(panel,), values=values
    )
