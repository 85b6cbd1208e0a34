"""docs/emulator.md lists every effect and fault with the numbers that the code accepts."""

from pathlib import Path

import pytest

from mock_dsp.scenario.effects import EFFECTS
from mock_dsp.scenario.faults import FAULTS, FaultName

LINES = (Path(__file__).parents[3] / "docs" / "emulator.md").read_text(encoding="utf-8").splitlines()


def row_of(name: str) -> str:
    rows = [line for line in LINES if line.startswith(f"| `{name}` |")]
    assert len(rows) == 1, f"{name} needs exactly one row"
    return rows[0]


@pytest.mark.parametrize("effect_id", EFFECTS)
def test_each_effect_is_documented_with_its_ranges(effect_id: str) -> None:
    spec, row = EFFECTS[effect_id], row_of(effect_id)
    assert f"| {spec.port.value} | {spec.text} |" in row
    for parameter in spec.parameters:
        unit = "" if parameter.unit == "1" else f" {parameter.unit}"
        limits = f"{parameter.minimum:.4g} to {parameter.maximum:.4g}{unit}"
        assert f"`{parameter.name}`: {limits}, default {parameter.default:.4g}" in row


@pytest.mark.parametrize("name", FAULTS, ids=lambda name: name.value)
def test_each_fault_is_documented(name: FaultName) -> None:
    assert FAULTS[name].text in row_of(name.value)
