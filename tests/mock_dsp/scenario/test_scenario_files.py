"""Every file under config/ that the emulator reads or documents says what the code does."""

from pathlib import Path

import pytest
import yaml

from mock_dsp.scenario.rig_constants import MotorConstants, RigConstants
from mock_dsp.scenario.schema import Scenario, read_scenario

CONFIG = Path(__file__).parents[3] / "config"
SCENARIOS = sorted((CONFIG / "scenarios").glob("*.yaml"))


@pytest.mark.parametrize("path", SCENARIOS, ids=lambda path: path.stem)
def test_each_scenario_file_is_valid(path: Path) -> None:
    assert read_scenario(path).name


def test_the_nominal_scenario_hides_nothing() -> None:
    nominal = read_scenario(CONFIG / "scenarios" / "nominal.yaml")
    assert nominal == Scenario(name="nominal")


def test_the_rig_file_documents_the_physics_in_use() -> None:
    rig = yaml.safe_load((CONFIG / "rigs" / "emulated.yaml").read_text(encoding="utf-8"))
    assert RigConstants.model_validate(rig["physics"]) == RigConstants()


def test_the_motor_file_documents_the_motor_in_use() -> None:
    motor = yaml.safe_load((CONFIG / "motors" / "joint1.yaml").read_text(encoding="utf-8"))
    assert MotorConstants.model_validate(motor["parameters"]) == MotorConstants()


def test_the_nameplate_is_the_linear_rig_at_the_motor_shaft() -> None:
    nameplate = yaml.safe_load((CONFIG / "rigs" / "emulated.yaml").read_text(encoding="utf-8"))["nameplate"]
    rig = RigConstants()
    mechanics, motor = rig.mechanics, rig.motor
    ratio = mechanics.belt_ratio**2
    inertia = motor.inertia_kg_m2 + mechanics.pulley_inertia_kg_m2 + mechanics.joint_inertia_kg_m2 / ratio
    viscous = motor.viscous_friction_nm_s_rad + mechanics.pulley_viscous_friction_nm_s_rad
    viscous += mechanics.joint_viscous_friction_nm_s_rad / ratio
    assert nameplate["inertia_kg_m2"] == pytest.approx(inertia)
    assert nameplate["viscous_friction_N_m_s_rad"] == pytest.approx(viscous)
