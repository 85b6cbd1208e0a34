"""A small law over the variables of a large one says that the large one has the wrong form."""

import numpy as np
import pytest

from discrepancy.data.series import read_series
from discrepancy.model.schema import JointModel
from discrepancy.prepare import Prepared, prepare_simulation
from discrepancy.search.outcome import Step
from discrepancy.search.patchwork import patchwork
from tests.discrepancy.recorder import make_recording

ANYTHING = np.array([np.inf])
"""What a patch leaves, where that is not known."""


@pytest.fixture
def joint(nameplate: JointModel) -> Prepared:
    series = [read_series(make_recording({}, seed), nameplate, str(seed)) for seed in (1, 2)]
    return prepare_simulation(nameplate, series, None)


def steps(joint: Prepared, **closed: float) -> list[Step]:
    """Return steps that closed so much, in units of the noise."""
    base = Step(state=joint.state, added=None)
    return [base, *(Step(state=joint.state, added=k, closed=np.array([v])) for k, v in closed.items())]


def test_a_small_law_over_the_variable_of_a_large_one_is_a_patch(joint: Prepared) -> None:
    assert patchwork(steps(joint, coulomb_friction=5.0, quadratic_drag=0.3), ANYTHING) == {
        "coulomb_friction",
        "quadratic_drag",
    }
    assert patchwork(steps(joint, coulomb_friction=5.0, quadratic_drag=4.0), ANYTHING) == set()


def test_friction_that_grows_with_the_load_is_no_patch_of_a_saturation(joint: Prepared) -> None:
    found = steps(joint, torque_saturation=10.0, load_dependent_friction=1.0)
    assert patchwork(found, ANYTHING) == set()


def test_friction_is_no_patch_of_play(joint: Prepared) -> None:
    assert patchwork(steps(joint, backlash=80.0, coulomb_friction=6.0), ANYTHING) == set()


def test_three_small_laws_over_any_variable_are_a_patch(joint: Prepared) -> None:
    small = {"torque_ripple": 0.3, "torque_constant_drift": 0.3, "torque_saturation": 0.3}
    assert patchwork(steps(joint, coulomb_friction=5.0, **small), ANYTHING) == set(small)


@pytest.mark.parametrize(("left", "is_patch"), [(0.1, True), (0.05, False)])
def test_a_small_law_that_leaves_hardly_anything_is_no_patch(
    joint: Prepared, left: float, is_patch: bool
) -> None:
    found = steps(joint, stribeck_friction=5.0, quadratic_drag=0.3)
    assert patchwork(found, np.array([left])) == (
        {"stribeck_friction", "quadratic_drag"} if is_patch else set()
    )
    small = steps(
        joint, coulomb_friction=5.0, torque_ripple=0.3, torque_constant_drift=0.3, torque_saturation=0.3
    )
    assert bool(patchwork(small, np.array([left]))) is is_patch
