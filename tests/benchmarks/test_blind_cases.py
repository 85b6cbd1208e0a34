"""The cases of the blind benchmark: seeds, what is hidden, true values, and how large it is in what is measured."""

from itertools import combinations

import numpy as np
import pytest

from benchmarks.blind.conditions import CONDITIONS, IDS, UNCOMBINED, Case, list_cases
from benchmarks.blind.draw import draw_case, draw_parameters, related
from benchmarks.blind.emulated import Made, make_emulated
from benchmarks.blind.gap import Linear, gap_of, rms
from benchmarks.blind.mapping import joint_figures, true_values
from benchmarks.blind.seeds import OPENED, PER_ID, SPENT_SCORING, development_seeds, scoring_seeds
from daq.recording.recording import recording_from_columns
from discrepancy.effects.table import EFFECTS as CATALOGUE
from discrepancy.model.reader import parse_model
from discrepancy.simulate import simulate_recording
from mock_dsp.scenario.effects import EFFECTS as PHYSICS
from mock_dsp.scenario.rig_constants import RigConstants
from mock_dsp.scenario.schema import Effect

# The catalogue's belt and play have less than 98 % of the inertia behind them; this rig has 99 %.
SHAFTS = {"backlash", "belt_compliance"}


def make(condition: str, effect: str) -> Made:
    return make_emulated(list_cases(condition, scoring=False, ids=(effect,), count=1)[0])


def test_no_two_sets_of_seeds_meet() -> None:
    numbers = [condition.number for condition in CONDITIONS.values()]
    ranges = [*map(development_seeds, numbers), *map(scoring_seeds, numbers), *SPENT_SCORING]
    assert all(a.stop <= b.start or b.stop <= a.start for a, b in combinations(ranges, 2))


@pytest.mark.parametrize("name", CONDITIONS)
def test_every_case_has_a_seed_and_a_key_of_its_own(name: str) -> None:
    cases = list_cases(name, scoring=True)
    assert len({case.seed for case in cases}) == len({case.key for case in cases}) == len(cases)
    assert {case.seed for case in cases} <= set(scoring_seeds(CONDITIONS[name].number))


def test_more_cases_than_seeds_are_refused() -> None:
    with pytest.raises(ValueError, match="has seeds for 100"):
        list_cases("full", scoring=False, count=101)


def test_the_ids_are_those_of_the_catalogue() -> None:
    assert set(IDS) == set(CATALOGUE)


@pytest.mark.parametrize("name", IDS)
def test_true_values_have_the_catalogues_names_and_lie_within_its_bounds(name: str) -> None:
    effect = Effect(id=name, parameters=draw_parameters(name, np.random.default_rng(1), 1.0))
    truth = true_values(effect, joint_figures(RigConstants())).parameters
    bounds = {p.name: (p.lower, p.upper) for p in CATALOGUE[name].parameters}
    assert set(truth) <= set(bounds)
    assert all(bounds[key][0] <= value <= bounds[key][1] or name in SHAFTS for key, value in truth.items())


@pytest.mark.parametrize("name", sorted(PHYSICS))
def test_a_weaker_effect_is_not_the_stronger_one(name: str) -> None:
    weak, strong = (draw_parameters(name, np.random.default_rng(3), k) for k in (0.3, 1.0))
    assert weak != strong or name == "rectified_speed_sensor"


def test_effects_hidden_together_are_no_kin() -> None:
    for seed in range(50):
        drawn = draw_case(CONDITIONS["three"], "coulomb_friction", np.random.default_rng(seed))
        names = [effect.id for effect in drawn.hidden]
        assert len(names) == 3
        assert not any(related(a, b) for a, b in combinations(names, 2))


@pytest.mark.parametrize("name", ["two", "three", "held"])
def test_an_effect_that_is_not_combined_counts_for_no_combination(name: str) -> None:
    assert {case.id for case in list_cases(name, scoring=False, count=1)} == set(IDS) - UNCOMBINED
    with pytest.raises(ValueError, match="has no id"):
        list_cases(name, scoring=False, ids=("rectified_speed_sensor",), count=1)


