"""What is visible is asked of each output by itself."""

from dataclasses import replace

import numpy as np
import pytest

from daq.recording.recording import Recording, recording_from_columns
from discrepancy.data.series import read_series
from discrepancy.model.schema import JointModel
from discrepancy.prepare import Prepared, prepare_simulation
from discrepancy.search.choice import Contender, choose
from discrepancy.search.context import Context
from discrepancy.search.options import SearchOptions
from discrepancy.search.outputs import output_counts, output_losses, output_rows
from tests.discrepancy.recorder import make_recording


def _with_reference(seed: int) -> Recording:
    """Return a recording of speed and current whose reference the current follows exactly, but for its noise."""
    plain = make_recording({}, seed)
    columns = {name: np.array(plain.column(name)) for name in ("time_s", "current_A", "speed_rad_s")}
    columns["current_ref_A"] = columns["current_A"].copy()
    columns["current_A"] += np.random.default_rng(seed).normal(0.0, 1e-4, plain.n)
    return recording_from_columns(columns, sample_time_s=plain.sample_time_s)


@pytest.fixture
def prepared(nameplate: JointModel) -> Prepared:
    model = replace(nameplate, input="current_ref_A")
    return prepare_simulation(
        model, [read_series(_with_reference(seed), model, str(seed)) for seed in (1, 2)], None
    )


def test_a_sum_of_squares_is_split_by_output(prepared: Prepared) -> None:
    problem, residual = prepared.problem, prepared.state.fit.residual
    rows = np.array([problem.series[0].n, problem.series[0].n])
    np.testing.assert_array_equal(output_rows(problem), rows)
    # Two repeats were averaged: each row stands for two samples.
    np.testing.assert_allclose(output_counts(problem), 2 * rows)
    assert output_losses(problem, residual).sum() == pytest.approx(residual @ residual, rel=1e-12)


def test_what_closed_much_of_one_output_asks_nothing_more_of_another() -> None:
    context = Context(
        executor=None,
        repeat_noise=None,
        bin_size=np.ones(2),
        closed=np.array([0.0, 60.0]),
        signal=np.zeros(2),
    )
    limits = SearchOptions()
    expected = [limits.material_noise, limits.form_error * 60.0]
    np.testing.assert_allclose(context.material(limits, ()), expected)


@pytest.mark.parametrize(("closed", "name"), [((0.5, 0.0), "load_torque_offset"), ((0.0, 0.5), None)])
def test_an_effect_is_taken_if_one_output_shows_it(
    prepared: Prepared, closed: tuple[float, float], name: str | None
) -> None:
    # Half a noise rms is plain to see in the speed, and a small part of what has been closed in the current.
    state = replace(prepared.state, added=("current_loop_lag",))
    context = replace(prepared.context, closed=np.array([3.0, 60.0]))
    contender = Contender(
        name="load_torque_offset", state=state, white_loss=0.0, fall=1e4, closed=np.array(closed), part=1.0
    )
    winner = choose([contender], SearchOptions(), (state, context))
    assert (winner.name if winner else None) == name
