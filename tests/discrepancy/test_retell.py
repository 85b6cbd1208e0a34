"""The accepted models tell each law with what was named before it, also where later rounds changed what that was."""

from dataclasses import replace

import numpy as np
import pytest

from discrepancy.data.series import read_series
from discrepancy.model.schema import JointModel
from discrepancy.prepare import Prepared, prepare_simulation
from discrepancy.search.greedy import closed_amount
from discrepancy.search.outcome import Step
from discrepancy.search.retell import retold
from discrepancy.search.state import State, polish, scan_effect
from discrepancy.simulation import slots as s
from tests.discrepancy.recorder import make_recording

TRUTH = {s.COULOMB: 0.15, s.LOAD_OFFSET: 0.1}


@pytest.fixture
def sticky(nameplate: JointModel) -> Prepared:
    """Return a joint with dry friction and an offset."""
    series = [read_series(make_recording(TRUTH, seed), nameplate, str(seed)) for seed in (1, 2)]
    return prepare_simulation(nameplate, series, None)


def beside(prepared: Prepared, state: State, name: str) -> State:
    """Return the model with one more effect, fitted."""
    return polish(
        prepared.problem, scan_effect(prepared.problem, state, name, prepared.ranges), prepared.ranges
    )


def test_a_law_that_was_simplified_later_is_told_as_the_simple_one(sticky: Prepared) -> None:
    rich = beside(sticky, sticky.state, "stribeck_friction")
    level = beside(sticky, sticky.state, "coulomb_friction")
    both = beside(sticky, level, "load_torque_offset")
    stale = np.array([1e-3])
    steps = [
        Step(state=sticky.state, added=None),
        Step(state=rich, added="coulomb_friction", closed=stale),
        Step(state=both, added="load_torque_offset", closed=stale),
    ]
    base, first, last = retold(sticky.problem, steps, sticky.ranges, sticky.context)
    assert base is steps[0]
    assert first.state.added == ("coulomb_friction",)
    assert first.state.fit.loss == pytest.approx(level.fit.loss, rel=1e-3)
    assert last.state is both
    closed = closed_amount(sticky.problem, sticky.context, (sticky.state, level))
    assert first.closed == pytest.approx(closed, rel=1e-3)
    # What the last one closes was measured beside a model that is told otherwise now.
    assert last.closed == pytest.approx(
        closed_amount(sticky.problem, sticky.context, (level, both)), rel=1e-3
    )


def test_models_that_nothing_has_changed_stay_as_they_were_accepted(sticky: Prepared) -> None:
    level = beside(sticky, sticky.state, "coulomb_friction")
    both = beside(sticky, level, "load_torque_offset")
    steps = [
        Step(state=sticky.state, added=None),
        Step(state=level, added="coulomb_friction", closed=np.array([2.0])),
        Step(
            state=replace(both, added=("load_torque_offset", "coulomb_friction")), added="load_torque_offset"
        ),
    ]
    told = retold(sticky.problem, steps, sticky.ranges, sticky.context)
    assert all(one is other for one, other in zip(told, steps, strict=True))
