"""When a name is taken back, those that helped only beside it go with it."""

import numpy as np
import pytest

from discrepancy.data.series import read_series
from discrepancy.model.schema import JointModel
from discrepancy.prepare import prepare_simulation
from discrepancy.search.finish import without_steps
from discrepancy.search.outcome import SearchOutcome, Step
from discrepancy.search.state import polish, scan_effect
from discrepancy.simulation import slots as s
from tests.discrepancy.recorder import make_recording

NAMED = ("coulomb_friction", "load_torque_offset")
TRUTH = {s.COULOMB: 0.15, s.LOAD_OFFSET: 0.1}


@pytest.mark.parametrize(
    ("closed_beside", "left"), [(0.5, ("load_torque_offset",)), (50.0, ())], ids=["helps alone", "does not"]
)
def test_a_name_stays_if_it_closes_about_as_much_without_the_doubted_one(
    nameplate: JointModel, closed_beside: float, left: tuple[str, ...]
) -> None:
    series = [read_series(make_recording(TRUTH, seed), nameplate, str(seed)) for seed in (1, 2)]
    p = prepare_simulation(nameplate, series, None)
    steps = [Step(state=p.state, added=None)]
    for name in NAMED:
        state = polish(p.problem, scan_effect(p.problem, steps[-1].state, name, p.ranges), p.ranges)
        steps.append(Step(state=state, added=name, closed=np.array([closed_beside])))
    outcome = SearchOutcome(
        steps=tuple(steps),
        rounds=(),
        problem=p.problem,
        ranges=p.ranges,
        context=p.context,
        names={},
    )
    kept = without_steps(outcome, {"coulomb_friction"}, p.ranges)
    assert tuple(step.added for step in kept[1:]) == left
    assert all("coulomb_friction" not in step.state.added for step in kept)
    assert [step.added for step in without_steps(outcome, set(), p.ranges)[1:]] == list(NAMED)
