"""Seeded damage on the wire and the schedule of what happens once."""

import math

import pytest

from mock_dsp.scenario.faults import FAULTS, FaultName
from mock_dsp.scenario.schema import Fault
from mock_dsp.wire.faults import DAMAGES, TIMED, FaultPlan

TICK_HZ = 2500
OCTETS = bytes(range(256)) * 40


def damaged(fault: Fault, octets: bytes = OCTETS, tick: int = 0) -> bytes:
    return FaultPlan([fault], TICK_HZ).damage(octets, tick)


def wire_fault(name: FaultName, rate: float = 0.01, seed: int = 3) -> Fault:
    needs_size = "magnitude" in FAULTS[name].needs
    return Fault(name=name, rate=rate, seed=seed, magnitude=20.0 if needs_size else None)


# A burst is not among them: it ends with the piece of octets in which it began.
@pytest.mark.parametrize("name", [FaultName.BIT_FLIPS, FaultName.DROPPED_BYTES, FaultName.DUPLICATED_BYTES])
def test_the_same_seed_does_the_same_damage_however_the_octets_are_cut(name: FaultName) -> None:
    whole = damaged(wire_fault(name))
    plan = FaultPlan([wire_fault(name)], TICK_HZ)
    pieces = b"".join(plan.damage(OCTETS[at : at + 100], 0) for at in range(0, len(OCTETS), 100))
    assert pieces == whole != OCTETS
    assert damaged(wire_fault(name, seed=4)) != whole


@pytest.mark.parametrize("name", DAMAGES)
def test_a_rate_of_0_does_nothing(name: FaultName) -> None:
    assert damaged(wire_fault(name, rate=0.0)) == OCTETS


def test_flipped_bits_come_at_the_asked_rate_one_an_octet() -> None:
    after = damaged(wire_fault(FaultName.BIT_FLIPS))
    flips = [(a ^ b).bit_count() for a, b in zip(after, OCTETS, strict=True) if a != b]
    assert set(flips) == {1}
    # 102 expected of 10240, standard deviation 10: five of them are never left by a right generator.
    assert 52 < len(flips) < 152


@pytest.mark.parametrize(("name", "sign"), [(FaultName.DROPPED_BYTES, -1), (FaultName.DUPLICATED_BYTES, 1)])
def test_octets_are_lost_or_doubled_at_the_asked_rate(name: FaultName, sign: int) -> None:
    changed = sign * (len(damaged(wire_fault(name))) - len(OCTETS))
    assert 52 < changed < 152


def test_a_burst_replaces_a_run_and_keeps_the_length() -> None:
    fault = Fault(name=FaultName.BURSTS, rate=1e-3, magnitude=20.0, seed=1)
    after = damaged(fault, bytes(2000))
    first = next(at for at, octet in enumerate(after) if octet)
    assert len(after) == 2000
    assert any(after[first : first + 20]) and not any(after[:first])


def test_damage_keeps_to_its_time() -> None:
    fault = Fault(name=FaultName.BIT_FLIPS, rate=0.5, at_s=1.0, duration_s=2.0)
    changed = [damaged(fault, tick=tick) != OCTETS for tick in (0, 2499, 2500, 7499, 7500)]
    assert changed == [False, False, True, True, False]


def test_what_happens_once_is_sorted_and_handed_out_once() -> None:
    faults = [
        Fault(name=FaultName.REBOOT, at_s=4.0),
        Fault(name=FaultName.TICK_JUMP, at_s=2.0, magnitude=1000.0),
        Fault(name=FaultName.STALL, at_s=3.0, duration_s=0.5),
        Fault(name=FaultName.HALL_OFFSET, at_s=1.0, magnitude=0.1),
    ]
    plan = FaultPlan(faults, TICK_HZ)
    assert plan.ticks_to_next(100) == 4900
    assert [(fault.name, fault.size) for fault in plan.take_due(5000)] == [(FaultName.TICK_JUMP, 1000)]
    assert [(fault.name, fault.ticks) for fault in plan.take_due(9000)] == [(FaultName.STALL, 1250)]
    assert [fault.name for fault in plan.take_due(10_000)] == [FaultName.REBOOT]
    assert plan.ticks_to_next(10_000) == math.inf


def test_every_fault_has_somebody_who_injects_it() -> None:
    sensors = {FaultName.STUCK_SENSOR, FaultName.HALL_OFFSET, FaultName.OVER_CURRENT}
    identity = {FaultName.WRONG_DICTIONARY, FaultName.NEWER_PROTOCOL}
    assert set(FaultName) == set(DAMAGES) | TIMED | sensors | identity
