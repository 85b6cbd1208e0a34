"""Pictures of a motor and a load with a gap or a spring between: the torque in the shaft, and what it does."""

import numpy as np

from discrepancy.effects.pictures.joint import CURRENT, TORQUE_CONSTANT, joint, simulate, typical
from discrepancy.effects.pictures.spec import FloatArray, Line, Look, Note, Panel, Picture
from discrepancy.effects.spec import Effect
from discrepancy.simulation.kernels.joint import shaft_torque

_SHAFT = "torque in the shaft, N m"
_TWIST = "twist, rad"


def _shaft_law(vector: FloatArray, twists: FloatArray) -> FloatArray:
    """Return the torque at rest, so without its damping, shape (n,)."""
    return np.array([shaft_torque(vector, (0.0, 0.0, twist), 0.0) for twist in twists])


def backlash(effect: Effect) -> Picture:
    """Show the play in the shaft, and the speeds as the motor reverses."""
    values = typical(effect, load_share=0.6, friction_share=0.6)
    half = 0.5 * values["gap"]
    twists = half * np.unique(np.concatenate([np.linspace(-1.4, 1.4, 41), [-1.0, 1.0]]))
    law = Line(x=twists, y=_shaft_law(joint(effect, values), twists))
    top = float(law.y[-1])
    first = Panel(
        x=_TWIST, y=_SHAFT, lines=(law,), places=(-half, half),
        notes=(
            Note(x=0.0, y=0.08 * top, text="gap", align="center"),
            Note(x=0.95 * half, y=0.8 * top, text="slope: stiffness ", align="right"),
        ),
    )  # fmt: skip
    time = np.linspace(0.0, 0.4, 401)
    command = 0.25 * CURRENT * np.where(time < 0.1, 1.0, -1.0)
    lines = []
    for name, side, look in (("motor", 0.0, Look.SECOND), ("load", 1.0, Look.FIRST)):
        speed = simulate(joint(effect, {**values, "read_on_load": side}), time, command)[0]
        lines.append(Line(x=time, y=speed, name=name, look=look))
    top = max(float(line.y.max()) for line in lines)
    second = Panel(
        x="time, s", y="speed, rad/s", lines=tuple(lines), places=(0.1,),
        notes=(Note(x=0.1, y=1.05 * top, text=" torque reversed"),),
    )  # fmt: skip
    return Picture(
        title="Free play: after a reversal the motor turns alone, then hits",
        panels=(first, second),
        values=values,
    )


def belt_compliance(effect: Effect) -> Picture:
    """Show the spring, and the response over frequency as the motor and as the load shows it."""
    values = typical(effect, load_share=0.6, friction_share=0.6, damping_ratio=0.05, stiffness=40.0)
    twists = 0.05 * np.linspace(-1.0, 1.0, 3)
    law = Line(x=twists, y=_shaft_law(joint(effect, values), twists))
    first = Panel(
        x=_TWIST, y=_SHAFT, lines=(law,),
        notes=(Note(x=0.0, y=0.5 * float(law.y[-1]), text="slope: stiffness ", align="right"),),
    )  # fmt: skip
    lines = [
        _response(joint(), "rigid joint", Look.WITHOUT),
        _response(joint(effect, {**values, "read_on_load": 0.0}), "motor", Look.SECOND),
        _response(joint(effect, {**values, "read_on_load": 1.0}), "load", Look.FIRST),
    ]
    second = Panel(
        x="frequency, Hz", y="speed over torque, rad/s/(N m)", lines=tuple(lines), logarithmic=True
    )
    return Picture(
        title="An elastic belt or shaft: anti-resonance and resonance", panels=(first, second), values=values
    )


def _response(vector: FloatArray, name: str, look: Look) -> Line:
    """Return the amplitude of the speed over that of the torque: by the answer to a short push, which dies away."""
    time = 1e-3 * np.arange(8192, dtype=np.float64)
    push = np.where(time < 2.5e-3, CURRENT, 0.0)
    speed = simulate(vector, time, push)[0]
    frequency = np.fft.rfftfreq(time.size, 1e-3)
    ratio = np.abs(np.fft.rfft(speed) / np.fft.rfft(TORQUE_CONSTANT * push))
    shown = np.unique(np.geomspace(8, 800, 140).astype(int))
    return Line(x=frequency[shown], y=ratio[shown], name=name, look=look)
