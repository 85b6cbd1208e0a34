"""Numbers and sentences as people read them."""

from collections.abc import Callable
from dataclasses import replace

import pytest

from discrepancy.design.detectable import STRENGTH
from discrepancy.effects.table import EFFECTS
from discrepancy.evaluate import Score
from discrepancy.report import numbers, sentences
from discrepancy.report.first_screen import first_screen
from discrepancy.report.plain import PLAIN, called
from discrepancy.report.views import VIEWS, Signal
from discrepancy.result import GapResult

Answer = Callable[[str], GapResult]


@pytest.mark.parametrize(
    ("value", "std", "text"),
    [
        (0.149871, 0.00041, "0.1499 ± 0.0004"),
        (0.149871, 0.00014, "0.14987 ± 0.00014"),
        (1234.5, 56.0, "1230 ± 60"),
        (2.5e-9, 1e-10, "2.5e-09 ± 1e-10"),
        (0.9, None, "0.9000"),
    ],
)
def test_the_error_sets_the_digits(value: float, std: float | None, text: str) -> None:
    assert numbers.with_error(value, std) == text


@pytest.mark.parametrize(
    ("share", "text"),
    [(0.0, "0.00 %"), (5e-5, "less than 0.01 %"), (0.0188, "1.88 %"), (0.9999, "more than 99.9 %"), (0.5, "50.0 %")],
)  # fmt: skip
def test_shares_are_never_rounded_to_a_flattering_end(share: float, text: str) -> None:
    assert numbers.percent(share) == text


@pytest.mark.parametrize("effect", list(EFFECTS))
def test_every_effect_has_a_name_in_words_and_a_view(effect: str) -> None:
    assert all(len(words) > 5 for words in PLAIN[effect])
    assert VIEWS[effect].x is not Signal.ONE


@pytest.mark.parametrize(("effect", "parameter"), list(STRENGTH.items()))
def test_every_strength_is_a_parameter_of_its_effect(effect: str, parameter: str) -> None:
    assert parameter in {p.name for p in EFFECTS[effect].parameters}


def test_a_gap_that_grew_is_said(answer: Answer) -> None:
    worse = replace(answer("named"), gap_after=0.3)
    assert "has grown" in str(sentences.closed_words(worse))


def test_a_floor_far_above_the_error_is_doubted(answer: Answer) -> None:
    result = answer("named")
    score = {"speed_rad_s": Score(rmse=0.004, nrmse=0.006, gap=0.0)}
    doubted = replace(result, steps=(result.steps[0], replace(result.steps[1], test=score)))
    assert list(sentences.floor_doubts(result)) == []
    assert "estimated too high" in next(sentences.floor_doubts(doubted))


def test_the_next_experiment_is_told_with_units(answer: Answer) -> None:
    plan = {
        "why": "w", "separates": ["coulomb_friction", "backlash"], "duration_s": 20.0,
        "excitation": {"kind": "sine", "amplitude_A": 0.900641, "period_s": 2.0},
    }  # fmt: skip
    words = sentences.experiment_words(replace(answer("named"), next_experiment=plan))
    assert words == (
        "sine, amplitude 0.901 A, period 2 s, for 20 s, to tell dry (Coulomb) friction from backlash apart"
    )


def test_answers_of_several_effects_are_told_as_such(answer: Answer) -> None:
    plan = {
        "why": "w", "separates": ["coulomb_friction", "load_torque_offset"], "duration_s": 2.0,
        "excitation": {"kind": "sine", "amplitude_A": 0.9},
        "answers": [["coulomb_friction"], ["coulomb_friction", "load_torque_offset"]],
    }  # fmt: skip
    words = sentences.experiment_words(replace(answer("named"), next_experiment=plan))
    alone, more = called("coulomb_friction"), called("load_torque_offset")
    assert words == f"sine, amplitude 0.9 A, for 2 s, to tell {alone} from {alone} together with {more} apart"


def test_a_look_for_hidden_effects_is_told_as_such(answer: Answer) -> None:
    plan = {
        "why": "w", "separates": ["coulomb_friction"], "duration_s": 2.0,
        "excitation": {"kind": "sine", "amplitude_A": 0.9}, "reveals": [{"effect": "coulomb_friction"}],
    }  # fmt: skip
    words = sentences.experiment_words(replace(answer("none"), next_experiment=plan))
    assert words == "sine, amplitude 0.9 A, for 2 s, to see weaker effects than these records show"


def test_other_measurements_stand_on_the_first_screen_beside_the_experiment(answer: Answer) -> None:
    other = {"separates": ["load_torque_offset", "current_sensor_offset"], "measurement": "read it <off>"}
    plan = {
        "why": "refitted to what load_torque_offset predicts", "separates": ["load_torque_offset"],
        "duration_s": 3.0, "excitation": {"kind": "sine", "amplitude_A": 0.9}, "other_measurements": [other],
    }  # fmt: skip
    asked = first_screen(replace(answer("named"), next_experiment=plan))
    assert f"Refitted to what {called('load_torque_offset')} predicts" in asked
    assert "No motion tells" in asked
    assert "read it &lt;off&gt;" in asked
    alone = first_screen(replace(answer("named"), next_experiment={**plan, "excitation": {}}))
    assert "read it &lt;off&gt;" in alone
    assert "Nothing is open" not in alone
