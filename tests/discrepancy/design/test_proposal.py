"""The next experiment: candidates, waveforms, predictions from refitted rivals, and what else would tell."""

from dataclasses import replace

import numpy as np
import pytest

from daq.excitation.waveform import sample_reference
from discrepancy.data.series import read_series
from discrepancy.design.campaign import campaign
from discrepancy.design.excitations import RAMP_S, candidate_excitations, waveform
from discrepancy.design.limits import RigLimits, limits_of_records
from discrepancy.design.measurements import FALLBACK, other_measurement
from discrepancy.design.prediction import Stage, blank_series, predict, refitted_distance, worst_error
from discrepancy.design.proposal import Rival, measure, separate
from discrepancy.model.schema import JointModel
from discrepancy.search.state import State, polish, scan_effect
from discrepancy.simulation import slots as s
from discrepancy.workflow import Prepared, prepare_simulation
from server.config.campaign import Campaign, RecordStep
from tests.discrepancy.recorder import make_recording

LIMITS = RigLimits(amplitude=0.8, travel_low=-20.0, travel_high=20.0)
STATELESS = ("sine", "trapezoid", "chirp", "staircase", "table")
"""Kinds without random phases or bits: prediction and controller must agree in every sample."""


@pytest.fixture
def prepared(nameplate: JointModel) -> Prepared:
    """Return the recalibrated base model beside a record with dry friction."""
    record = make_recording({s.COULOMB: 0.15}, 1)
    return prepare_simulation(nameplate, [read_series(record, nameplate, "train")], None)


def fitted(prepared: Prepared, name: str) -> Rival:
    """Return the base model with one effect, fitted."""
    scanned = scan_effect(prepared.problem, prepared.state, name, prepared.ranges)
    return Rival(name=name, state=polish(prepared.problem, scanned, prepared.ranges))


def stage_of(prepared: Prepared, limits: RigLimits = LIMITS) -> Stage:
    """Return where predictions are made."""
    return Stage(template=prepared.problem.series[0], noise=prepared.problem.noise, limits=limits)


def test_every_candidate_is_a_record_that_a_campaign_takes() -> None:
    for one in candidate_excitations(LIMITS):
        excitation = {**one.excitation, "ramp_s": RAMP_S}
        step = RecordStep.model_validate(
            {"step": "record", "name": "next", "duration_s": 10.0, "excitation": excitation}
        )
        step.excitation.to_spec(10.0)
        assert np.max(np.abs(waveform(excitation, 10.0, 4e-3))) <= LIMITS.amplitude


@pytest.mark.parametrize("kind", STATELESS)
def test_predicted_waveform_is_what_the_controller_plays(kind: str) -> None:
    one = next(c for c in candidate_excitations(LIMITS) if c.excitation["kind"] == kind)
    excitation = {**one.excitation, "ramp_s": RAMP_S}
    step = RecordStep.model_validate(
        {"step": "record", "name": "next", "duration_s": 10.0, "excitation": excitation}
    )
    played = sample_reference(step.excitation.to_spec(10.0), np.arange(25_000), 2500)
    # Half a tick of 0.4 ms is 0.025 A at 25 Hz and 0.76 A; where a level jumps, that tick is wrong.
    wrong = np.abs(played - waveform(excitation, 10.0, 4e-4)) > 0.03
    assert np.mean(wrong) < 1e-2


def test_sudden_steps_are_left_out_where_the_rig_bears_none() -> None:
    kinds = {c.excitation["kind"] for c in candidate_excitations(replace(LIMITS, jump=1e-3))}
    assert {"prbs", "staircase", "table"}.isdisjoint(kinds)
    assert {"sine", "trapezoid", "multisine", "chirp"} <= kinds


def test_records_bound_amplitude_and_travel(prepared: Prepared) -> None:
    series = prepared.problem.series
    limits = limits_of_records(series)
    assert limits.amplitude == pytest.approx(np.max(np.abs(series[0].input)))
    assert limits.travel_high == -limits.travel_low == pytest.approx(np.ptp(series[0].angle))


def test_the_chosen_experiment_separates_rivals_inside_the_limits(prepared: Prepared) -> None:
    rivals = [fitted(prepared, "coulomb_friction"), fitted(prepared, "quadratic_drag")]
    stage = stage_of(prepared)
    proposal = separate(stage, rivals, lambda _: 100.0)
    assert proposal is not None
    assert proposal.worth == 1.0
    blank = blank_series(stage, proposal.excitation, proposal.duration_s)
    predicted = predict(stage, blank, rivals[0].state, [rivals[1].state])
    assert predicted is not None
    assert np.ptp(predicted.angle) < 40.0
    assert refitted_distance(stage, predicted, rivals[1].state) > 100.0
    assert refitted_distance(stage, predicted, rivals[0].state) < 1.0


def test_laws_with_the_same_equations_get_no_experiment(prepared: Prepared) -> None:
    rivals = [fitted(prepared, "load_torque_offset"), fitted(prepared, "current_sensor_offset")]
    assert separate(stage_of(prepared), rivals, lambda _: 100.0) is None
    assert "drive switched off" in other_measurement("load_torque_offset", "current_sensor_offset")
    assert other_measurement("load_torque_offset", "torque_ripple") == FALLBACK


def test_nothing_is_proposed_that_the_rig_refuses(prepared: Prepared) -> None:
    rivals = [fitted(prepared, "coulomb_friction"), fitted(prepared, "quadratic_drag")]
    asked: list[float] = []

    def refuse(excitation: object, duration_s: float) -> bool:
        asked.append(duration_s)
        return False

    limits = replace(LIMITS, admits=refuse)
    assert separate(stage_of(prepared, limits), rivals, lambda _: 100.0) is None
    assert asked


def test_an_experiment_for_a_parameter_leaves_less_doubt(prepared: Prepared) -> None:
    state: State = fitted(prepared, "coulomb_friction").state
    stage = stage_of(prepared)
    before = worst_error(stage, None, state, "coulomb_friction")
    proposal = measure(stage, state, "coulomb_friction", 0.5 * before)
    assert proposal is not None
    assert proposal.distances[0] < 0.6 * before


def test_the_proposal_is_a_campaign_file() -> None:
    entry = {
        "why": "tells a from b", "duration_s": 10.0,
        "excitation": {"kind": "sine", "amplitude_A": 0.5, "period_s": 2.0, "ramp_s": 0.5},
    }  # fmt: skip
    step = Campaign.model_validate(campaign(entry)).steps[0]
    assert isinstance(step, RecordStep)
    assert step.duration_s == 10.0
