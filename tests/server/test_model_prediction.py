"""Travel and speed predicted by a joint model's simulation, in the nameplate's place."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from daq.excitation.check import Nameplate, StartCondition, predict_excitation
from daq.excitation.spec import Sine
from discrepancy.model.reader import parse_model
from server.errors import InputError
from server.services.limits import rig_limits
from server.services.loading import RunChoices, load_plan
from server.services.model_prediction import ModelPredictor

CONFIG = Path(__file__).resolve().parents[2] / "config"
PARAMETERS = {"inertia": 0.5, "viscous_friction": 0.9, "torque_constant": 1.0}
PLATE = Nameplate(inertia_kg_m2=0.5, viscous_friction_nm_s_rad=0.9, torque_constant_nm_a=1.0)
PULL = Sine(amplitude_a=0.5, period_s=20.0, duration_s=120.0)
RECORD = (
    "  - record:\n      name: a\n      duration_s: 60\n"
    "      excitation: {kind: sine, amplitude_A: 0.5, period_s: 20, ramp_s: 1}\n"
)


def predictor(*effects: dict[str, object]) -> ModelPredictor:
    return ModelPredictor(model=parse_model({"parameters": PARAMETERS, "effects": list(effects)}))


FRICTION: dict[str, object] = {"id": "coulomb_friction", "parameters": {"level": 0.15}}


@pytest.fixture
def limits(campaign_file: Callable[[str], Path]) -> object:
    """Return the emulated rig's limits."""
    return rig_limits(load_plan(RunChoices(campaign=campaign_file(RECORD))).rig)


@pytest.mark.parametrize("gain", [0.0, 0.01])
@pytest.mark.parametrize("position", [0.0, 4.0])
def test_without_effects_the_simulation_says_what_the_nameplate_says(
    gain: float, position: float, limits: object
) -> None:
    start = StartCondition(position_rad=position, centring_gain_a_rad=gain)
    reports = [predict_excitation(PULL, limits, joint, start) for joint in (PLATE, predictor())]  # type: ignore[arg-type]  # fixture
    # Both are exact but for a shift of one step of 4 ms and the course of the current within it.
    for name in ("peak_speed_rad_s", "position_min_rad", "position_max_rad", "peak_current_a"):
        assert getattr(reports[1], name) == pytest.approx(getattr(reports[0], name), rel=2e-3, abs=5e-3)


@pytest.mark.parametrize("gain", [0.0, 0.01])
def test_dry_friction_shortens_the_travel(gain: float, limits: object) -> None:
    start = StartCondition(centring_gain_a_rad=gain)
    bare, rough = (predict_excitation(PULL, limits, predictor(*e), start) for e in ((), (FRICTION,)))  # type: ignore[arg-type]
    # At this period the joint is slow: friction of 0.15 N m takes about 0.15 / 0.5 of the torque at its peak.
    assert rough.peak_speed_rad_s == pytest.approx(0.7 * bare.peak_speed_rad_s, rel=0.05)
    assert rough.position_max_rad < 0.8 * bare.position_max_rad


def test_the_centring_loop_feeds_back_the_simulated_position() -> None:
    """The low-pass of the position that comes back must be that of the position that comes out."""
    time = np.arange(30_000) * 4e-3
    start = StartCondition(position_rad=3.0, centring_gain_a_rad=0.01)
    centring, _, position = predictor(FRICTION).predict_motion(
        0.5 * np.sin(2 * np.pi * time / 20.0), start, 4e-3
    )
    slow, rate = 3.0, 2 * np.pi * 0.005
    for k, theta in enumerate(position):
        slow += rate * 4e-3 * (theta - slow)
        # 0.01 rad is where the rounds end; times the gain of 0.01 A/rad, and as much for Euler's steps.
        assert abs(centring[k] + 0.01 * slow) < 2e-4


def test_sensor_errors_move_nothing() -> None:
    gain: dict[str, object] = {"id": "current_sensor_offset", "parameters": {"offset": 0.2}}
    start = StartCondition()
    current = np.full(1000, 0.3)
    plain, offset = (predictor(*e).predict_motion(current, start, 4e-3)[2] for e in ((), (gain,)))
    assert np.array_equal(plain, offset)


def rig_with(tmp_path: Path, model: str) -> Path:
    """Write the emulated rig with a model key."""
    rig = tmp_path / "rig.yaml"
    text = (CONFIG / "rigs" / "emulated.yaml").read_text().replace("../scenarios", str(CONFIG / "scenarios"))
    rig.write_text(text.replace("\nparameters: {}", f"\nmodel: {model}\nparameters: {{}}"))
    return rig


def test_a_rig_files_model_predicts_the_plan(campaign_file: Callable[[str], Path], tmp_path: Path) -> None:
    (tmp_path / "rough.yaml").write_text(
        f"parameters: {PARAMETERS}\neffects: [{{id: coulomb_friction, parameters: {{level: 0.15}}}}]\n"
    )
    campaign = campaign_file(RECORD)
    plain = load_plan(RunChoices(campaign=campaign)).steps[0].record
    rough = load_plan(RunChoices(campaign=campaign, rig=rig_with(tmp_path, "rough.yaml"))).steps[0].record
    assert plain is not None
    assert rough is not None
    assert rough.report.position_max_rad < 0.8 * plain.report.position_max_rad


@pytest.mark.parametrize(
    ("model", "message"),
    [("absent.yaml", "no such model file"), ("linear.yaml", "linear axis; the rig's travel is an angle")],
)
def test_a_model_that_cannot_predict_is_refused_before_anything_moves(
    model: str, message: str, campaign_file: Callable[[str], Path], tmp_path: Path
) -> None:
    (tmp_path / "linear.yaml").write_text("axis: linear\nparameters: {mass: 1}\n")
    with pytest.raises(InputError, match=message):
        load_plan(RunChoices(campaign=campaign_file(RECORD), rig=rig_with(tmp_path, model)))
