"""Each hidden effect shows at its own port, by the amount that its numbers say."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from mock_dsp.control.parameters import TICK_S, FastLoopParameters
from mock_dsp.physics.rig import EmulatedRig, RigTrace
from mock_dsp.scenario.effects import EFFECTS, Port

MakeRig = Callable[..., EmulatedRig]
COUNTS_PER_AMPERE = 8192.0
# Eight seconds of a slow swing with a fast one on it: reversals, travel of 2 rad, and some acceleration.
TIME = np.arange(20_000) * TICK_S
SWING = 0.6 * np.sin(2.0 * math.pi * TIME / 5.0) + 0.3 * np.sin(2.0 * math.pi * TIME * 1.3)

# Where the effect's default strength or time constant would show too little in eight seconds.
STRONGER = {
    "viscous_friction_drift": {"time_constant_s": 5.0},
    "torque_constant_drift": {"time_constant_s": 5.0},
    "rotor_heating": {"time_constant_s": 2.0},
    "load_torque_offset": {"torque_nm": 0.2},
    "sticky_spot": {"centre_rad": 0.5, "width_rad": 1.0},
    "end_stop": {"lower_rad": -0.3, "upper_rad": 0.3},
}
ON_TORQUE = [name for name, spec in EFFECTS.items() if spec.port is Port.TORQUE]


def swing(make_rig: MakeRig, effects: dict[str, dict[str, float]]) -> RigTrace:
    return make_rig(effects).run(SWING)


@pytest.mark.parametrize("effect", ON_TORQUE)
def test_a_torque_effect_changes_the_speed_and_leaves_the_current_loop_alone(
    effect: str, make_rig: MakeRig
) -> None:
    base, changed = swing(make_rig, {}), swing(make_rig, {effect: STRONGER.get(effect, {})})
    error = (changed.current_counts - changed.current_ref_counts.astype(float)) / COUNTS_PER_AMPERE
    assert np.std(changed.true_speed_rad_s - base.true_speed_rad_s) > 0.01
    assert np.std(error) < 0.02


def test_rotor_heating_changes_the_speed_at_the_same_measured_current(make_rig: MakeRig) -> None:
    base, hot = swing(make_rig, {}), swing(make_rig, {"rotor_heating": STRONGER["rotor_heating"]})
    assert np.std(hot.true_speed_rad_s - base.true_speed_rad_s) > 0.005
    assert np.std(hot.current_counts - base.current_counts.astype(float)) / COUNTS_PER_AMPERE < 0.01


def test_the_current_comes_late_by_the_transport_delay(make_rig: MakeRig) -> None:
    base = swing(make_rig, {}).true_current_a
    late = swing(make_rig, {"transport_delay": {"delay_s": 0.04}}).true_current_a
    assert np.std(late[100:] - base[:-100]) < 0.005
    assert np.std(late - base) > 0.05


def test_the_current_follows_as_a_first_order_lag(make_rig: MakeRig) -> None:
    rig = make_rig({"current_loop_lag": {"time_constant_s": 0.05}})
    trace = rig.run(np.full(1000, 0.8))
    assert trace.true_current_a[127] == pytest.approx(0.8 * (1.0 - math.exp(-1.0)), abs=0.02)


def test_the_current_saturates_below_its_reference(make_rig: MakeRig) -> None:
    trace = swing(make_rig, {"current_saturation": {"limit_a": 0.4}})
    assert np.max(trace.current_ref_counts) > 0.8 * COUNTS_PER_AMPERE
    assert np.max(np.abs(trace.true_current_a)) < 0.43


def test_uncompensated_dead_time_disturbs_the_current(make_rig: MakeRig) -> None:
    errors = []
    for effects in ({}, {"inverter_dead_time": {"extra_s": 1.2e-5}}):
        trace = swing(make_rig, effects)
        errors.append(
            np.std(trace.current_counts - trace.current_ref_counts.astype(float)) / COUNTS_PER_AMPERE
        )
    assert errors[0] < 0.006
    assert errors[1] > 0.01


def test_an_offset_of_the_monitor_shows_in_the_reading_only(make_rig: MakeRig) -> None:
    base, shifted = (
        swing(make_rig, {}),
        swing(make_rig, {"current_sensor_offset": {"monitor_offset_a": 0.06}}),
    )
    assert np.array_equal(shifted.true_speed_rad_s, base.true_speed_rad_s)
    shift = (shifted.current_counts - base.current_counts.astype(float)) / COUNTS_PER_AMPERE
    assert shift == pytest.approx(0.06, abs=1e-4)


def test_a_gain_of_the_monitor_shows_in_the_reading_only(make_rig: MakeRig) -> None:
    base, scaled = swing(make_rig, {}), swing(make_rig, {"current_sensor_gain": {"monitor_gain": 1.2}})
    assert np.array_equal(scaled.true_speed_rad_s, base.true_speed_rad_s)
    assert scaled.current_counts == pytest.approx(1.2 * base.current_counts, abs=1.0)
    assert scaled.phase_a_counts == pytest.approx(1.2 * base.phase_a_counts, abs=1.0)


def test_a_gain_of_the_hall_sensors_makes_the_loop_give_less_current(make_rig: MakeRig) -> None:
    trace = make_rig({"current_sensor_gain": {"monitor_gain": 1.0, "hall_gain": 1.2}}).run(np.full(5000, 0.9))
    assert np.mean(trace.current_counts[1000:]) / COUNTS_PER_AMPERE == pytest.approx(0.9, rel=0.01)
    assert np.mean(trace.true_current_a[1000:]) == pytest.approx(0.9 / 1.2, rel=0.01)
    # Flux and torque-producing current both shrink.
    assert np.mean(trace.true_torque_nm[1000:]) == pytest.approx(0.9 / 1.2**2, rel=0.01)


def test_a_hall_offset_shifts_the_true_phase_current_the_other_way(make_rig: MakeRig) -> None:
    numbers = {"monitor_offset_a": 0.0, "hall_offset_phase_a_a": 0.1}
    base, shifted = swing(make_rig, {}), swing(make_rig, {"current_sensor_offset": numbers})
    # The loop regulates what the sensor shows, so that the reading hardly changes and the torque ripples.
    assert np.mean(shifted.phase_a_counts - base.phase_a_counts.astype(float)) == pytest.approx(0.0, abs=82.0)
    assert np.std(shifted.true_torque_nm - base.true_torque_nm) > 0.01


def test_a_bent_potentiometer_shows_in_the_position_only(make_rig: MakeRig) -> None:
    base, bent = swing(make_rig, {}), swing(make_rig, {"potentiometer_nonlinearity": {"amplitude_rad": 0.4}})
    assert np.std(bent.true_speed_rad_s - base.true_speed_rad_s) < 0.01
    assert np.std(bent.position_counts - base.position_counts.astype(float)) > 50.0


def test_a_slow_filter_delays_the_position(make_rig: MakeRig) -> None:
    rig = make_rig({"speed_filter_lag": {"time_constant_s": 0.06}})
    trace = rig.run(np.full(10_000, 0.8))
    shown = (trace.position_counts.astype(float) - 32768.0) * 20.0 * math.pi / 65536.0
    behind = trace.true_position_rad[-1000:] - shown[-1000:]
    assert np.mean(behind) == pytest.approx(0.06 * trace.true_speed_rad_s[-1], abs=0.002)


def test_a_rectified_tacho_never_shows_a_negative_speed(make_rig: MakeRig) -> None:
    trace = swing(make_rig, {"rectified_speed_sensor": {}})
    assert np.min(trace.true_speed_rad_s) < -0.1
    assert np.min(trace.speed_counts) >= 0


def test_the_torque_saturates_at_its_limit(make_rig: MakeRig) -> None:
    trace = make_rig({"torque_saturation": {"limit_nm": 0.4}}).run(np.full(12_500, 0.9))
    assert trace.true_speed_rad_s[-1] == pytest.approx(0.4 / 0.9, rel=0.005)


@pytest.mark.parametrize(
    ("effect", "settled"),
    [("viscous_friction_drift", 0.8 / (0.05 + 0.85 * 1.5)), ("torque_constant_drift", 0.8 * 1.5 / 0.9)],
)
def test_a_drift_settles_at_its_fraction(effect: str, settled: float, make_rig: MakeRig) -> None:
    trace = make_rig({effect: {"fraction": 0.5, "time_constant_s": 1.0}}).run(np.full(25_000, 0.8))
    assert np.mean(trace.true_speed_rad_s[-500:]) == pytest.approx(settled, rel=0.01)


def test_each_switching_on_begins_cold(make_rig: MakeRig) -> None:
    rig = make_rig({"torque_constant_drift": {"fraction": 0.5, "time_constant_s": 1.0}})
    warm = rig.run(np.full(10_000, 0.8)).true_torque_nm[-1]
    rig.set_parameters(FastLoopParameters())
    rig.run(np.zeros(10))
    rig.set_parameters(FastLoopParameters(pwm_on=True))
    rig.run(np.zeros(250))
    cold = np.max(rig.run(np.full(250, 0.8)).true_torque_nm)
    assert warm == pytest.approx(0.8 * 1.5, rel=0.02)
    assert cold < 0.8 * 1.2


@pytest.mark.slow
@pytest.mark.parametrize("effect", EFFECTS)
def test_no_effect_drives_the_joint_out_of_its_travel(effect: str, make_rig: MakeRig) -> None:
    parameters = FastLoopParameters(pwm_on=True, centring_on=True)
    rig = make_rig({effect: {}}, noisy=True, parameters=parameters)
    time = np.arange(500_000) * TICK_S
    trace = rig.run(0.8 * np.sin(2.0 * math.pi * time / 20.0))
    assert trace.trip is None
