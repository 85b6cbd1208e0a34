"""The next experiment: candidates, waveforms, predictions from refitted rivals, and what else would tell."""

from dataclasses import replace

import numpy as np
import pytest

from daq.excitation.waveform import sample_reference
from discrepancy.data.series import read_series
from discrepancy.design.campaign import campaign
from discrepancy.design.excitations import RAMP_S, candidate_excitations, variations, waveform
from discrepancy.design.information import Growth, errors_left, growth_of, left_apart
from discrepancy.design.limits import RigLimits, limits_of_records
from discrepancy.design.measurements import FALLBACK, other_measurement
from discrepancy.design.prediction import Stage, beside, blank_series, predict, refitted_distance
from discrepancy.design.proposal import DURATIONS_S, Proposal, propose
from discrepancy.design.question import Question, Rival, Wanted, relative_errors
from discrepancy.fitting.levenberg import fit
from discrepancy.model.schema import JointModel
from discrepancy.prepare import Prepared, prepare_simulation
from discrepancy.search.state import polish, scan_effect
from discrepancy.simulation import slots as s
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


def asked(stage: Stage, rivals: list[Rival], needed: float) -> Proposal | None:
    """Return the experiment that puts rivals so many noise variances apart."""
    return propose(stage, Question(rivals=tuple(rivals), needed=lambda _, __: needed))


def test_a_sampling_period_that_does_not_divide_the_length_gets_a_proposal_too(prepared: Prepared) -> None:
    rivals = [fitted(prepared, "coulomb_friction"), fitted(prepared, "quadratic_drag")]
    stage = stage_of(prepared, replace(LIMITS, longest_s=DURATIONS_S[0]))
    stage = replace(stage, template=replace(stage.template, step=0.0097))
    proposal = asked(stage, rivals, 100.0)
    assert proposal is not None
    assert proposal.duration_s == DURATIONS_S[0]


def test_variations_keep_to_amplitude_and_jump() -> None:
    for one in candidate_excitations(LIMITS):
        for more in variations(one, LIMITS):
            assert np.max(np.abs(waveform(more.excitation, 4.0, 4e-3))) <= LIMITS.amplitude
            assert more.excitation != one.excitation
        assert variations(one, replace(LIMITS, jump=0.0)) == [] or one.jump == 0.0


def test_the_chosen_experiment_separates_rivals_inside_the_limits(prepared: Prepared) -> None:
    rivals = [fitted(prepared, "coulomb_friction"), fitted(prepared, "quadratic_drag")]
    stage = replace(stage_of(prepared), known=prepared.problem.series)
    proposal = asked(stage, rivals, 100.0)
    assert proposal is not None
    assert proposal.worth == 1.0
    # The two laws differ in every sample: a designed record need not be long.
    assert proposal.duration_s == DURATIONS_S[0]
    blank = blank_series(stage, proposal.excitation, proposal.duration_s)
    found = predict(stage, blank, rivals[0].state, [rivals[1].state], proposal.duration_s)
    assert found is not None
    assert np.ptp(found[0].angle) < 40.0
    assert refitted_distance(stage, found[0], rivals[1].state) > 100.0


def test_laws_with_the_same_equations_get_no_experiment(prepared: Prepared) -> None:
    rivals = [fitted(prepared, "load_torque_offset"), fitted(prepared, "current_sensor_offset")]
    assert asked(stage_of(prepared), rivals, 100.0) is None
    assert "drive switched off" in other_measurement("load_torque_offset", "current_sensor_offset")
    assert other_measurement("load_torque_offset", "torque_ripple") == FALLBACK


def test_nothing_is_proposed_that_the_rig_refuses(prepared: Prepared) -> None:
    rivals = [fitted(prepared, "coulomb_friction"), fitted(prepared, "quadratic_drag")]
    heard: list[float] = []

    def refuse(excitation: object, duration_s: float) -> bool:
        heard.append(duration_s)
        return False

    limits = replace(LIMITS, admits=refuse)
    assert asked(stage_of(prepared, limits), rivals, 100.0) is None
    assert heard


