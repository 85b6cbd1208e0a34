"""Make a case with the second truth (`tests/discrepancy/truth`): other equations, integrator, parameters and sampling.

The true parameters are in the truth's own names and are not scored; names, gap and time are.
"""

from collections.abc import Mapping

from benchmarks.blind.conditions import CONDITIONS, Case, Training
from benchmarks.blind.emulated import Made
from benchmarks.blind.gap import rms
from benchmarks.blind.question import SPEED, Answer, Question
from tests.discrepancy.truth.cases import Case as Hidden
from tests.discrepancy.truth.cases import bare_test, make_case

NAMEPLATE_VISCOUS = 0.8


def make_second(case: Case) -> Made:
    """Make a case from its seed."""
    condition = CONDITIONS[case.condition]
    once = condition.training is Training.SINGLE or (
        condition.training is Training.DRAWN and case.seed % 2 == 1
    )
    hidden = make_case(
        (case.id,) if condition.hidden else (),
        case.seed,
        strength=condition.strength,
        rich=condition.training is not Training.SINE,
        repeats=not once,
    )
    records = {f"train{k}": columns for k, columns in enumerate(hidden.train)} | {"test0": hidden.test}
    step = float(hidden.test["time_s"][1])
    return Made(
        question=Question(model=_nameplate(hidden), step_s=step, records=records),
        answer=_answer(case, hidden),
        clean_test=hidden.clean_test,
    )


def _answer(case: Case, hidden: Hidden) -> Answer:
    noise = rms(hidden.test[SPEED] - hidden.clean_test)
    bare = bare_test(hidden)
    gap = rms(hidden.clean_test - bare) / noise if hidden.hidden else 0.0
    plain: Mapping[str, Mapping[str, float]] = hidden.joint.hidden
    return Answer(
        condition=case.condition,
        id=case.id,
        seed=case.seed,
        hidden=list(hidden.hidden),
        scenario=[{"id": name, "parameters": dict(values)} for name, values in plain.items()],
        gap=dict.fromkeys(hidden.hidden, gap),
        gap_total=gap,
        noise_rms=noise,
        notes={"step_s": float(hidden.test["time_s"][1])},
    )


def _nameplate(hidden: Hidden) -> dict[str, object]:
    return {
        "name": "second truth",
        "axis": "rotary",
        "input": "current_A",
        "outputs": [SPEED],
        "parameters": {
            "inertia": {"value": hidden.joint.inertia, "unit": "kg m^2", "fixed": True},
            "viscous_friction": {"value": NAMEPLATE_VISCOUS, "unit": "N m s/rad"},
            "torque_constant": {"value": 1.0, "unit": "N m/A"},
        },
    }
