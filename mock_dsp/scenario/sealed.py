"""Sealed scenarios: effects and strengths drawn from a seed, for checks in which nobody may know the answer.

Nothing here prints or logs, and a sealed scenario's `repr` leaves its effects out. The answer is returned
beside the scenario, to be written once by `write_answer` and read by the check alone.
"""

import json
from pathlib import Path

import numpy as np

from mock_dsp.scenario.effects import EFFECTS
from mock_dsp.scenario.schema import Effect, Scenario

ANSWER_SCHEMA = "jointscope.sealed/1"

# Chances of 0, 1 and 2 hidden effects, and that a single one is outside the catalogue.
_COUNT_CHANCES = (0.1, 0.7, 0.2)
_UNLISTED_CHANCE = 0.15


def draw_sealed(seed: int) -> tuple[Scenario, dict[str, object]]:
    """Draw a scenario with none, one or two hidden effects.

    Args:
        seed: Decides everything: effects, strengths and sensor noise.

    Returns:
        The scenario, and the answer as JSON-ready data: schema, seed, and effects with their parameters.
    """
    generator = np.random.default_rng([seed, 0x5EA1ED])
    effects = tuple(_draw_effect(effect_id, generator) for effect_id in _draw_ids(generator))
    noise_seed = int(generator.integers(2**62))
    scenario = Scenario(name="sealed", seed=noise_seed, effects=effects, sealed=True)
    answer: dict[str, object] = {
        "schema": ANSWER_SCHEMA,
        "seed": seed,
        "effects": [effect.model_dump() for effect in effects],
    }
    return scenario, answer


def write_answer(answer: dict[str, object], path: Path) -> None:
    """Write the answer of a sealed scenario; an existing file is not overwritten.

    Raises:
        FileExistsError: `path` exists.
    """
    with path.open("x", encoding="utf-8") as file:
        json.dump(answer, file, indent=2)
        file.write("\n")


def _draw_ids(generator: np.random.Generator) -> list[str]:
    count = int(generator.choice(len(_COUNT_CHANCES), p=_COUNT_CHANCES))
    unlisted = count == 1 and generator.random() < _UNLISTED_CHANCE
    known = [effect_id for effect_id, spec in EFFECTS.items() if spec.catalogued is not unlisted]
    return [str(effect_id) for effect_id in generator.choice(known, size=count, replace=False)]


def _draw_effect(effect_id: str, generator: np.random.Generator) -> Effect:
    parameters = {
        parameter.name: float(generator.uniform(*parameter.draw))
        for parameter in EFFECTS[effect_id].parameters
    }
    return Effect(id=effect_id, parameters=parameters)
