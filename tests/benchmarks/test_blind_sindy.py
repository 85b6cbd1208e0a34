"""The rival: it finds a static law in its own balance, and nothing where nothing is."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.blind.gap import Linear
from benchmarks.blind.question import Question

pytest.importorskip("pysindy", reason="the extra `bench` is not installed")

from benchmarks.blind.sindy import SETTINGS, sparse_laws, verdict_of
from benchmarks.blind.sindy_library import balance

NOTHING_HELD: frozenset[str] = frozenset()


def question(offset_nm: float, noise: float) -> Question:
    """Return a linear joint with a constant torque and white speed noise."""
    rng = np.random.default_rng(7)
    time = np.arange(15_000) * 2e-3
    current = 0.5 * np.sin(1.3 * time) + 0.4 * np.sin(7.0 * time + 1.0) + 0.3 * np.sin(0.4 * time)
    joint = Linear(inertia=0.5, viscous=0.9, constant=1.0, step_s=2e-3)
    speed = joint.respond(current - offset_nm)
    columns = {
        "time_s": time,
        "current_A": current,
        "position_rad": np.cumsum(speed) * 2e-3,
        "speed_rad_s": speed + noise * rng.standard_normal(time.size),
    }
    parameters = {
        "inertia": {"value": 0.5},
        "torque_constant": {"value": 1.0},
        "viscous_friction": {"value": 0.9},
    }
    model = {"input": "current_A", "parameters": parameters}
    return Question(model=model, step_s=2e-3, records={"train0": columns, "test0": columns})


def test_a_constant_torque_is_named() -> None:
    asked = question(0.05, 1e-3)
    data = balance(asked, SETTINGS.window_s)
    answer = verdict_of(sparse_laws(data, NOTHING_HELD, SETTINGS), SETTINGS, asked, data)
    assert (answer["verdict"], answer["effects"]) == ("named", ["load_torque_offset"])


def test_noise_alone_is_not_named() -> None:
    asked = question(0.0, 1e-2)
    data = balance(asked, SETTINGS.window_s)
    assert verdict_of(sparse_laws(data, NOTHING_HELD, SETTINGS), SETTINGS, asked, data)["verdict"] == "none"


def test_what_the_model_holds_is_not_named_again() -> None:
    data = balance(question(0.05, 1e-3), SETTINGS.window_s)
    found = sparse_laws(data, frozenset({"load_torque_offset"}), replace(SETTINGS, gate=0.0))
    assert "load_torque_offset" not in found.names
