"""Limits of the fast loop and the sensor faults that provoke them."""

from collections.abc import Callable

import numpy as np
import pytest

from daq.protocol.codes import FaultBit
from mock_dsp.control.parameters import FastLoopParameters
from mock_dsp.physics.rig import EmulatedRig
from mock_dsp.scenario.faults import FaultName
from mock_dsp.scenario.schema import Fault

MakeRig = Callable[..., EmulatedRig]

# Each limit is set where an 0.8 A step must reach it within 4 s.
TRIPS = {
    FaultBit.OVER_CURRENT: FastLoopParameters(pwm_on=True, over_current_a=0.7),
    FaultBit.OVER_SPEED: FastLoopParameters(pwm_on=True, speed_limit_rad_s=0.3),
    FaultBit.TRAVEL: FastLoopParameters(pwm_on=True, travel_max_rad=1.0),
    FaultBit.I2T: FastLoopParameters(pwm_on=True, rated_current_a=0.5, i2t_time_s=1.0),
}


@pytest.mark.parametrize(("fault", "parameters"), TRIPS.items(), ids=lambda value: getattr(value, "name", ""))
def test_a_violated_limit_ends_the_block_at_its_tick(
    fault: FaultBit, parameters: FastLoopParameters, make_rig: MakeRig
) -> None:
    rig = make_rig(parameters=parameters)
    trace = rig.run(np.full(10_000, 0.8))
    assert trace.trip is fault
    assert 0 < trace.ticks_done < 10_000
    assert len(trace.current_counts) == trace.ticks_done
    assert rig.tick == 250 + trace.ticks_done


def test_i2t_trips_when_the_heat_model_says(make_rig: MakeRig) -> None:
    """rms^2 = (0.8^2 + 0.4455^2)/2 = 0.419 A^2 against 0.25 A^2: 1 after tau ln(1/(1 - 0.25/0.419))."""
    trace = make_rig(parameters=TRIPS[FaultBit.I2T]).run(np.full(10_000, 0.8))
    # The 0.1 s of magnetising before have already warmed the model by a few percent.
    assert trace.ticks_done * 4e-4 == pytest.approx(np.log(1.0 / (1.0 - 0.25 / 0.419)), abs=0.1)


def test_a_condition_stays_visible_without_tripping_when_the_bridge_is_off(make_rig: MakeRig) -> None:
    rig = make_rig(parameters=TRIPS[FaultBit.TRAVEL])
    rig.run(np.full(10_000, 0.8))
    rig.set_parameters(FastLoopParameters(travel_max_rad=1.0))
    trace = rig.run(np.zeros(100))
    assert trace.trip is None
    assert trace.ticks_done == 100
    assert rig.conditions == (FaultBit.TRAVEL,)


def test_a_surge_trips_at_its_own_tick(make_rig: MakeRig) -> None:
    rig = make_rig(faults=(Fault(name=FaultName.OVER_CURRENT, at_s=0.2),))
    trace = rig.run(np.zeros(1000))
    assert trace.trip is FaultBit.OVER_CURRENT
    assert rig.tick - 1 == 500


def test_a_stuck_potentiometer_repeats_its_reading_and_trips(make_rig: MakeRig) -> None:
    rig = make_rig(noisy=True, faults=(Fault(name=FaultName.STUCK_SENSOR, at_s=0.2),))
    trace = rig.run(np.full(2000, 0.5))
    assert trace.trip is FaultBit.SENSOR
    assert 740 <= rig.tick <= 751
    assert len(set(trace.position_counts[250:].tolist())) == 1


def test_a_healthy_potentiometer_never_looks_stuck(make_rig: MakeRig) -> None:
    assert make_rig(noisy=True).run(np.zeros(20_000)).trip is None


def test_a_potentiometer_at_its_rail_is_a_sensor_fault(make_rig: MakeRig) -> None:
    """Bent upwards by 2 rad near the end of its travel, the potentiometer gets to its rail first."""
    bent = {"potentiometer_nonlinearity": {"amplitude_rad": 2.0, "cycles": 0.5, "phase_rad": 0.07}}
    rig = make_rig(bent, parameters=FastLoopParameters(pwm_on=True, travel_max_rad=40.0))
    trace = rig.run(np.full(120_000, 1.0))
    assert trace.trip is FaultBit.SENSOR
    assert trace.position_counts[-1] == 65535


def test_a_hall_shift_lasts_as_long_as_it_says(make_rig: MakeRig) -> None:
    fault = Fault(name=FaultName.HALL_OFFSET, at_s=0.2, duration_s=0.1, magnitude=0.2)
    trace = make_rig(faults=(fault,)).run(np.zeros(1000))
    ripple = np.abs(trace.current_counts - trace.current_ref_counts) / 8192.0
    shifted = slice(500 - 250, 750 - 250)
    assert np.max(ripple[shifted]) > 0.05
    assert np.max(ripple[: shifted.start]) < 0.01
