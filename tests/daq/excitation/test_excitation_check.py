"""The check of an excitation against closed forms, and the message of each refusal."""

import numpy as np
import pytest

from daq.errors import ExcitationLimitError
from daq.excitation.check import Nameplate, RigLimits, StartCondition, check_excitation, predict_excitation
from daq.excitation.spec import Excitation, Prbs, Setpoints, Sine, Trapezoid

LIMITS = RigLimits(
    current_limit_a=2.0,
    rated_current_a=1.26,
    i2t_time_s=10.0,
    slew_limit_a_s=2000.0,
    speed_limit_rad_s=180.0,
    travel_min_rad=-29.8,
    travel_max_rad=29.8,
)
JOINT = Nameplate(inertia_kg_m2=0.5, viscous_friction_nm_s_rad=0.9, torque_constant_nm_a=1.0)
CENTRED = StartCondition(centring_gain_a_rad=0.01, centring_bandwidth_hz=0.005)
FREE = StartCondition()


def test_speed_of_a_sine_is_the_frequency_response() -> None:
    report = predict_excitation(Sine(amplitude_a=0.5, period_s=5.0, duration_s=100.0), LIMITS, JOINT, FREE)
    omega = 2 * np.pi / 5.0
    steady = 0.5 / np.hypot(0.9, 0.5 * omega)
    # The first half wave starts at rest and overshoots the steady amplitude by the decaying transient.
    transient = 0.5 * 0.5 * omega / (0.9**2 + (0.5 * omega) ** 2)
    assert steady <= report.peak_speed_rad_s <= steady + transient
    assert report.rms_current_a == pytest.approx(0.5 / np.sqrt(2), rel=1e-4)
    # The steepest tick of a sine: amplitude times angular frequency.
    assert report.slew_a_s == pytest.approx(0.5 * omega, rel=1e-5)


def test_free_joint_is_displaced_as_the_closed_form_says() -> None:
    report = predict_excitation(Sine(amplitude_a=0.5, period_s=20.0, duration_s=200.0), LIMITS, JOINT, FREE)
    # A sine from rest pushes one way first: theta ends up swinging around A / (omega B) with that amplitude.
    omega = 2 * np.pi / 20.0
    centre = 0.5 / (omega * 0.9)
    swing = 0.5 / (omega * np.hypot(0.9, 0.5 * omega))
    assert report.position_max_rad == pytest.approx(centre + swing, rel=0.01)


def test_centring_loop_holds_an_offset_that_would_run_away() -> None:
    drifting = Sine(amplitude_a=0.2, offset_a=0.05, period_s=10.0, duration_s=1001.0)
    free = predict_excitation(drifting, LIMITS, JOINT, FREE)
    held = predict_excitation(drifting, LIMITS, JOINT, CENTRED)
    assert free.position_max_rad == pytest.approx(0.05 / 0.9 * 1001.0, rel=0.05)
    # The loop balances the offset at G x = 0.05 A, that is 5 rad; the slow poles overshoot on the way.
    assert held.position_max_rad < 12.0


def test_start_away_from_the_centre_counts_as_travel() -> None:
    start = StartCondition(position_rad=29.0)
    with pytest.raises(
        ExcitationLimitError, match=r"predicted travel of .* rad exceeds the limit of 29\.8 rad"
    ):
        check_excitation(Sine(amplitude_a=1.0, period_s=20.0, duration_s=20.0), LIMITS, JOINT, start)


@pytest.mark.parametrize(
    ("excitation", "quantity", "limit"),
    [
        (Sine(amplitude_a=2.5, period_s=5.0, duration_s=5.0), "peak current", 2.0),
        (Sine(amplitude_a=1.9, offset_a=0.1, period_s=0.5, duration_s=60.0, ramp_s=1.0), "I2t current", 1.26),
        (Prbs(amplitude_a=0.6, register_bits=9, bit_s=0.2, duration_s=20.0), "slew", 2000.0),
        (Sine(amplitude_a=0.5, offset_a=0.7, period_s=50.0, duration_s=100.0), "predicted travel", 29.8),
        (Sine(amplitude_a=0.5, offset_a=-0.7, period_s=50.0, duration_s=100.0), "predicted travel", -29.8),
        (Setpoints(values_a=(0.5,) * 2000, hold_s=0.05), "predicted travel", 29.8),
    ],
)
def test_refusal_names_quantity_value_and_limit(
    excitation: Excitation | Setpoints, quantity: str, limit: float
) -> None:
    limits = RigLimits(
        current_limit_a=2.0,
        rated_current_a=1.26,
        i2t_time_s=10.0,
        flux_current_a=1.2,
        slew_limit_a_s=2000.0,
        speed_limit_rad_s=180.0,
        travel_min_rad=-29.8,
        travel_max_rad=29.8,
    )
    with pytest.raises(
        ExcitationLimitError, match=f"{quantity} of .* exceeds the limit of {limit:g}"
    ) as refusal:
        check_excitation(excitation, limits, JOINT, FREE)
    assert refusal.value.quantity == quantity
    assert refusal.value.limit == limit
    assert abs(refusal.value.value) > abs(limit)


def test_speed_limit_is_judged() -> None:
    fast = Nameplate(inertia_kg_m2=5e-4, viscous_friction_nm_s_rad=5.65e-4, torque_constant_nm_a=1.0)
    with pytest.raises(ExcitationLimitError, match="predicted speed"):
        check_excitation(Sine(amplitude_a=0.5, period_s=5.0, duration_s=5.0), LIMITS, fast, FREE)


def test_paper_campaign_fits_the_rig() -> None:
    report = check_excitation(
        Trapezoid(amplitude_a=1.0, period_s=50.0, rise_fraction=0.2, duration_s=1001.0),
        LIMITS,
        JOINT,
        CENTRED,
    )
    assert report.duration_s == 1001.0
    assert report.peak_current_a < 1.5


def test_end_of_a_run_is_ramped_and_no_step() -> None:
    report = predict_excitation(Sine(amplitude_a=0.5, period_s=4.0, duration_s=5.0), LIMITS, JOINT, FREE)
    assert report.slew_a_s == pytest.approx(0.5 * 2 * np.pi / 4.0, rel=1e-5)


def test_final_step_of_set_points_counts_as_slew() -> None:
    report = predict_excitation(Setpoints(values_a=(0.0, 0.1, 0.2, 0.3), hold_s=0.1), LIMITS, JOINT, FREE)
    assert report.slew_a_s == pytest.approx(0.3 * 2500, rel=1e-3)


def test_run_without_end_is_refused() -> None:
    with pytest.raises(ValueError, match="never ends by itself"):
        check_excitation(Sine(amplitude_a=0.1, period_s=1.0), LIMITS, JOINT, FREE)
