"""Motor and load behind a belt, and a filter at the sensor, against closed forms and an independent integration."""

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.signal import lfilter

from discrepancy.simulation import slots as s
from discrepancy.simulation.kernels.joint import simulate_record

FloatArray = NDArray[np.float64]
TIME: FloatArray = np.arange(4001, dtype=np.float64) * 1e-3
CURRENT: FloatArray = np.sin(2.0 * np.pi * 1.1 * TIME) + 0.4 * np.sin(2.0 * np.pi * 2.7 * TIME + 1.0)
STIFFNESS, SHARE, BEHIND = 30.0, 0.7, 0.8


def simulate(
    changes: dict[int, float], current: FloatArray = CURRENT, angle: FloatArray | None = None
) -> FloatArray:
    vector = s.neutral_vector()
    vector[s.INERTIA], vector[s.VISCOUS] = 0.5, 0.9
    for slot, value in changes.items():
        vector[slot] = value
    vector[s.MAX_STEP] = 2e-4
    seen = np.empty(0) if angle is None else angle
    return simulate_record(vector, TIME, current, seen, np.array([-1]), np.zeros((1, 2)))


BELT = {
    s.LOAD_SHARE: SHARE, s.STIFFNESS: STIFFNESS, s.DAMPING_RATIO: 0.2, s.LOAD_FRICTION_SHARE: BEHIND,
}  # fmt: skip


def test_weight_and_drag_act_behind_the_belt_and_ripple_before_it() -> None:
    load = {
        s.GRAVITY_SIN: 0.3, s.GRAVITY_COS: 0.1, s.GRAVITY_WAVE: 1.5, s.LOAD_OFFSET: 0.05, s.QUADRATIC: 0.2,
        s.RIPPLE_SIN: 0.2, s.RIPPLE_WAVE: 4.0, s.STOP_HIGH: 0.15, s.STOP_STIFFNESS: 5.0, s.STOP_DAMPING: 0.3,
    }  # fmt: skip
    damping = 2.0 * 0.2 * np.sqrt(STIFFNESS * 0.5 * SHARE * (1.0 - SHARE))

    def slope(t: float, x: FloatArray) -> list[float]:
        w, v, q, twist = x
        shaft = STIFFNESS * twist + damping * (w - v)
        i = np.sin(2.0 * np.pi * 1.1 * t) + 0.4 * np.sin(2.0 * np.pi * 2.7 * t + 1.0)
        stop = max(0.0, 5.0 * (q - 0.15) + 0.3 * v) if q > 0.15 else 0.0
        weight = 0.3 * np.sin(1.5 * q) + 0.1 * np.cos(1.5 * q)
        load = shaft - 0.9 * BEHIND * v - 0.2 * v * abs(v) - 0.05 - weight - stop
        motor = i - shaft - 0.9 * (1.0 - BEHIND) * w - 0.2 * np.sin(4.0 * q)
        return [motor / (0.5 * (1.0 - SHARE)), load / (0.5 * SHARE), w, w - v]

    truth = solve_ivp(slope, (0.0, TIME[-1]), np.zeros(4), t_eval=TIME, rtol=1e-9, atol=1e-11)
    for on_load, row in ((0.0, 0), (1.0, 1)):
        found = simulate({**BELT, **load, s.SENSOR_ON_LOAD: on_load})
        assert np.max(np.abs(found[0] - truth.y[row])) < 2e-3 * np.max(np.abs(truth.y[row]))


def test_a_load_that_sticks_lets_the_motor_wind_up_the_belt() -> None:
    steady = np.full(TIME.size, 0.2)  # a step winds the belt up to twice that at first
    stuck = {**BELT, s.LOAD_FRICTION_SHARE: 1.0, s.COULOMB: 0.5}
    motor, load = (simulate({**stuck, s.SENSOR_ON_LOAD: side}, steady) for side in (0.0, 1.0))
    assert np.all(load[0] == 0.0)
    assert motor[1, -1] == pytest.approx(0.2 / STIFFNESS, rel=1e-3)
    # Friction at the motor, in front of the belt, holds both.
    assert np.all(simulate({**BELT, s.LOAD_FRICTION_SHARE: 0.0, s.COULOMB: 0.5}, steady)[0] == 0.0)


