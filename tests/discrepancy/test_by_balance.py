"""The names that stand for a simulated position are those that predict the other half of the records."""

from dataclasses import replace

import numpy as np
import pytest

from discrepancy.data.series import read_series
from discrepancy.prepare import prepare_simulation
from discrepancy.search.by_balance import NOTE, choose_names
from discrepancy.search.choice import Contender
from discrepancy.search.greedy import Round
from discrepancy.search.halves import halves_error, split_series
from discrepancy.search.outcome import SearchOutcome, Step
from discrepancy.search.state import State, refit, scan_effect
from tests.discrepancy.test_free_run import MODEL, axis_record

WHOLE = [read_series(axis_record(0.0), MODEL, "train")]
PREPARED = prepare_simulation(MODEL, WHOLE, None)
TRUTH = ("coulomb_friction", "load_torque_offset")


def outcome_of(*names: str) -> SearchOutcome:
    """Return a search that has added these effects, fitted to the windows."""
    state: State = PREPARED.state
    steps = [Step(state=state, added=None)]
    for name in names:
        state = refit(
            PREPARED.problem,
            scan_effect(PREPARED.problem, state, name, PREPARED.ranges)[0],
            PREPARED.ranges,
        )
        steps.append(Step(state=state, added=name))
    return SearchOutcome(
        steps=tuple(steps), rounds=(), problem=PREPARED.problem, ranges=PREPARED.ranges,
        context=PREPARED.context, names={},
    )  # fmt: skip


def test_halves_of_a_record_are_its_samples_with_starts_of_their_own() -> None:
    one = WHOLE[0]
    first, second = split_series(one)
    np.testing.assert_array_equal(np.concatenate([first.time_s, second.time_s]), one.time_s)
    assert (list(first.windows), list(second.windows)) == ([-1], [-1])
    assert second.starts[0, 1] == second.channels[0].values[0]


def test_a_hole_in_the_second_half_stays_a_fresh_start() -> None:
    one = replace(WHOLE[0], windows=np.array([-1, -3001]))
    first, second = split_series(one)
    assert (list(first.windows), list(second.windows)) == ([-1], [-1, -1001])


@pytest.mark.parametrize(
    ("simulated", "balanced", "kept"),
    [
        (("quadratic_drag", "torque_ripple"), TRUTH, TRUTH),
        (TRUTH, ("quadratic_drag",), TRUTH),
        (TRUTH, (*TRUTH, "asymmetric_viscous_friction"), TRUTH),
    ],
)
def test_names_that_predict_the_other_half_stand(
    simulated: tuple[str, ...], balanced: tuple[str, ...], kept: tuple[str, ...]
) -> None:
    chosen = choose_names(outcome_of(*simulated), outcome_of(*balanced), WHOLE)
    assert chosen.steps[-1].state.added == kept
    assert (NOTE in chosen.notes) == (kept == balanced)


def test_the_true_laws_predict_a_half_to_a_fraction_of_what_one_of_them_does() -> None:
    right, poor = (outcome_of(*names).steps[-1].state for names in (TRUTH, TRUTH[:1]))
    error = halves_error(PREPARED.problem, right, WHOLE)
    assert error < 0.2 * halves_error(PREPARED.problem, poor, WHOLE)


def test_what_the_balance_tried_holds_no_winner_to_design_an_experiment_from() -> None:
    won = Contender(name="load_torque_offset", state=PREPARED.state, white_loss=1.0)
    lost = Contender(name="quadratic_drag", state=PREPARED.state, white_loss=2.0)
    one = Round(
        start=PREPARED.state, before=PREPARED.state, contenders=(won, lost), winner=won, equivalents=(),
        problem=PREPARED.problem,
    )  # fmt: skip
    balance = replace(outcome_of(*TRUTH), rounds=(one,))
    chosen = choose_names(outcome_of("quadratic_drag", "torque_ripple"), balance, WHOLE)
    assert [(r.winner, [c.name for c in r.contenders]) for r in chosen.rounds] == [(None, ["quadratic_drag"])]
