"""Beside Stribeck friction, dry friction of two levels is an offset: the same equations, the simpler name."""

import numpy as np
import pytest

from discrepancy.data.series import read_series
from discrepancy.model.schema import JointModel
from discrepancy.prepare import prepare_simulation
from discrepancy.search.options import SearchOptions
from discrepancy.search.outcome import Step
from discrepancy.search.prune import prune
from discrepancy.search.same import exact_equivalents, simpler_laws
from discrepancy.search.state import polish, scan_effect
from discrepancy.simulation import slots as s
from tests.discrepancy.recorder import make_recording

TRUTH = {s.STRIBECK_COULOMB: 0.1, s.STRIBECK_EXTRA: 0.1, s.STRIBECK_SPEED: 0.1, s.LOAD_OFFSET: 0.06}


def test_an_offset_takes_the_place_of_two_levels_beside_stribeck_friction(nameplate: JointModel) -> None:
    series = [read_series(make_recording(TRUTH, seed), nameplate, str(seed)) for seed in (1, 2)]
    p = prepare_simulation(nameplate, series, None)
    state, steps = p.state, [Step(state=p.state, added=None)]
    for name in ("asymmetric_coulomb_friction", "stribeck_friction"):
        state = polish(p.problem, scan_effect(p.problem, state, name, p.ranges), p.ranges)
        steps.append(Step(state=state, added=name, closed=np.array([1.0])))
    limits = SearchOptions(), p.context, np.array([1.0])
    after, kept = prune(p.problem, (state, steps), p.ranges, limits)
    assert set(after.added) == {"load_torque_offset", "stribeck_friction"}
    assert after.fit.vector[s.LOAD_OFFSET] == pytest.approx(0.06, rel=0.05)
    assert after.fit.vector[s.STRIBECK_COULOMB] == pytest.approx(0.1, rel=0.1)
    assert [step.added for step in kept[1:]] == ["load_torque_offset", "stribeck_friction"]
    assert set(kept[1].equivalents) == {"current_sensor_offset", "asymmetric_coulomb_friction"}


def test_two_levels_alone_or_beside_another_law_stay() -> None:
    assert "load_torque_offset" not in simpler_laws("asymmetric_coulomb_friction", ("gravity_unbalance",))
    assert "load_torque_offset" not in simpler_laws("coulomb_friction", ("stribeck_friction",))
    assert exact_equivalents(["gravity_unbalance", "load_torque_offset"]) == ["current_sensor_offset"]
