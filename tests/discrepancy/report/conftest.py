"""Answers as the workflow gives them, small enough to read."""

from collections.abc import Callable

import numpy as np
import pytest

from discrepancy.effects.spec import Port
from discrepancy.evaluate import Curve, Score
from discrepancy.locate import Place
from discrepancy.model.reader import parse_model
from discrepancy.model.schema import EffectTerm, JointModel, Quantity
from discrepancy.report.pictures import Binned, Detectable, LawPicture, Pictures
from discrepancy.result import GapResult, Rejected, ResultStep

Answer = Callable[[str], GapResult]
NOISE = 0.01
PLACE = Place(
    port=Port.TORQUE, driver="speed_rad_s", region=(-0.5, 0.5), share=0.7, shape=((-1.0, -0.1), (1.0, 0.1))
)


def make_model() -> JointModel:
    """Return a joint of which one parameter is held."""
    return parse_model(
        {
            "name": "arm <1>",
            "parameters": {
                "inertia": {"value": 0.5, "unit": "kg m^2", "fixed": True},
                "viscous_friction": {"value": 0.9, "unit": "N m s/rad"},
            },
        }
    )


def make_curve(error: float) -> Curve:
    """Return 12 s of a sine at 2 ms whose simulation is off by `error` in the last third."""
    time = np.arange(6000, dtype=np.float64) * 2e-3
    measured = np.sin(time) + np.random.default_rng(0).normal(0.0, NOISE, time.size)
    simulated = np.sin(time) + error * (time > 8.0)
    return Curve(
        label="test[0]", name="speed_rad_s", time_s=time, measured=measured, simulated=simulated,
        weight=np.ones(time.size),
    )  # fmt: skip


def make_step(added: str | None, rmse: float, viscous: float) -> ResultStep:
    """Return a step with one output; friction of 0.15 N m where something was added."""
    gap = float(np.sqrt(max(0.0, rmse**2 - NOISE**2)) / 0.7)
    score = {"speed_rad_s": Score(rmse=rmse, nrmse=rmse / 0.7, gap=gap)}
    level = {"level": Quantity(value=0.15, std=0.0012, unit="N m")}
    x = np.linspace(-1.0, 1.0, 9)
    law = LawPicture(
        x_name="speed", x_unit="rad/s", y_name="load missing in the model", y_unit="N m",
        points=Binned(x=x, mean=0.15 * np.sign(x), error=np.full(9, 0.02), count=np.full(9, 50.0)),
        law_x=x, law=0.15 * np.sign(x), low=0.15 * np.sign(x) - 0.01, high=0.15 * np.sign(x) + 0.01,
    )  # fmt: skip
    return ResultStep(
        added=added, parameters=level if added else {}, equivalents=("stribeck_friction",) if added else (),
        where=(PLACE,), evidence={"held_out_gain": 5000.0, "closed_in_noise": 4.8} if added else {},
        train=score, test=score, curves=(make_curve(rmse),), places=(PLACE,), law=law if added else None,
        base={"viscous_friction": Quantity(value=viscous, std=0.0013, unit="N m s/rad")},
        terms={"coulomb_friction": level} if added else {},
    )  # fmt: skip


@pytest.fixture
def answer() -> Answer:
    """Return what makes an answer with a given verdict."""

    def make(verdict: str) -> GapResult:
        named = verdict == "named"
        base = make_step(None, 0.0103 if verdict == "none" else 0.1, 1.2)
        steps = (base, make_step("coulomb_friction", 0.009, 0.9)) if named else (base,)
        found = (EffectTerm(id="coulomb_friction", parameters=steps[-1].parameters),) if named else ()
        seen = Detectable(id="coulomb_friction", parameter="level", size=0.0042, unit="N m")
        model = make_model()
        return GapResult(
            verdict=verdict, effects=("coulomb_friction",) if named else (),
            unknown=PLACE if verdict == "unknown" else None, parameter_changes=(),
            gap_before=base.test["speed_rad_s"].gap, gap_after=steps[-1].test["speed_rad_s"].gap,
            noise_floor={"speed_rad_s": NOISE}, steps=steps, next_experiment=None, base_model=model, model=model,
            rejected=(Rejected(round=0, id="backlash", fall=-3.0, closed=1e-7, reason="no better"),),
            notes=("test[0]: 3 samples were dropped",), terms=found,
            pictures=Pictures(detectable=(seen,) if verdict == "none" else (), left=(PLACE,)),
        )  # fmt: skip

    return make
