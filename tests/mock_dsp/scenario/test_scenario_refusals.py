"""A wrong scenario is refused with the field, the value and what is allowed."""

from pathlib import Path

import pytest

from mock_dsp.scenario.schema import ScenarioError, read_scenario

REFUSALS = {
    "unknown key": ("name: x\nspeed: 3\n", "speed"),
    "no name": ("seed: 3\n", "name"),
    "not a mapping": ("- name: x\n", "expected a mapping with the keys name"),
    "broken YAML": ("name: [\n", "line"),
    "unknown effect": (
        "name: x\neffects: [{id: friction}]\n",
        "'friction' is unknown; known: coulomb_friction",
    ),
    "unknown effect parameter": (
        "name: x\neffects: [{id: coulomb_friction, parameters: {torque: 1.0}}]\n",
        "no parameter 'torque'; it takes: torque_nm",
    ),
    "effect out of range": (
        "name: x\neffects: [{id: coulomb_friction, parameters: {torque_nm: 5.0}}]\n",
        "torque_nm=5.0 must lie in [0.0, 2.0] N m",
    ),
    "effect not a number": (
        "name: x\neffects: [{id: coulomb_friction, parameters: {torque_nm: .nan}}]\n",
        "torque_nm=nan must lie in",
    ),
    "parameter of an on-off effect": (
        "name: x\neffects: [{id: rectified_speed_sensor, parameters: {gain: 1.0}}]\n",
        "it takes: none",
    ),
    "effect twice": ("name: x\neffects: [{id: backlash}, {id: backlash}]\n", "backlash stands twice"),
    "unknown fault": ("name: x\nfaults: [{name: gremlins}]\n", "faults.0.name (value 'gremlins')"),
    "fault without its time": ("name: x\nfaults: [{name: reboot}]\n", "fault reboot needs at_s"),
    "fault with a surplus key": (
        "name: x\nfaults: [{name: reboot, at_s: 1.0, rate: 0.1}]\n",
        "reboot does not take rate; it takes: at_s",
    ),
    "rate above one": ("name: x\nfaults: [{name: bit_flips, rate: 2.0}]\n", "faults.0.rate (value 2.0)"),
    "negative resistance": (
        "name: x\nrig: {motor: {stator_resistance_ohm: -1.0}}\n",
        "rig.motor.stator_resistance_ohm (value -1.0)",
    ),
    "too little noise to dither": (
        "name: x\nrig: {sensors: {potentiometer_noise_lsb: 0.2}}\n",
        "must be 0 (no noise) or at least 0.5 LSB",
    ),
}


@pytest.mark.parametrize(("text", "message"), REFUSALS.values(), ids=REFUSALS.keys())
def test_a_wrong_scenario_is_refused_with_a_clear_message(text: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "scenario.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ScenarioError) as refusal:
        read_scenario(path)
    assert str(refusal.value).startswith(str(path))
    assert message in str(refusal.value)


def test_a_missing_scenario_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match="nowhere.yaml"):
        read_scenario(tmp_path / "nowhere.yaml")
