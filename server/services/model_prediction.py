"""Predict speed and travel by the simulation of a joint model, effects included, instead of the bare nameplate.

Theory of operation. The simulation is driven by a given current; the controller's slow centring loop feeds the position
back into it. Both are brought together by iteration: the linear joint with its centring loop is solved exactly, with
the simulation's deviation from that linear joint added to its position; the centring current that follows drives the
next simulation. The loop is slow and weak (0.005 Hz, 0.01 A/rad), so a few rounds settle it.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from daq.errors import ExcitationLimitError
from daq.excitation.check import StartCondition
from discrepancy.model.schema import JointModel
from server.errors import InputError, InputLocation

Floats = NDArray[np.float64]
ROUNDS = 25
SETTLED_RAD = 0.01
"""Change of the travel between two rounds at which they end: a three-thousandth of the emulated rig's travel."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelPredictor:
    """A joint model as a `daq.excitation.check.MotionPredictor`."""

    model: JointModel

    def predict_motion(
        self, reference: Floats, start: StartCondition, step_s: float
    ) -> tuple[Floats, Floats, Floats]:
        """Return centring current (A), speed (rad/s) and position (rad), each of shape (n,).

        Args:
            reference: current averaged over each step, A, shape (n,).
            start: position, and the centring loop.
            step_s: length of a step, s.

        Raises:
            ExcitationLimitError: the model's motion does not settle, so nothing can be promised.
        """
        vector = _kernel_vector(self.model)
        gain = start.centring_gain_a_rad
        if gain == 0.0:
            speed, position = _simulate(vector, reference, start.position_rad, step_s)
            return np.zeros_like(reference), speed, position
        loop = _CentringLoop(vector, start, step_s)
        deviation = np.zeros_like(reference)
        for _ in range(ROUNDS):
            centring, linear = loop.solve(reference, deviation)
            speed, position = _simulate(vector, reference + centring, start.position_rad, step_s)
            change = position - linear - deviation
            deviation = deviation + change
            if not np.abs(change).max() > SETTLED_RAD:
                return centring, speed, position
        travel = float(np.abs(position).max())
        raise ExcitationLimitError(
            f"the motion of model {self.model.name!r} with the centring loop does not settle in {ROUNDS} rounds; check "
            "the model, or leave it out of the rig file to predict by the nameplate",
            quantity="predicted travel",
            value=travel,
            limit=SETTLED_RAD,
        )


class _CentringLoop:
    """The linear joint with the controller's centring loop, as recursive filters."""

    def __init__(self, vector: Floats, start: StartCondition, step_s: float) -> None:
        from scipy.signal import cont2discrete

        from discrepancy.simulation import slots as s

        self._offset, self._gain = start.position_rad, start.centring_gain_a_rad
        rate = 2 * np.pi * start.centring_bandwidth_hz
        inertia, friction, torque = vector[s.INERTIA], vector[s.VISCOUS], vector[s.TORQUE_CONSTANT]
        # States: position and low-pass, both from the start, and speed; inputs: current, and deviation of the position.
        system = np.zeros((3, 3))
        system[0, 1] = 1.0
        system[1, 1:] = -friction / inertia, -self._gain * torque / inertia
        system[2, [0, 2]] = rate, -rate
        drive = np.array([[0.0, 0.0], [torque / inertia, 0.0], [0.0, rate]])
        outputs = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
        discrete = cont2discrete((system, drive, outputs, np.zeros((2, 2))), step_s)
        self._matrices: tuple[Floats, Floats] = np.asarray(discrete[0]), np.asarray(discrete[1])

    def solve(self, reference: Floats, deviation: Floats) -> tuple[Floats, Floats]:
        """Return the centring current, A, and the position of the linear joint that it drives, rad."""
        from daq.excitation.kernels import simulate_driven

        transition, drive = (np.ascontiguousarray(matrix) for matrix in self._matrices)
        held = reference - self._gain * self._offset
        states = simulate_driven(held, deviation, transition, drive)
        return -self._gain * (self._offset + states[1]), self._offset + states[0]


def _kernel_vector(model: JointModel) -> Floats:
    """Return the kernel's parameters without errors of the sensors, which move nothing."""
    from discrepancy.effects.spec import Port
    from discrepancy.effects.table import EFFECTS
    from discrepancy.fitting.parameters import model_vector

    moving = tuple(term for term in model.effects if EFFECTS[term.id].port is not Port.SENSOR)
    return model_vector(model.with_effects(moving))


def _simulate(vector: Floats, current: Floats, position_rad: float, step_s: float) -> tuple[Floats, Floats]:
    from discrepancy.data.series import POSITION, SPEED
    from discrepancy.fitting.problem import Noise, SimulationProblem
    from discrepancy.simulation.kernels.joint import simulate_record

    prepared = SimulationProblem(series=(), noise=Noise(sigma={})).prepare(vector)
    time_s = np.arange(current.size, dtype=np.float64) * step_s
    starts = np.array([[0.0, position_rad]])
    out = simulate_record(prepared, time_s, current, np.empty(0), np.array([-1], dtype=np.int64), starts)
    return out[SPEED], out[POSITION]


def read_predictor(path: Path) -> ModelPredictor:
    """Read a model file to predict a rig with.

    Raises:
        InputError: not a model, or not of a rotary joint.
    """
    from server.services.discrepancy import read_joint_model

    model = read_joint_model(path)
    if model.is_linear_axis:
        raise InputError(
            "is a model of a linear axis; the rig's travel is an angle", InputLocation(source=path)
        )
    return ModelPredictor(model=model)
