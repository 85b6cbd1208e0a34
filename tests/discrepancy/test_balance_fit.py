"""Parameters of a simulated position are judged on kinds of motion that the fit has not seen."""

from dataclasses import replace

import numpy as np
import pytest

from daq.recording.recording import Recording, recording_from_columns
from discrepancy.data.series import read_series
from discrepancy.model.reader import parse_model
from discrepancy.model.schema import JointModel
from discrepancy.prepare import Prepared, prepare_simulation, prepare_torque
from discrepancy.search.balance_fit import choose_parameters, motion_kinds, period_samples
from discrepancy.search.outcome import SearchOutcome, Step
from discrepancy.search.state import refit, scan_effect
from discrepancy.simulation import slots as s
from discrepancy.simulation.kernels.joint import simulate_record
from discrepancy.torque.problem import read_motion
from tests.discrepancy.test_free_run import MODEL

STEP_S, PERIOD_S, MASS_KG = 5e-3, 5.0, 95.0
BY_FORCE: JointModel = parse_model(
    {
        "name": "axis", "axis": "linear", "input": "motor_force_N", "outputs": ["position_m"], "judge_by": "torque",
        "parameters": {"mass": {"value": 90.0, "unit": "kg"}, "viscous_friction": {"value": 180.0, "unit": "N s/m"}},
    }
)  # fmt: skip


def repeating_record() -> Recording:
    """Simulate four periods of a slide with dry friction and a force over the position that no fit here knows."""
    time = np.arange(round(4 * PERIOD_S / STEP_S), dtype=np.float64) * STEP_S
    phase = 2.0 * np.pi * time / PERIOD_S
    force = 60.0 * np.sin(phase) + 30.0 * np.sin(3.0 * phase + 1.0) + 20.0 * np.sin(7.0 * phase)
    vector = s.neutral_vector()
    vector[s.INERTIA], vector[s.VISCOUS], vector[s.COULOMB] = MASS_KG, 200.0, 20.0
    vector[s.GRAVITY_SIN], vector[s.GRAVITY_WAVE] = 2.0, 60.0
    out = simulate_record(vector, time, force, np.empty(0), np.array([-1]), np.zeros((1, 2)))
    columns = {"time_s": time, "motor_force_N": force, "position_m": out[1]}
    return recording_from_columns(columns, sample_time_s=STEP_S)


def named(prepared: Prepared, *names: str) -> SearchOutcome:
    """Return an outcome whose last model holds these effects, fitted to what was prepared."""
    state = prepared.state
    steps = [Step(state=state, added=None)]
    for name in names:
        state = scan_effect(prepared.problem, state, name, prepared.ranges)[0]
        state = refit(prepared.problem, state, prepared.ranges)
        steps.append(Step(state=state, added=name))
    return SearchOutcome(
        steps=tuple(steps), rounds=(), problem=prepared.problem, ranges=prepared.ranges,
        context=prepared.context, names={},
    )  # fmt: skip


def test_the_period_of_a_motion_is_found_and_drift_does_not_hide_it() -> None:
    phase = 2.0 * np.pi * np.arange(2000) / 450.0
    angle = np.sin(phase) + 0.5 * np.sin(2.0 * phase + 1.0)
    assert period_samples(angle + 1e-5 * np.arange(2000)) == pytest.approx(450, abs=2)


@pytest.mark.parametrize(
    "angle", [np.zeros(1000), np.linspace(0.0, 1.0, 1000), np.arange(1000.0) ** 2 % 777.0]
)
def test_what_does_not_repeat_has_no_period(angle: np.ndarray) -> None:
    assert period_samples(angle) is None


def test_a_kind_of_motion_is_a_third_of_the_period_in_all_periods() -> None:
    kinds = motion_kinds(read_series(repeating_record(), MODEL, "train"))
    period = round(PERIOD_S / STEP_S)
    np.testing.assert_array_equal(kinds[:period], kinds[period : 2 * period])
    assert list(np.bincount(kinds[:period])) == pytest.approx([period / 3] * 3, abs=2)


def test_parameters_that_only_cancel_over_this_course_of_the_motion_do_not_stand() -> None:
    record = repeating_record()
    whole = [read_series(record, MODEL, "train")]
    simulated = named(prepare_simulation(MODEL, whole, None), "coulomb_friction")
    motion = read_motion(record, BY_FORCE, "train")
    balanced = named(prepare_torque(BY_FORCE, [motion], None), "coulomb_friction")
    chosen = choose_parameters(simulated, balanced, whole)
    before, after = (one.steps[-1].state.fit.vector[s.INERTIA] for one in (simulated, chosen))
    assert abs(after - MASS_KG) < 0.7 * abs(before - MASS_KG)
    assert "those of the torque balance" in chosen.notes[-1]
    # Its errors are those of that fit too, not of a position that drifts.
    last = chosen.steps[-1]
    assert last.errors is not None
    errors = {p.name: float(e) for p, e in zip(last.state.fit.parameters, last.errors, strict=True)}
    assert 0.0 < errors["mass"] < 0.02 * MASS_KG
    assert 0.0 < errors["level"] < 2.0


def test_other_names_keep_their_own_parameters() -> None:
    whole = [read_series(repeating_record(), MODEL, "train")]
    simulated = named(prepare_simulation(MODEL, whole, None), "coulomb_friction")
    assert choose_parameters(simulated, replace(simulated, steps=simulated.steps[:1]), whole) is simulated
