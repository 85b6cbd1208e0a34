"""A soft stop is fitted as one, not as a joint whose inertia is larger than the nameplate's."""

import numpy as np
import pytest

from discrepancy.data.series import read_series
from discrepancy.effects.table import EFFECTS
from discrepancy.fitting.parameters import fit_parameter
from discrepancy.model.schema import JointModel
from discrepancy.prepare import prepare_simulation
from discrepancy.search.doubts import pressed
from discrepancy.search.state import polish, scan_effect
from discrepancy.simulation import slots as s
from tests.discrepancy.recorder import make_recording

HIGH, STIFFNESS, DAMPING = 0.6, 0.3, 0.05


def test_a_stop_that_hardly_holds_is_found_with_its_stiffness(nameplate: JointModel) -> None:
    truth = {s.STOP_HIGH: HIGH, s.STOP_LOW: -10.0, s.STOP_STIFFNESS: STIFFNESS, s.STOP_DAMPING: DAMPING}
    series = [read_series(make_recording(truth, k, noise=0.002), nameplate, str(k)) for k in (1, 2)]
    p = prepare_simulation(nameplate, series, None)
    # In the whole travel it adds less than the motor's torque.
    assert STIFFNESS * (p.ranges.high - p.ranges.low) < p.ranges.torque
    state = polish(p.problem, scan_effect(p.problem, p.state, "end_stop", p.ranges), p.ranges)
    assert pressed(state.fit, state.added) == []
    assert state.fit.vector[s.STOP_STIFFNESS] == pytest.approx(STIFFNESS, rel=0.05)
    assert state.fit.vector[s.STOP_HIGH] == pytest.approx(HIGH, abs=0.01)


def test_an_inertia_that_changes_with_the_angle_changes_within_the_travel(nameplate: JointModel) -> None:
    p = prepare_simulation(nameplate, [read_series(make_recording({}, 1), nameplate, "1")], None)
    effect = EFFECTS["position_dependent_inertia"]
    wave = next(one for one in effect.parameters if one.name == "wave_number")
    least = fit_parameter(effect, wave, p.ranges).lower
    angle = np.linspace(p.ranges.low, p.ranges.high, 100)
    # A sine through its steepest point, as flat as it may be: 64 % of its amplitude from end to end.
    change = np.ptp(np.sin(least * (angle - angle.mean())))
    assert change == pytest.approx(2.0 * np.sin(0.35), rel=1e-3)
