"""Quantities in YAML files: numbers, numbers with units, and what is refused."""

import pytest
from pydantic_core import PydanticCustomError

from server.config.units import SPELLINGS, parse_quantity


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        (0.4, "A", 0.4),
        (3, "s", 3.0),
        ("400 mA", "A", 0.4),
        ("0.4A", "A", 0.4),
        ("5e-4", "kg m^2", 5e-4),  # PyYAML reads this number, which has no dot, as text
        ("5e-4 kg·m²", "kg m^2", 5e-4),
        ("2 min", "s", 120.0),
        ("-1 turn", "rad", -6.283185307179586),
        ("60 rpm", "rad/s", 6.283185307179586),
    ],
)
def test_a_quantity_is_converted_to_the_unit_of_its_key(text: object, unit: str, value: float) -> None:
    assert parse_quantity(text, unit) == pytest.approx(value, rel=1e-12)


def test_a_unit_of_another_kind_is_refused_with_those_allowed() -> None:
    with pytest.raises(PydanticCustomError, match=r"'5 V' is in V; allowed here: A, mA, uA"):
        parse_quantity("5 V", "A")


@pytest.mark.parametrize("value", ["fast", True, None, [1], "1 2 3 A x"])
def test_what_is_no_number_is_refused(value: object) -> None:
    with pytest.raises(PydanticCustomError):
        parse_quantity(value, "A")


def test_each_unit_is_worth_one_of_itself() -> None:
    assert all(spellings[unit] == 1.0 for unit, spellings in SPELLINGS.items())
