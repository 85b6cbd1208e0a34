"""Does the joint answer its input at all?"""

import numpy as np
from numpy.typing import NDArray

from discrepancy.data.series import CURRENT, SPEED
from discrepancy.errors import GapInputError
from discrepancy.fitting.problem import SimulationProblem

LEAST_RESPONSE = 0.01
"""Least part of the predicted size of an output that counts as an answer."""


def check_response(problem: SimulationProblem, vector: NDArray[np.float64]) -> None:
    """Refuse records in which the joint does not answer its input at all.

    Raises:
        GapInputError: an output moves less than a hundredth of what the nameplate predicts.
    """
    outputs = problem.simulate(problem.prepare(vector), problem.initial_starts())
    for one, output in zip(problem.series, outputs, strict=True):
        for channel in one.channels:
            predicted, seen = float(np.std(output[channel.row])), float(np.std(channel.values))
            # A simulated position or torque balance may be far off for other reasons than a blocked joint.
            if channel.row in (SPEED, CURRENT) and seen < LEAST_RESPONSE * predicted:
                raise GapInputError(
                    f"{one.label}: {channel.name} varies by {seen:.3g} where the nameplate predicts "
                    f"{predicted:.3g}: the joint "
                    "does not answer its input (blocked, disarmed, or at rest). Record a joint that moves"
                )
