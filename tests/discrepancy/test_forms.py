"""Forms of a law: values that are chosen from a few, not fitted."""

from collections.abc import Callable, Mapping
from dataclasses import replace

import pytest

from daq.recording.recording import Recording
from discrepancy.data.series import read_series
from discrepancy.effects.table import EFFECTS
from discrepancy.fitting.parameters import write_start
from discrepancy.model.schema import JointModel
from discrepancy.search.state import refit, with_best_form
from discrepancy.simulation import slots as s
from discrepancy.workflow import prepare_simulation

Recorder = Callable[[Mapping[int, float], int], Recording]
STRIBECK = EFFECTS["stribeck_friction"]


@pytest.mark.parametrize("wrong", [1.0, 2.0])
def test_the_form_is_chosen_again_from_the_fitted_point(
    nameplate: JointModel, record: Recorder, wrong: float
) -> None:
    true = 3.0 - wrong
    hidden = {
        s.STRIBECK_COULOMB: 0.1,
        s.STRIBECK_EXTRA: 0.08,
        s.STRIBECK_SPEED: 0.1,
        s.STRIBECK_EXPONENT: true,
    }
    train = [read_series(record(hidden, seed), nameplate, f"train[{seed}]") for seed in (1, 2)]
    prepared = prepare_simulation(nameplate, train, None)
    start = {"coulomb_level": 0.1, "static_excess": 0.08, "stribeck_speed": 0.1, "exponent": wrong}
    vector = write_start(prepared.state.fit.vector, STRIBECK, start, ())
    state = replace(
        prepared.state, added=(STRIBECK.id,), fit=replace(prepared.state.fit, vector=vector), nameplate=None
    )
    fitted = refit(prepared.problem, state, prepared.ranges, 8)
    best = with_best_form(prepared.problem, fitted, STRIBECK.id, prepared.ranges)
    assert best.fit.vector[s.STRIBECK_EXPONENT] == true
    assert best.fit.loss < fitted.fit.loss
    assert best.fit.vector[s.STRIBECK_EXTRA] == pytest.approx(0.08, rel=0.05)
