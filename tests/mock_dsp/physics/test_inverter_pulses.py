"""Pulses of the bridge: duty, dead time and what the sub-steps see of them."""

from collections.abc import Callable

import numpy as np
import pytest

from mock_dsp.physics.kernels.inverter import (
    bridge_voltage,
    current_sign,
    diode_voltage,
    on_share,
    pulse_edges,
)

Machine = tuple[np.void, np.void]
MakeMachine = Callable[..., Machine]


@pytest.mark.parametrize("substeps", [2, 20, 50])
@pytest.mark.parametrize("duty", [0.0, 0.013, 0.5, 0.97, 1.0])
def test_the_sub_steps_together_see_the_whole_pulse(duty: float, substeps: int) -> None:
    edges = pulse_edges(duty, 0.0, 0.0)
    shares = [on_share(edges, index / substeps, (index + 1) / substeps) for index in range(substeps)]
    assert sum(shares) / substeps == pytest.approx(duty, abs=1e-12)


@pytest.mark.parametrize(("current_a", "change"), [(1.0, -0.01), (-1.0, 0.01), (0.0, 0.0), (0.01, -0.005)])
def test_dead_time_shortens_the_pulse_of_an_outgoing_current(current_a: float, change: float) -> None:
    rise, fall = pulse_edges(0.4, current_sign(current_a), 0.01)
    assert fall - rise == pytest.approx(0.4 + change)


def test_the_bridge_gives_two_thirds_of_the_bus_with_one_leg_on(make_machine: MakeMachine) -> None:
    plant = make_machine()[1]
    assert bridge_voltage(plant, 1.0, 0.0, 0.0) == pytest.approx((360.0, 0.0))
    assert bridge_voltage(plant, 1.0, 1.0, 1.0) == pytest.approx((0.0, 0.0))
    assert bridge_voltage(plant, 0.0, 1.0, 0.0) == pytest.approx((-180.0, 311.769), abs=1e-3)


def test_the_diodes_oppose_the_current_with_at_most_half_the_bus(make_machine: MakeMachine) -> None:
    assert diode_voltage(make_machine()[1], (2.0, -0.01)) == pytest.approx((-270.0, 20.0))