def test_friction_behind_the_belt_grows_with_what_the_belt_carries() -> None:
    steady, grip = np.full(TIME.size, 0.5), 0.3
    damping = 2.0 * 0.2 * np.sqrt(STIFFNESS * 0.5 * SHARE * (1.0 - SHARE))

    def slope(t: float, x: FloatArray) -> list[float]:
        w, v, twist = x
        shaft = STIFFNESS * twist + damping * (w - v)
        # A drive that never turns: the load only goes forward, and so does friction not change its sign.
        load = shaft - 0.9 * v - (grip * abs(shaft) if v > 0.0 else np.sign(shaft) * grip * abs(shaft))
        return [(0.5 - shaft) / (0.5 * (1.0 - SHARE)), load / (0.5 * SHARE), w - v]

    truth = solve_ivp(slope, (0.0, TIME[-1]), np.zeros(3), t_eval=TIME, rtol=1e-9, atol=1e-11)
    rubbing = {**BELT, s.LOAD_FRICTION_SHARE: 1.0, s.LOAD_FRICTION: grip}
    found = simulate(rubbing, steady)[0]
    assert np.all(truth.y[1][1:] > 0.0)
    assert np.max(np.abs(found - truth.y[0])) < 2e-3 * np.max(truth.y[0])


def test_a_ripple_loads_the_friction_that_grows_with_the_load() -> None:
    grip, wave, start = 0.2, 2.0, 0.6
    vector = s.neutral_vector()
    vector[s.INERTIA], vector[s.VISCOUS] = 0.5, 1e-9
    vector[s.RIPPLE_SIN], vector[s.RIPPLE_WAVE], vector[s.LOAD_FRICTION] = 0.3, wave, grip
    vector[s.MAX_STEP] = 2e-4
    out = simulate_record(
        vector, TIME, np.zeros(TIME.size), np.empty(0), np.array([-1]), np.array([[0.0, start]])
    )
    # Without current it swings in a hollow of the ripple; friction takes its part on the way down and on the way up.
    height = (1.0 - grip) / (1.0 + grip) * (1.0 - np.cos(wave * start))
    assert out[1].min() == pytest.approx(-np.arccos(1.0 - height) / wave, rel=1e-3)


@pytest.mark.parametrize("too", [0.0, 1.0])
def test_a_filter_at_the_sensor_delays_the_angle_as_it_does_the_speed(too: float) -> None:
    free = simulate({})
    seen = simulate({s.FILTER_LAG: 0.1, s.FILTERS_ANGLE: too})
    keep = np.exp(-1e-3 / 0.1)
    late = lfilter([0.5 * (1.0 - keep), 0.5 * (1.0 - keep)], [1.0, -keep], free[1])
    expected = late if too else free[1]
    assert np.max(np.abs(seen[1] - expected)) < 1e-3 * np.max(np.abs(free[1]))
    assert np.max(np.abs(seen[0] - free[0])) > 0.1 * np.max(np.abs(free[0]))


def test_a_ripple_stays_in_place_though_the_measured_angle_is_late() -> None:
    ripple = {s.RIPPLE_SIN: 0.3, s.RIPPLE_WAVE: 6.0}
    truth = simulate(ripple)
    lagged = {**ripple, s.FILTER_LAG: 0.1, s.FILTERS_ANGLE: 1.0}
    blind = simulate(lagged)
    guided = simulate(lagged, angle=blind[1])
    assert np.max(np.abs(guided[0] - blind[0])) < 2e-3 * np.max(np.abs(blind[0]))
    assert np.max(np.abs(blind[0] - truth[0])) > 0.1 * np.max(np.abs(truth[0]))
