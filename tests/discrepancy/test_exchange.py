"""An effect that was taken while others were missing makes way for the one that is really there."""

from collections.abc import Callable, Mapping
from dataclasses import replace

import pytest

from daq.recording.recording import Recording
from discrepancy.data.series import read_series
from discrepancy.effects.table import EFFECTS
from discrepancy.model.schema import JointModel
from discrepancy.search.exchange import exchange
from discrepancy.search.options import SearchOptions
from discrepancy.search.outcome import Step
from discrepancy.search.state import polish, scan_effect
from discrepancy.simulation import slots as s
from discrepancy.workflow import prepare_simulation

Recorder = Callable[[Mapping[int, float], int], Recording]
TAKEN = ("coulomb_friction", "viscous_friction_drift")
OFFERED = {*TAKEN, "torque_constant_drift", "load_torque_offset"}


@pytest.mark.parametrize(
    ("drift", "named"),
    [
        ({s.CONSTANT_DRIFT: -0.3, s.CONSTANT_DRIFT_TIME: 10.0}, "torque_constant_drift"),
        ({s.VISCOUS_DRIFT: 0.3, s.VISCOUS_DRIFT_TIME: 10.0}, "viscous_friction_drift"),
    ],
)
def test_a_taken_name_stays_only_if_nothing_in_its_place_is_better(
    nameplate: JointModel, record: Recorder, drift: Mapping[int, float], named: str
) -> None:
    train = [read_series(record({s.COULOMB: 0.15, **drift}, k), nameplate, str(k)) for k in (1, 2)]
    prepared = prepare_simulation(nameplate, train, None)
    problem, ranges, state = prepared.problem, prepared.ranges, prepared.state
    steps = [Step(state=state, added=None)]
    for name in TAKEN:
        state = polish(problem, scan_effect(problem, state, name, ranges), ranges)
        steps.append(Step(state=state, added=name))
    context = replace(prepared.context, excluded=frozenset(EFFECTS) - OFFERED)
    done = exchange(problem, (state, steps), ranges, (SearchOptions(), context))
    if done is None:
        assert named in TAKEN
        return
    better, newer, _ = done
    assert {step.added for step in newer[1:]} == set(better.added) == {"coulomb_friction", named}
    assert named not in TAKEN
