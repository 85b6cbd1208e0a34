"""Two effects of which neither is accepted alone, and one that needs no second."""

from collections.abc import Callable, Mapping
from dataclasses import replace

import pytest

from daq.recording.recording import Recording
from discrepancy.data.series import read_series
from discrepancy.effects.table import EFFECTS
from discrepancy.model.schema import JointModel
from discrepancy.prepare import prepare_simulation
from discrepancy.search.finish import search
from discrepancy.search.options import SearchOptions
from discrepancy.search.outcome import SearchOutcome
from discrepancy.simulation import slots as s

Recorder = Callable[[Mapping[int, float], int], Recording]
KEPT = {"coulomb_friction", "load_torque_offset", "quadratic_drag"}
NEARLY_ALL = SearchOptions(first_part=0.95)
"""No single effect may be accepted unless it closes nearly all of the gap."""


def search_among_three(
    nameplate: JointModel, record: Recorder, changes: Mapping[int, float]
) -> SearchOutcome:
    """Search two repeats with a catalogue of three effects."""
    train = [read_series(record(changes, seed), nameplate, f"train[{seed}]") for seed in (1, 2)]
    prepared = prepare_simulation(nameplate, train, None)
    context = replace(prepared.context, excluded=frozenset(EFFECTS) - KEPT)
    return search(prepared.problem, prepared.state, prepared.ranges, NEARLY_ALL, context, {})


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({s.COULOMB: 0.15, s.LOAD_OFFSET: 0.05}, {"coulomb_friction", "load_torque_offset"}),
        ({s.COULOMB: 0.15}, {"coulomb_friction"}),
        ({}, set()),
    ],
)
def test_a_pair_is_named_where_no_single_effect_is_enough(
    nameplate: JointModel, record: Recorder, changes: Mapping[int, float], expected: set[str]
) -> None:
    outcome = search_among_three(nameplate, record, changes)
    assert {step.added for step in outcome.steps[1:]} == expected


def test_the_pair_comes_from_the_pair_round(
    nameplate: JointModel, record: Recorder, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("discrepancy.search.course.find_pair", lambda *_: ())
    outcome = search_among_three(nameplate, record, {s.COULOMB: 0.15, s.LOAD_OFFSET: 0.05})
    assert outcome.steps[1:] == ()
