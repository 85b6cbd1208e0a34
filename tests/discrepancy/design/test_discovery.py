"""The experiment after `none`: it shows effects that the records so far could hide, and is not proposed for ever."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from daq.recording.recording import Recording, recording_from_columns
from discrepancy.data.series import read_series
from discrepancy.design import discovery
from discrepancy.design.campaign import campaign
from discrepancy.design.discovery import LONGEST_S, Discovery, Search, discover, search_of
from discrepancy.design.excitations import RAMP_S, waveform
from discrepancy.design.limits import RigLimits
from discrepancy.design.prediction import Stage
from discrepancy.model.schema import JointModel
from discrepancy.prepare import Prepared, prepare_simulation
from discrepancy.search.entries import revealing
from discrepancy.search.options import SearchOptions
from discrepancy.search.state import polish, scan_effect
from discrepancy.simulation import slots as s
from discrepancy.simulation.kernels.joint import simulate_record
from server.config.campaign import Campaign

LIMITS = RigLimits(amplitude=0.8, travel_low=-20.0, travel_high=20.0)
STEP_S = 4e-3
SLOW = {"kind": "sine", "amplitude_A": 0.3, "period_s": 5.0}
Words = dict[str, object]


@cache
def model() -> JointModel:
    """Return a joint without effects."""
    from discrepancy.model.reader import parse_model

    return parse_model(
        {
            "name": "joint",
            "parameters": {
                "inertia": {"value": 0.5, "unit": "kg m^2", "fixed": True},
                "viscous_friction": {"value": 0.9, "unit": "N m s/rad"},
                "torque_constant": {"value": 1.0, "unit": "N m/A"},
            },
        }
    )


def played(words: Words, duration_s: float, seed: int, level: float = 0.0) -> Recording:
    """Return a record of a joint that hides dry friction of this level, N m, with new noise of 0.01 rad/s."""
    vector = s.neutral_vector()
    vector[s.INERTIA], vector[s.VISCOUS], vector[s.COULOMB] = 0.5, 0.9, level
    current = waveform({**words, "ramp_s": RAMP_S}, duration_s, STEP_S)
    time = np.arange(current.size, dtype=np.float64) * STEP_S
    out = simulate_record(vector, time, current, np.empty(0), np.array([-1]), np.zeros((1, 2)))
    noise = np.random.default_rng(seed).normal(0.0, 0.01, current.size)
    columns = {"time_s": time, "current_A": current, "speed_rad_s": out[0] + noise, "position_rad": out[1]}
    return recording_from_columns(columns, sample_time_s=STEP_S)


def prepared(records: list[Recording]) -> Prepared:
    """Return the recalibrated joint beside records."""
    return prepare_simulation(model(), [read_series(one, model(), "train") for one in records], None)


def sought(known: Prepared, limits: RigLimits = LIMITS) -> Search:
    """Return what may be hidden from these records."""
    problem = known.problem
    stage = Stage(template=problem.series[0], noise=problem.noise, limits=limits, known=problem.series)
    rest = known.ranges, SearchOptions(), known.context
    return search_of(stage, known.state, rest, known.context.excluded)


@cache
def first_look() -> Discovery:
    """Return what is proposed after two slow sines."""
    found = discover(sought(prepared([played(SLOW, 10.0, seed) for seed in (1, 2)])))
    assert found is not None
    return found


def fall(level: float, records: list[tuple[Words, float]]) -> float:
    """Return how much better dry friction explains records in which it is hidden, in noise variances."""
    known = prepared([played(words, length, 7 + i, level) for i, (words, length) in enumerate(records)])
    named = polish(
        known.problem,
        scan_effect(known.problem, known.state, "coulomb_friction", known.ranges),
        known.ranges,
    )
    return known.state.fit.loss - named.fit.loss


def test_a_record_is_proposed_that_a_campaign_takes() -> None:
    found = first_look()
    assert found.proposal.duration_s <= LONGEST_S
    entry = revealing("to see more", found)
    Campaign.model_validate(campaign(entry))
    assert entry["separates"] == [one["effect"] for one in entry["reveals"]]
    assert all(0.0 < one["then"] / one["now"] < 1.0 for one in entry["reveals"])


def test_the_record_shows_what_the_records_so_far_hide() -> None:
    found = first_look()
    one = next(one for one in found.reveals if one.id == "coulomb_friction")
    level = 1.2 * one.then
    assert level < one.now
    options, old = SearchOptions(), [(SLOW, 10.0), (SLOW, 10.0)]
    need = options.alarm + options.per_parameter
    new = [*old, (dict(found.proposal.excitation), found.proposal.duration_s)]
    assert fall(level, old) < need < fall(level, new)


def test_what_has_been_played_is_not_worth_playing_again() -> None:
    first = first_look().proposal
    records = [played(SLOW, 10.0, seed) for seed in (1, 2)]
    again = discover(sought(prepared([*records, played(dict(first.excitation), first.duration_s, 3)])))
    assert again is None or again.proposal.worth < first.worth


@pytest.mark.parametrize(("floor", "is_proposed"), [(0.999, True), (1.001, False)])
def test_a_record_that_is_worth_less_than_the_floor_is_not_proposed(
    monkeypatch: pytest.MonkeyPatch, floor: float, is_proposed: bool
) -> None:
    monkeypatch.setattr(discovery, "LEAST_WORTH", floor * first_look().proposal.worth)
    found = discover(sought(prepared([played(SLOW, 10.0, seed) for seed in (1, 2)])))
    assert (found is not None) is is_proposed


def test_a_rig_that_takes_nothing_gets_no_proposal() -> None:
    known = prepared([played(SLOW, 10.0, seed) for seed in (1, 2)])
    assert discover(sought(known, replace(LIMITS, admits=lambda _, __: False))) is None
    assert discover(sought(known, replace(LIMITS, travel_low=-1e-3, travel_high=1e-3))) is None


@pytest.mark.parametrize("excluded", [(), ("coulomb_friction",)])
def test_effects_that_the_records_cannot_show_are_not_sought(excluded: tuple[str, ...]) -> None:
    known = prepared([played(SLOW, 10.0, 1)])
    known = replace(known, context=replace(known.context, excluded=frozenset(excluded)))
    names = {one.hidden.id for one in sought(known).sought}
    assert ("coulomb_friction" in names) == (not excluded)
