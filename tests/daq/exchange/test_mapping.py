"""`--map`: three forms, and a clear answer to everything else."""

import math

import pytest

from daq.errors import RecordingError
from daq.exchange.mapping import ColumnMapping, parse_mapping, parse_mappings


@pytest.mark.parametrize(
    ("text", "name", "source", "factor"),
    [
        ("current_A=i", "current_A", "i", 1.0),
        ("current_A=i*0.001", "current_A", "i", 0.001),
        ("current_A = motor current * -2e-3", "current_A", "motor current", -0.002),
        ("current_A=i[mA]", "current_A", "i", 0.001),
        ("speed_rad_s=n[rpm]", "speed_rad_s", "n", 2.0 * math.pi / 60.0),
        ("position_rad=angle_deg[deg]", "position_rad", "angle_deg", math.pi / 180.0),
        ("time_s=t_ms*0.001", "time_s", "t_ms", 0.001),
        ("torque_ref_Nm=tau[mNm]", "torque_ref_Nm", "tau", 0.001),
    ],
)
def test_forms(text: str, name: str, source: str, factor: float) -> None:
    assert parse_mapping(text) == ColumnMapping(name=name, source=source, factor=factor)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("current_A", "must read NEW=OLD, NEW=OLD"),
        ("=i", "must read NEW=OLD"),
        ("current=i", r"'current' must end in one of .*_A \(A\)"),
        ("current_A=i[furlong]", r"unknown unit 'furlong'; known are .*mA.*rpm"),
        ("current_A=i[rpm]", "rpm cannot become A, only rad/s"),
        ("current_A=i*zero", "factor 'zero' must be a finite number"),
        ("current_A=i*0", "factor '0' must be a finite number other than 0"),
        ("current_A=i*inf", "factor 'inf' must be a finite number"),
        ("speed_rad_s=speed_rpm", r"'speed_rpm' seems to be in rpm, .* say speed_rad_s=speed_rpm\[rpm\]"),
        ("current_A=i_mA", r"seems to be in mA, 'current_A' is in A; say current_A=i_mA\[mA\]"),
        ("speed_rad_s=speed_m_s", r"seems to be in m/s, .* say speed_rad_s=speed_m_s\*FACTOR"),
    ],
)
def test_wrong_mapping_is_refused_with_a_remedy(text: str, message: str) -> None:
    with pytest.raises(RecordingError, match=message):
        parse_mapping(text)


def test_two_sources_for_one_column_are_refused() -> None:
    with pytest.raises(RecordingError, match="mapped more than once: current_A"):
        parse_mappings(["current_A=i", "current_A=j"])
