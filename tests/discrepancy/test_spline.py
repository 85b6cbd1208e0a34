"""The nameless curve of an `unknown` answer: it closes the gap in simulation, and it is told as no finding."""

import numpy as np
import pytest

from discrepancy.data.series import read_series
from discrepancy.effects.spec import Port
from discrepancy.locate import Place
from discrepancy.model.schema import JointModel
from discrepancy.prepare import prepare_simulation
from discrepancy.search.spline import fit_spline
from discrepancy.simulation import slots as s
from tests.discrepancy.recorder import make_recording

NAMES = {"speed": "speed_rad_s", "position": "position_rad", "input": "current_A"}


def test_a_curve_over_the_angle_finds_the_torque_of_gravity(nameplate: JointModel) -> None:
    truth = {s.GRAVITY_SIN: 0.1, s.GRAVITY_WAVE: 1.0}
    records = [read_series(make_recording(truth, seed), nameplate, "train") for seed in (1, 2)]
    p = prepare_simulation(nameplate, records, None)
    angles = np.quantile(p.problem.series[0].angle, np.linspace(0.0, 1.0, 14))
    place = Place(
        port=Port.TORQUE,
        driver="position_rad",
        region=None,
        share=1.0,
        shape=tuple((float(q), 0.0) for q in angles),
    )
    term = fit_spline(p.problem, p.state, p.ranges, place, NAMES)
    assert term is not None
    x, torque = np.array(term.points).T
    inside = slice(2, -2)
    # The curve opposes what gravity takes; between 14 knots a sine is a broken line, and the ends are seldom visited.
    assert torque[inside] == pytest.approx(-0.1 * np.sin(x[inside]), abs=0.02)


def test_no_curve_stands_for_a_sensor(nameplate: JointModel) -> None:
    records = [read_series(make_recording({}, seed), nameplate, "train") for seed in (1, 2)]
    p = prepare_simulation(nameplate, records, None)
    shape = tuple((float(x), 0.0) for x in range(5))
    place = Place(port=Port.SENSOR, driver="speed_rad_s", region=None, share=1.0, shape=shape)
    assert fit_spline(p.problem, p.state, p.ranges, place, NAMES) is None
