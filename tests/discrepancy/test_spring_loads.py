"""How presliding springs stand when a record begins is a starting state like speed and angle."""

from dataclasses import replace

import numpy as np
import pytest

from discrepancy.data.series import SPEED, read_series
from discrepancy.fitting.problem import PRELOAD, Noise, SimulationProblem
from discrepancy.fitting.projection import fit_starts
from discrepancy.model.schema import JointModel
from discrepancy.simulation import slots as s
from tests.discrepancy.recorder import make_recording

LEVEL = 0.2
SPRINGS = {s.PRESLIDING_LEVEL: LEVEL, s.PRESLIDING_STIFFNESS: 0.5, s.PRESLIDING_SHAPE: 3.0}
NOISE = 1e-4


@pytest.mark.parametrize("bent", [0.1, -0.15])
def test_springs_that_were_bent_before_a_record_are_found_bent(nameplate: JointModel, bent: float) -> None:
    series = read_series(make_recording(SPRINGS, 1), nameplate, "train")
    problem = SimulationProblem(series=(series,), noise=Noise(sigma={"speed_rad_s": NOISE}))
    vector = s.neutral_vector()
    for slot, value in ({s.INERTIA: 0.5, s.VISCOUS: 0.9, **SPRINGS}).items():
        vector[slot] = value
    vector = problem.prepare(vector)
    begun = np.array([[0.0, 0.0, 0.0, bent]])
    values = problem.simulate(vector, (begun,))[0][SPEED]
    shown = replace(
        problem, series=(replace(series, channels=(replace(series.channels[0], values=values),)),)
    )
    found = fit_starts(shown, vector, (np.zeros((1, 2)),))
    assert found.starts[0][0, PRELOAD] == pytest.approx(bent, abs=0.01)
    straight = shown.flatten(shown.simulate(vector, (np.zeros((1, 4)),))) - shown.measured()
    assert found.loss < 1e-3 * float(straight @ straight)


def test_without_springs_a_record_begins_with_speed_and_angle_alone() -> None:
    problem = SimulationProblem(series=(), noise=Noise(sigma={}))
    bent = (np.array([[0.3, 0.2, 0.0, 0.1]]), np.array([[0.1, 0.4]]))
    plain = problem.with_inner_states(s.neutral_vector(), bent)
    np.testing.assert_array_equal(plain[0], [[0.3, 0.2]])
    np.testing.assert_array_equal(plain[1], [[0.1, 0.4]])
    vector = s.neutral_vector()
    vector[s.PRESLIDING_LEVEL] = LEVEL
    both = problem.with_inner_states(vector, bent)
    np.testing.assert_array_equal(both[0], bent[0])
    np.testing.assert_array_equal(both[1], [[0.1, 0.4, 0.0, 0.0]])
