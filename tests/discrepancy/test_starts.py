"""Starting states are fitted by what a simulation really leaves."""

import numpy as np

from discrepancy.data.series import SPEED, Channel, Series
from discrepancy.fitting.problem import Noise, SimulationProblem
from discrepancy.fitting.projection import fit_starts
from discrepancy.simulation import slots as s


def test_the_starting_speed_of_a_coasting_joint_is_found_from_rest() -> None:
    vector = s.neutral_vector()
    vector[s.INERTIA], vector[s.VISCOUS] = 1.0, 0.5
    time = np.linspace(0.0, 2.0, 501)
    speed = Channel(name="speed_rad_s", row=SPEED, values=3.0 * np.exp(-0.5 * time), weight=np.ones(501))
    series = Series(
        label="coasting", step=4e-3, original_step=4e-3, time_s=time, input=np.zeros(501), angle=np.empty(0),
        channels=(speed,), windows=np.array([-1]), starts=np.zeros((1, 2)),
    )  # fmt: skip
    problem = SimulationProblem(series=(series,), noise=Noise(sigma={"speed_rad_s": 1.0}))
    found = fit_starts(problem, vector, problem.initial_starts())
    assert abs(found.starts[0][0, 0] - 3.0) < 1e-5
    assert found.loss < 1e-8
