"""Judging by torque, on short records of a joint whose torque constant is free."""

from dataclasses import replace

import numpy as np
import pytest

from daq.recording.recording import Recording, recording_from_columns
from discrepancy.assemble import column_names
from discrepancy.model.reader import parse_model
from discrepancy.prepare import prepare_torque
from discrepancy.search.beside import locate_beside
from discrepancy.simulation import slots as s
from discrepancy.simulation.kernels.joint import simulate_record
from discrepancy.torque.prepare import torque_problem
from discrepancy.torque.problem import read_motion
from discrepancy.workflow import run_gap
from tests.discrepancy.recorder import excite

SAMPLES, STEP_S = 3000, 2e-3
MODEL = parse_model(
    {
        "name": "joint",
        "judge_by": "torque",
        "parameters": {
            "inertia": {"value": 0.5, "unit": "kg m^2", "fixed": True},
            "viscous_friction": {"value": 0.8, "unit": "N m s/rad"},
            "torque_constant": {"value": 1.05, "unit": "N m/A"},
        },
    }
)  # fmt: skip

PARAMETERS = tuple(MODEL.parameters.items())


def short_record(level: float, seed: int, speed_noise: float = 0.002) -> Recording:
    """Simulate 6 s of a joint with dry friction."""
    vector = s.neutral_vector()
    vector[s.INERTIA], vector[s.VISCOUS], vector[s.COULOMB] = 0.5, 0.9, level
    time, current = np.arange(SAMPLES, dtype=np.float64) * STEP_S, excite(seed, SAMPLES, STEP_S)
    out = simulate_record(vector, time, current, np.empty(0), np.array([-1]), np.zeros((1, 2)))
    speed = out[0] + np.random.default_rng(seed).normal(0.0, speed_noise, SAMPLES)
    columns = {"time_s": time, "current_A": current, "speed_rad_s": speed, "position_rad": out[1]}
    return recording_from_columns(columns, sample_time_s=STEP_S)


@pytest.mark.parametrize("seed", [1, 2])
def test_dry_friction_in_a_short_record_is_named_alone(seed: int) -> None:
    result = run_gap(MODEL, [short_record(0.15, seed)], [short_record(0.15, seed + 50)])
    assert (result.verdict, result.effects) == ("named", ("coulomb_friction",))
    assert result.terms[0].parameters["level"].value == pytest.approx(0.15, rel=0.15)


def test_nothing_is_named_in_a_short_record_of_a_linear_joint() -> None:
    result = run_gap(MODEL, [short_record(0.0, 1)], [short_record(0.0, 51)])
    assert result.effects == ()


@pytest.mark.parametrize("late", [0, 1])
def test_when_the_input_acts_is_fitted_and_costs_no_parameter_its_value(late: int) -> None:
    record = short_record(0.0, 1)
    # The joint felt every current `late` samples after the one that is written beside its motion.
    current = np.roll(np.asarray(record.columns["current_A"]), -late)[:-1]
    columns = {name: np.asarray(values)[:-1] for name, values in record.columns.items()} | {
        "current_A": current
    }
    moved = recording_from_columns(columns, sample_time_s=STEP_S)
    found = prepare_torque(MODEL, [read_motion(moved, MODEL, "train")], None).state.fit.vector
    assert found[s.INPUT_SHIFT] == pytest.approx(min(late * STEP_S, 1.2e-3), abs=3e-4)
    if not late:
        assert found[s.VISCOUS] / found[s.TORQUE_CONSTANT] == pytest.approx(0.9, rel=0.02)


def test_a_weight_that_an_inertia_stands_in_for_is_located_over_the_angle() -> None:
    vector = s.neutral_vector()
    vector[s.INERTIA], vector[s.VISCOUS], vector[s.GRAVITY_SIN], vector[s.GRAVITY_WAVE] = 0.05, 0.4, 2.0, 1.0
    time = np.arange(SAMPLES, dtype=np.float64) * STEP_S
    current = 1.5 * np.sin(4.0 * time) + 0.3 * np.sin(9.0 * time)
    out = simulate_record(vector, time, current, np.empty(0), np.array([-1]), np.zeros((1, 2)))
    columns = {"time_s": time, "current_A": current, "speed_rad_s": out[0], "position_rad": out[1]}
    model = replace(
        MODEL, parameters={n: replace(q, fixed=n == "torque_constant", value=1.0) for n, q in PARAMETERS}
    )
    motion = read_motion(recording_from_columns(columns, sample_time_s=STEP_S), model, "train")
    prepared = prepare_torque(model, [motion], None)
    place = locate_beside(prepared.problem, prepared.state, column_names(model))
    assert (place.driver, place.share > 0.8) == ("position_rad", True)
    angle, torque = np.array(place.shape).T
    np.testing.assert_allclose(torque - np.interp(0.0, angle, torque), -2.0 * np.sin(angle), atol=0.3)


def test_a_motor_of_no_torque_and_a_joint_of_no_inertia_do_not_balance() -> None:
    problem = torque_problem(MODEL, [read_motion(short_record(0.0, 1), MODEL, "train")])
    vector = s.neutral_vector()
    vector[s.INERTIA], vector[s.VISCOUS], vector[s.TORQUE_CONSTANT] = 0.5, 0.9, 1.0
    whole = problem.simulate(vector, problem.initial_starts())[0][3]
    vector[[s.INERTIA, s.VISCOUS, s.TORQUE_CONSTANT]] *= 0.01
    np.testing.assert_allclose(problem.simulate(vector, problem.initial_starts())[0][3], whole, rtol=1e-9)


def test_a_short_record_is_held_out_in_a_dozen_blocks() -> None:
    problem = torque_problem(MODEL, [read_motion(short_record(0.0, 1), MODEL, "train")])
    blocks = problem.blocks(2.0)
    assert len(blocks) == 12
    assert [b[0].start for b in blocks[1:]] == [b[0].stop for b in blocks[:-1]]
    assert (blocks[0][0].start, blocks[-1][0].stop) == (0, problem.series[0].n)