def test_a_seed_makes_the_same_case_again() -> None:
    one, two = (make("two", "coulomb_friction") for _ in range(2))
    assert one.answer == two.answer
    assert np.array_equal(
        one.question.records["train1"]["speed_rad_s"], two.question.records["train1"]["speed_rad_s"]
    )


def test_the_gap_of_a_constant_torque_is_its_closed_form() -> None:
    joint = Linear(inertia=0.5, viscous=0.9, constant=1.0, step_s=4e-4)
    time = np.arange(100_000) * 4e-4
    less = 0.06 / 0.9 * (1.0 - np.exp(-1.8 * time))
    current = np.sin(time)
    speed = joint.respond(current)
    gap, _ = gap_of(joint, (speed - less, speed), (current, current))
    assert gap == pytest.approx(rms(less))


def test_a_current_that_reads_too_much_has_the_gap_of_a_torque() -> None:
    joint = Linear(inertia=0.5, viscous=0.9, constant=1.0, step_s=4e-4)
    current = np.sin(np.arange(100_000) * 4e-4)
    speed = joint.respond(current)
    gap, _ = gap_of(joint, (speed, speed), (current + 0.06, current))
    assert gap == pytest.approx(0.06 / 0.9, rel=0.05)


def test_a_wrong_torque_constant_leaves_no_gap_after_recalibration() -> None:
    joint = Linear(inertia=0.5, viscous=0.9, constant=1.0, step_s=4e-4)
    current = np.sin(np.arange(100_000) * 4e-4)
    gap, left = gap_of(joint, (1.1 * joint.respond(current), joint.respond(current)), (current, current))
    assert left < 1e-6 * gap


@pytest.mark.parametrize(
    "name",
    [
        "coulomb_friction",
        "end_stop",
        "gravity_unbalance",
        "position_dependent_inertia",
        "potentiometer_nonlinearity",
        "rectified_speed_sensor",
        "stribeck_friction",
        "torque_ripple",
        "transport_delay",
    ],
)
def test_the_catalogues_law_at_the_true_values_is_the_emulators(name: str) -> None:
    made = make("full", name)
    values = {"high": 1e30, "low": -1e30} if name == "end_stop" else {}
    values |= made.answer.truth[name]
    friction = made.answer.notes["viscous_friction"]
    model = made.question.model | {
        "parameters": made.question.model["parameters"] | {"viscous_friction": {"value": friction}},
        "effects": [
            *made.question.model["effects"],
            {"id": name, "parameters": {key: {"value": value} for key, value in values.items()}},
        ],
    }
    record = recording_from_columns(made.question.records["test0"], sample_time_s=4e-4)
    simulated = simulate_recording(parse_model(model), record, "test").simulated["speed_rad_s"]
    # From 5 s on an unlucky start is forgotten. What is left: 10 Hz speed filter, Kt 0.2 % below its nameplate.
    error = rms((simulated - made.clean_test)[12_500:]) / made.answer.noise_rms
    assert error < 0.25 < made.answer.gap[name]


def test_the_question_does_not_tell_the_answer() -> None:
    made = make("full", "torque_ripple")
    assert "torque_ripple" not in repr(made.question.model) + repr(made.question.metadata)
    assert (
        Case(condition="full", id="torque_ripple", seed=5).key
        == Case(condition="full", id="backlash", seed=5).key
    )


def test_noise_of_a_quantised_case_is_rounding_only() -> None:
    made = make("null_quantised", "nothing")
    steps = np.diff(np.unique(made.question.records["test0"]["position_rad"]))
    # 12 bit over ten turns.
    assert np.allclose(steps, 20 * np.pi / 4096, rtol=1e-6)


@pytest.mark.parametrize("name", list(OPENED))
def test_scoring_begins_behind_the_cases_that_have_been_opened(name: str) -> None:
    condition, opened = CONDITIONS[name], OPENED[name]
    start = scoring_seeds(condition.number).start
    drawn = {case.seed - start for case in list_cases(name, scoring=True, count=3)}
    counted = [j for j, one in enumerate(condition.ids) if one in condition.counted]
    assert drawn == {PER_ID * j + opened + k for j in counted for k in range(3)}
