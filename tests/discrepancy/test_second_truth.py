"""The workflow against a truth written by other means: LSODA with events, other parameters, other sampling."""

import pytest

from daq.recording.recording import Recording, recording_from_columns
from discrepancy.model.reader import parse_model
from discrepancy.workflow import run_gap
from tests.discrepancy.truth.cases import make_case


def as_recording(columns: dict[str, object]) -> Recording:
    time = columns["time_s"]
    return recording_from_columns(columns, sample_time_s=float(time[1]))  # type: ignore[arg-type,index]  # arrays


@pytest.mark.slow
@pytest.mark.parametrize(
    ("hidden", "seed"),
    [("asymmetric_viscous_friction", 10), ("load_torque_offset", 203)],
)
def test_second_truth_is_named_or_declared_equivalent(hidden: str, seed: int) -> None:
    case = make_case((hidden,), seed)
    model = parse_model(
        {
            "parameters": {
                "inertia": {"value": case.joint.inertia, "fixed": True},
                "viscous_friction": 0.8,
                "torque_constant": 1.0,
            }
        }
    )
    result = run_gap(model, [as_recording(one) for one in case.train], [as_recording(case.test)])  # type: ignore[arg-type]
    assert result.verdict == "named"
    assert len(result.effects) == 1
    assert hidden in (*result.effects, *result.steps[1].equivalents)


@pytest.mark.slow
def test_second_truth_without_hidden_effect_gives_none() -> None:
    case = make_case((), 8)
    model = parse_model(
        {
            "parameters": {
                "inertia": {"value": case.joint.inertia, "fixed": True},
                "viscous_friction": 0.8,
                "torque_constant": 1,
            }
        }
    )
    result = run_gap(model, [as_recording(one) for one in case.train], [as_recording(case.test)])  # type: ignore[arg-type]
    assert (result.verdict, result.effects) == ("none", ())
