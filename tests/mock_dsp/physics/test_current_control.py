"""The current loop, the centring loop and the bridge, seen through the rig."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from mock_dsp.control.parameters import CURRENT_SCALE_A, TICK_S, FastLoopParameters
from mock_dsp.physics.rig import EmulatedRig

MakeRig = Callable[..., EmulatedRig]
ON = FastLoopParameters(pwm_on=True)
POSITION_SCALE = 20.0 * math.pi / 65536.0


def test_a_current_step_settles_within_ten_milliseconds(make_rig: MakeRig) -> None:
    trace = make_rig().run(np.full(500, 0.8))
    current = trace.current_counts * CURRENT_SCALE_A
    # 150 Hz are 1 ms; the delay of one and a half ticks leaves about 10 % of overshoot.
    assert np.max(current) < 0.8 * 1.15
    assert np.max(np.abs(current[25:] - 0.8)) < 0.01


def test_the_first_voltage_comes_one_tick_after_the_sample(make_rig: MakeRig) -> None:
    trace = make_rig().run(np.full(10, 0.8))
    true_current = trace.true_current_a
    assert np.max(np.abs(true_current[:2])) < 0.002
    assert true_current[2] > 0.1


def test_torque_is_one_newton_metre_per_ampere(make_rig: MakeRig) -> None:
    trace = make_rig().run(np.full(2000, 0.8))
    assert np.mean(trace.true_torque_nm[1000:]) == pytest.approx(0.8 * 1.0, rel=0.01)


def test_measured_current_is_the_true_one_plus_sensor_noise(make_rig: MakeRig) -> None:
    trace = make_rig(noisy=True).run(0.8 * np.sin(np.arange(10_000) * TICK_S * 2.0))
    error = trace.current_counts * CURRENT_SCALE_A - trace.true_current_a
    assert abs(np.mean(error)) < 1e-3
    assert 0.002 < np.std(error) < 0.008


def test_the_joint_follows_the_nameplate_model(make_rig: MakeRig) -> None:
    """One pole, gain 1/0.9 rad/s per A, time constant 0.5/0.9 s: what the host predicts travel with."""
    time = np.arange(20_000) * TICK_S
    trace = make_rig(noisy=True).run(0.8 * np.sin(math.pi * time))
    speed = np.zeros(len(time))
    for index in range(1, len(time)):
        drive = trace.current_counts[index - 1] * CURRENT_SCALE_A
        speed[index] = speed[index - 1] + TICK_S / 0.5 * (drive - 0.9 * speed[index - 1])
    assert np.max(np.abs(trace.true_speed_rad_s - speed)) < 0.02 * np.max(speed)


def test_the_own_speed_channel_shows_the_true_speed_later(make_rig: MakeRig) -> None:
    trace = make_rig(noisy=True).run(np.full(5000, 0.8))
    shown = trace.speed_counts[-500:] / 128.0
    assert np.mean(shown) == pytest.approx(np.mean(trace.true_speed_rad_s[-500:]), abs=0.01)


def test_the_reference_is_clipped_rounded_and_flagged(make_rig: MakeRig) -> None:
    rig = make_rig(parameters=FastLoopParameters(pwm_on=True, current_limit_a=0.5))
    trace = rig.run(np.array([0.1, 0.5, 0.7, -0.9]))
    assert trace.current_ref_counts.tolist() == [819, 4096, 4096, -4096]
    assert trace.limited.tolist() == [False, False, True, True]


def test_centring_follows_its_documented_equations(make_rig: MakeRig) -> None:
    rig = make_rig(noisy=True)
    before = rig.run(np.full(20_000, 0.6))
    rig.set_parameters(
        FastLoopParameters(pwm_on=True, centring_on=True, centring_gain_a_rad=0.02, centring_bandwidth_hz=0.5)
    )
    weight = np.linspace(0.0, 1.0, 1000)
    trace = rig.run(np.zeros(1000), weight)
    position = (trace.position_counts.astype(float) - 32768.0) * POSITION_SCALE
    average = (float(before.position_counts[-1]) - 32768.0) * POSITION_SCALE
    expected = []
    for angle, share in zip(position, weight, strict=True):
        average += -math.expm1(-2.0 * math.pi * 0.5 * TICK_S) * (angle - average)
        expected.append(math.floor(-0.02 * average * share / CURRENT_SCALE_A + 0.5))
    assert average > 1.0
    assert trace.current_ref_counts.tolist() == expected


def test_without_the_bridge_the_current_dies_and_the_joint_coasts(make_rig: MakeRig) -> None:
    rig = make_rig()
    rig.run(np.full(5000, 0.8))
    rig.set_parameters(FastLoopParameters())
    trace = rig.run(np.full(2500, 0.8))
    assert abs(trace.true_torque_nm[50]) < 1e-3
    # One second of coasting: exp(-0.9/0.5), less the torque of the first milliseconds.
    assert trace.true_speed_rad_s[-1] == pytest.approx(trace.true_speed_rad_s[0] * math.exp(-1.8), rel=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("period_s", [5.0, 50.0])
def test_centring_keeps_the_joint_inside_its_travel_for_1001_s(period_s: float, make_rig: MakeRig) -> None:
    rig = make_rig(noisy=True, parameters=FastLoopParameters(pwm_on=True, centring_on=True))
    time = np.arange(2_502_500) * TICK_S
    trace = rig.run(np.clip(2.0 * np.sin(2.0 * math.pi * time / period_s), -1.0, 1.0))
    assert trace.trip is None
    assert np.max(np.abs(trace.true_position_rad)) < 25.0
    assert abs(np.mean(trace.true_position_rad[-500_000:])) < 1.0
