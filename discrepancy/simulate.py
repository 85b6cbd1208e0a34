"""Simulate a joint model over the input of one recording, beside what was measured."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from daq.recording.recording import Recording
from discrepancy.data.clean import LEAST_TO_SIMULATE
from discrepancy.data.series import Series, channel_row, read_series
from discrepancy.errors import GapInputError
from discrepancy.evaluate import simulate_series
from discrepancy.fitting.parameters import model_vector
from discrepancy.fitting.problem import Noise, SimulationProblem
from discrepancy.model.schema import InputHold, JointModel
from discrepancy.simulation import slots as s

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SimulatedRecord:
    """A simulation at the sample times of a recording; every array has shape (n,).

    Attributes:
        time_s: from the recording's first sample.
        input: what drove the simulation, in the unit of the model's input column.
        simulated: outputs of the model by column name, SI.
        measured: the same columns as measured, without those that the recording lacks.
    """

    time_s: FloatArray
    input: FloatArray
    simulated: Mapping[str, FloatArray]
    measured: Mapping[str, FloatArray]

    def rms_errors(self) -> dict[str, tuple[float, float]]:
        """Return for each measured output the rms error, SI, and its share of the signal's standard deviation."""
        found = {}
        for name, values in self.measured.items():
            error = float(np.sqrt(np.mean((values - self.simulated[name]) ** 2)))
            found[name] = error, error / max(float(np.std(values)), 1e-300)
        return found


def simulate_recording(model: JointModel, recording: Recording, label: str) -> SimulatedRecord:
    """Simulate a model in free run over a recording's input.

    Starting speed and angle are fitted to the measured outputs, and again behind every hole; without any measured
    output the joint starts at rest. Effects of the angle follow the measured angle where there is one.

    Args:
        model: parameters and effects, all taken as they are.
        recording: holds `model.input`; outputs are compared where they are there.
        label: what messages call the recording.

    Raises:
        GapInputError: no input column, a broken time axis, or a model whose simulation diverges.
    """
    measured_outputs = tuple(name for name in model.outputs if name in recording.columns)
    series = read_series(recording, replace(model, outputs=measured_outputs), label, LEAST_TO_SIMULATE)
    vector = model_vector(model)
    if model.input_hold is InputHold.HOLD:
        vector[s.INPUT_SHIFT] = 0.5 * series.step
    names = tuple(dict.fromkeys((*model.outputs, *(channel.name for channel in series.channels))))
    simulated = _simulate(series, vector, names)
    for name, values in simulated.items():
        wrong = np.flatnonzero(~np.isfinite(values))
        if wrong.size:
            raise GapInputError(
                f"{label}: the simulated {name} is not finite from {series.time_s[wrong[0]]:.4g} s on; "
                f"check the values of model {model.name!r}"
            )
    return SimulatedRecord(
        time_s=series.time_s,
        input=series.input,
        simulated=simulated,
        measured={channel.name: channel.values for channel in series.channels},
    )


def _simulate(series: Series, vector: FloatArray, names: tuple[str, ...]) -> dict[str, FloatArray]:
    if series.channels:
        curves = {curve.name: curve.simulated for curve in simulate_series([series], vector)}
        if set(names) <= set(curves):
            return {name: curves[name] for name in names}
    problem = SimulationProblem(series=(series,), noise=Noise(sigma={}))
    output = problem.simulate(problem.prepare(vector), problem.initial_starts())[0]
    return {name: output[channel_row(name)] for name in names}
