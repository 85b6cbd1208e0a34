"""Sealed scenarios: decided by the seed, told to nobody."""

import json
from collections import Counter
from pathlib import Path

import pytest

from mock_dsp.scenario.effects import EFFECTS
from mock_dsp.scenario.sealed import draw_sealed, write_answer


def test_the_seed_decides_everything() -> None:
    assert draw_sealed(7) == draw_sealed(7)
    assert draw_sealed(7) != draw_sealed(8)


def test_the_answer_lists_what_the_scenario_hides() -> None:
    scenario, answer = draw_sealed(12)
    assert scenario.sealed
    assert answer == {
        "schema": "jointscope.sealed/1",
        "seed": 12,
        "effects": [
            {"id": effect.id, "parameters": effect.complete_parameters} for effect in scenario.effects
        ],
    }


def test_many_draws_reach_every_effect_and_every_number_of_effects() -> None:
    drawn = [draw_sealed(seed)[0].effects for seed in range(1500)]
    assert {effect.id for effects in drawn for effect in effects} == set(EFFECTS)
    shares = Counter(len(effects) for effects in drawn)
    # 0.1, 0.7 and 0.2 of 1500: five standard deviations are 58, 89 and 77.
    assert abs(shares[0] - 150) < 58
    assert abs(shares[1] - 1050) < 89
    assert abs(shares[2] - 300) < 77


def test_a_sealed_scenario_does_not_give_itself_away(capfd: pytest.CaptureFixture[str]) -> None:
    hidden = [draw_sealed(seed)[0] for seed in range(40)]
    shown = "".join(f"{scenario!r}{scenario}" for scenario in hidden)
    captured = capfd.readouterr()
    assert captured.out + captured.err == ""
    assert not [effect_id for effect_id in EFFECTS if effect_id in shown]


def test_the_answer_is_written_once(tmp_path: Path) -> None:
    path = tmp_path / "answer.json"
    answer = draw_sealed(5)[1]
    write_answer(answer, path)
    assert json.loads(path.read_text(encoding="utf-8")) == answer
    with pytest.raises(FileExistsError):
        write_answer(answer, path)
