"""A constant that a weight of a long wave may have taken in is declared, where the records cannot tell."""

import pytest

from discrepancy.data.series import read_series
from discrepancy.design.excitations import waveform
from discrepancy.design.limits import RigLimits
from discrepancy.model.schema import JointModel
from discrepancy.prepare import prepare_simulation
from discrepancy.search.options import SearchOptions
from discrepancy.search.outcome import Step
from discrepancy.search.state import polish, scan_effect
from discrepancy.search.swallowed import with_swallowed_offset
from discrepancy.simulation import slots as s
from discrepancy.workflow import GapOptions, run_gap
from tests.discrepancy.recorder import STEP_S, make_recording

TRUTH = {s.GRAVITY_SIN: 0.2, s.GRAVITY_COS: 0.15, s.GRAVITY_WAVE: 0.5}
BOTH = {("gravity_unbalance", "load_torque_offset"), ("gravity_unbalance", "current_sensor_offset")}


@pytest.mark.parametrize(
    ("noise", "is_declared"),
    [
        pytest.param(0.01, True, id="terms of third order drown"),
        pytest.param(0.001, False, id="they show"),
    ],
)
def test_a_constant_is_declared_where_the_records_cannot_tell_it_from_a_longer_wave(
    nameplate: JointModel, noise: float, is_declared: bool
) -> None:
    series = [read_series(make_recording(TRUTH, k, noise=noise), nameplate, str(k)) for k in (1, 2)]
    p = prepare_simulation(nameplate, series, None)
    named = polish(p.problem, scan_effect(p.problem, p.state, "gravity_unbalance", p.ranges), p.ranges)
    steps = [Step(state=p.state, added=None), Step(state=named, added="gravity_unbalance")]
    limits = SearchOptions(), p.context
    found = with_swallowed_offset(p.problem, steps, p.ranges, limits)[-1]
    assert (set(found.equivalents) >= BOTH) is is_declared
    apart = found.apart.get(s.GRAVITY_WAVE, 0.0) > 0.2 * float(named.fit.vector[s.GRAVITY_WAVE])
    assert apart is is_declared


def test_the_proposed_record_settles_whether_there_is_a_constant(nameplate: JointModel) -> None:
    records = [make_recording(TRUTH, k) for k in (1, 2)]
    test = [make_recording(TRUTH, 3, input_seed=5)]
    options = GapOptions(limits=RigLimits(amplitude=0.8, travel_low=-20.0, travel_high=20.0))
    asked = run_gap(nameplate, records, test, options).next_experiment
    assert asked is not None
    assert asked["separates"] == ["gravity_unbalance", "load_torque_offset"]
    assert asked["answers"] == [["gravity_unbalance"], ["gravity_unbalance", "load_torque_offset"]]
    current = waveform(asked["excitation"], asked["duration_s"], STEP_S)
    records.append(make_recording(TRUTH, 4, played=current))
    settled = run_gap(nameplate, records, test, options)
    assert settled.effects == ("gravity_unbalance",)
    assert settled.steps[-1].equivalents == ()
    assert settled.next_experiment is None
