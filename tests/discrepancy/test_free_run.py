"""A long free run of a simulated position tells what windows of two seconds hardly show."""

import numpy as np

from daq.recording.recording import Recording, recording_from_columns
from discrepancy.data.ranges import signal_ranges
from discrepancy.data.series import read_series
from discrepancy.effects.table import EFFECTS
from discrepancy.evaluate import simulate_series
from discrepancy.fitting.free_run import best_free_run
from discrepancy.fitting.parameters import base_parameters, effect_parameters, model_vector
from discrepancy.fitting.problem import Noise, SimulationProblem
from discrepancy.model.reader import parse_model
from discrepancy.simulation import slots as s
from discrepancy.simulation.kernels.joint import simulate_record

NOISE_M = 1e-5
MODEL = parse_model(
    {
        "name": "axis", "axis": "linear", "input": "motor_force_N", "outputs": ["position_m"],
        "parameters": {"mass": {"value": 95.0, "unit": "kg"}, "viscous_friction": {"value": 200.0, "unit": "N s/m"}},
    }
)  # fmt: skip


def axis_record(start_s: float) -> Recording:
    """Simulate 20 s of a slide with dry friction and a small constant force; a record may begin in motion."""
    n, step = 4000, 5e-3
    vector = model_vector(MODEL)
    vector[s.INERTIA], vector[s.VISCOUS], vector[s.COULOMB], vector[s.LOAD_OFFSET] = 97.0, 210.0, 20.0, 0.2
    time = np.arange(n, dtype=np.float64) * step
    force = 60.0 * np.sin(2.2 * time) + 30.0 * np.sin(0.7 * time + 1.0)
    out = simulate_record(vector, time, force, np.empty(0), np.array([-1]), np.zeros((1, 2)))
    position = out[1] + np.random.default_rng(3).normal(0.0, NOISE_M, n)
    rows = time >= start_s
    columns = {"time_s": time[rows] - start_s, "motor_force_N": force[rows], "position_m": position[rows]}
    return recording_from_columns(columns, sample_time_s=step)


def test_a_free_run_finds_parameters_and_starting_states_together() -> None:
    one = read_series(axis_record(3.0), MODEL, "train")
    problem = SimulationProblem(series=(one,), noise=Noise(sigma={"position_m": NOISE_M}))
    vector = model_vector(MODEL)
    ranges = signal_ranges((one,), vector)
    parameters = [*base_parameters(MODEL, ranges, None)]
    for name in ("coulomb_friction", "load_torque_offset"):
        parameters.extend(effect_parameters(EFFECTS[name], (), ranges))
    vector[s.COULOMB] = 15.0
    found = best_free_run(problem, parameters, vector)
    # Noise alone leaves one variance a sample; a restart at a rounded time step leaves a little more.
    assert found.loss < 2.0 * one.n
    np.testing.assert_allclose(
        found.vector[[s.INERTIA, s.VISCOUS, s.COULOMB, s.LOAD_OFFSET]], [97.0, 210.0, 20.0, 0.2], rtol=0.02
    )


def test_a_record_that_begins_in_motion_is_scored_from_the_start_it_had() -> None:
    vector = model_vector(MODEL)
    vector[s.INERTIA], vector[s.VISCOUS], vector[s.COULOMB], vector[s.LOAD_OFFSET] = 97.0, 210.0, 20.0, 0.2
    curve = simulate_series([read_series(axis_record(3.0), MODEL, "test")], vector)[0]
    assert float(np.sqrt(np.mean((curve.measured - curve.simulated) ** 2))) < 3.0 * NOISE_M
