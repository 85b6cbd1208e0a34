"""Shared fixtures; puts the project's root on the path, from which `tests.discrepancy.*` is imported."""

import sys
from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

# A plain `pytest` does not put the project's root on the path; `tests.discrepancy.*` and `benchmarks` are found there.
sys.path.insert(0, str(Path(__file__).parents[2]))

from daq.recording.recording import Recording
from discrepancy.data.series import read_series
from discrepancy.model.reader import parse_model
from discrepancy.model.schema import JointModel
from discrepancy.prepare import prepare_simulation
from discrepancy.search.course import Course
from discrepancy.search.outcome import Step
from discrepancy.simulation import slots as s
from tests.discrepancy.recorder import make_recording

Recorder = Callable[[Mapping[int, float], int], Recording]


@pytest.fixture
def nameplate() -> JointModel:
    """Return a joint whose viscous friction and torque constant are a little off."""
    return parse_model(
        {
            "name": "joint",
            "parameters": {
                "inertia": {"value": 0.5, "unit": "kg m^2", "fixed": True},
                "viscous_friction": {"value": 0.8, "unit": "N m s/rad"},
                "torque_constant": {"value": 1.05, "unit": "N m/A"},
            },
        }
    )


@pytest.fixture
def record() -> Recorder:
    """Return what makes a recording of a joint with some slots changed, from a noise seed; odd seeds repeat."""
    from tests.discrepancy.recorder import make_recording

    return lambda changes, seed: make_recording(changes, seed, input_seed=0 if seed < 10 else seed)


@pytest.fixture
def begun(nameplate: JointModel) -> Course:
    """Return the course of a search for dry friction that has only just begun, its records played twice."""
    series = [read_series(make_recording({s.COULOMB: 0.15}, seed), nameplate, str(seed)) for seed in (1, 2)]
    p = prepare_simulation(nameplate, series, None)
    return Course(
        problem=p.problem, context=p.context, ranges=p.ranges, steps=(Step(state=p.state, added=None),)
    )
