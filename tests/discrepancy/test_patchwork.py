"""Two laws over one variable are a patch only while something over it is left."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

from discrepancy.assemble import column_names
from discrepancy.data.series import read_series
from discrepancy.effects.spec import Port
from discrepancy.model.schema import JointModel
from discrepancy.search.bench import make_bench
from discrepancy.search.options import SearchOptions
from discrepancy.search.outcome import Step
from discrepancy.search.patchwork import patchwork, still_shown
from discrepancy.search.state import polish, scan_effect
from discrepancy.simulation import slots as s
from discrepancy.workflow import Prepared, prepare_simulation
from tests.discrepancy.recorder import make_recording

SPEED = (Port.TORQUE, "speed_rad_s")
CURRENT = (Port.TORQUE, "current_A")


@pytest.fixture
def joint(nameplate: JointModel) -> Prepared:
    series = [read_series(make_recording({}, seed), nameplate, str(seed)) for seed in (1, 2)]
    return prepare_simulation(nameplate, series, None)


def steps(joint: Prepared, **closed: float) -> list[Step]:
    """Return steps that closed so much, in units of the noise."""
    base = Step(state=joint.state, added=None)
    return [base, *(Step(state=joint.state, added=k, closed=np.array([v])) for k, v in closed.items())]


FRICTIONS = {"coulomb_friction": 5.0, "quadratic_drag": 0.3}


@pytest.mark.parametrize(
    ("shown", "doubted"),
    [
        (None, set(FRICTIONS)),
        (frozenset({SPEED}), set(FRICTIONS)),
        (frozenset({CURRENT}), set()),
        (frozenset(), set()),
    ],
)
def test_a_small_law_over_the_speed_is_doubted_while_the_speed_shows_more(
    joint: Prepared, shown: frozenset[tuple[Port, str]] | None, doubted: set[str]
) -> None:
    assert patchwork(steps(joint, **FRICTIONS), shown) == doubted


def test_friction_that_grows_with_the_load_is_no_patch_of_a_saturation(joint: Prepared) -> None:
    found = steps(joint, torque_saturation=10.0, load_dependent_friction=1.0)
    assert patchwork(found, frozenset({CURRENT})) == set()


def test_three_small_laws_are_a_patch_whatever_is_left(joint: Prepared) -> None:
    small = {"torque_ripple": 0.3, "quadratic_drag": 0.3, "torque_saturation": 0.3}
    assert patchwork(steps(joint, coulomb_friction=5.0, **small), frozenset()) == set(small)


@pytest.mark.parametrize(
    ("more", "left"), [({}, False), ({s.STRIBECK_EXTRA: 0.1, s.STRIBECK_SPEED: 0.15}, True)]
)
def test_what_a_missing_dip_of_the_friction_leaves_is_still_shown(
    nameplate: JointModel, more: Mapping[int, float], left: bool
) -> None:
    truth = {s.COULOMB: 0.1, s.QUADRATIC: 0.1, **more}
    series = [read_series(make_recording(truth, seed), nameplate, str(seed)) for seed in (1, 2)]
    p = prepare_simulation(nameplate, series, None)
    state = p.state
    for name in FRICTIONS:
        state = polish(p.problem, scan_effect(p.problem, state, name, p.ranges), p.ranges)
    bench = make_bench(p.problem, state, p.ranges, replace(p.context, closed=np.ones(1)))
    assert (SPEED in still_shown(bench, SearchOptions(), column_names(nameplate))) is left