def test_an_experiment_for_a_parameter_promises_the_goal(prepared: Prepared) -> None:
    one = fitted(prepared, "coulomb_friction")
    index = next(i for i, p in enumerate(one.state.fit.parameters) if p.owner == "coulomb_friction")
    wanted = Wanted(index=index, known=0.1, goal=0.06)
    question = Question(rivals=(one,), needed=lambda _, __: 1.0, wanted=(wanted,))
    proposal = propose(stage_of(prepared), question)
    assert proposal is not None
    assert proposal.worth >= 0.95
    assert proposal.errors[0] < 0.062


def test_sums_over_a_part_of_a_record_are_those_of_a_shorter_record(prepared: Prepared) -> None:
    rival, stage = fitted(prepared, "quadratic_drag"), stage_of(prepared)
    truth = fitted(prepared, "coulomb_friction").state
    words = {"kind": "sine", "amplitude_A": 0.5, "period_s": 2.0}
    found = predict(stage, blank_series(stage, words, 8.0), truth, [rival.state], 8.0)
    assert found is not None
    done = beside(stage, found[0], rival.state)
    rows = np.array([found[0].n / 2, found[0].n, 2 * found[0].n])
    grown = growth_of(done, 1, rows)
    half = found[0].n // 2
    assert grown.normal[0] == pytest.approx(done.jacobian[:half].T @ done.jacobian[:half])
    assert grown.loss[2] == pytest.approx(2.0 * done.loss)
    # Against a linear fit of old and new data, solved as one: the prior as rows of a square root.
    prior = rival.state.fit.normal()
    root = np.linalg.cholesky(prior + 1e-9 * np.diag(np.diag(prior))).T
    rows_of = np.concatenate([root, done.jacobian])
    target = np.concatenate([np.zeros(len(root)), done.residual])
    left = target - rows_of @ np.linalg.lstsq(rows_of, target, rcond=None)[0]
    assert left_apart(prior, grown)[1] == pytest.approx(float(left @ left), rel=1e-3)


def test_predicted_errors_are_those_of_a_fit_to_both_records(prepared: Prepared) -> None:
    state, stage = fitted(prepared, "coulomb_friction").state, stage_of(prepared)
    words = {"kind": "trapezoid", "amplitude_A": 0.6, "period_s": 5.0, "rise_fraction": 0.5}
    found = predict(stage, blank_series(stage, words, 5.0), state, (), 5.0)
    assert found is not None
    grown = growth_of(beside(stage, found[0], state), 1, np.array([float(found[0].n)]))
    both = stage.problem(*prepared.problem.series, found[0])
    starts = (*state.fit.starts, np.zeros((1, 2)))
    done = fit(both, state.fit.parameters, state.fit.vector, starts, 0)
    expected = np.sqrt(np.diag(np.linalg.inv(done.normal())) / np.diag(np.linalg.inv(state.fit.normal())))
    assert errors_left(state.fit.normal(), grown)[0] == pytest.approx(expected, rel=0.05)


def test_a_part_of_a_wave_is_compared_with_the_whole_wave() -> None:
    errors = relative_errors(
        {"sine": 0.3, "cosine": 0.4, "wave_number": 2.0}, {"sine": 0.01, "wave_number": 0.1}
    )
    assert errors == pytest.approx({"sine": 0.02, "wave_number": 0.05})


def test_the_proposal_is_a_campaign_file() -> None:
    entry = {
        "why": "tells a from b", "duration_s": 10.0,
        "excitation": {"kind": "sine", "amplitude_A": 0.5, "period_s": 2.0, "ramp_s": 0.5},
    }  # fmt: skip
    step = Campaign.model_validate(campaign(entry)).steps[0]
    assert isinstance(step, RecordStep)
    assert step.duration_s == 10.0


def test_a_record_may_tell_immensely_more_than_the_records_before_it() -> None:
    grown = Growth(normal=np.diag([1e12, 1e30])[None], gradient=np.zeros((1, 2)), loss=np.zeros(1))
    left = errors_left(np.diag([1.0, 0.0]), grown)
    assert left[0, 0] == pytest.approx(1e-6, rel=1e-3)
    assert 0.0 <= left[0, 1] < 1e-6
