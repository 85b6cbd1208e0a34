"""Set up judging by torque: the fit's problem and the scoring of test records."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from discrepancy.data.series import Series
from discrepancy.evaluate import Curve, Scorer
from discrepancy.fitting.noise import sigma_or_floor
from discrepancy.fitting.problem import Noise
from discrepancy.model.schema import BASE_SLOTS, JointModel
from discrepancy.simulation import slots as s
from discrepancy.torque.problem import Motion, TorqueProblem

FloatArray = NDArray[np.float64]


def torque_problem(model: JointModel, records: Sequence[tuple[Motion, Series]]) -> TorqueProblem:
    """Return the inverse-dynamics problem of some records."""
    first = records[0][1].channels[0]
    constant = [q.value for name, q in model.parameters.items() if BASE_SLOTS[name] == s.TORQUE_CONSTANT]
    return TorqueProblem(
        series=tuple(one for _, one in records),
        motions=tuple(motion for motion, _ in records),
        noise=Noise(sigma={first.name: sigma_or_floor(0.01 * float(np.std(first.values)), first.values)}),
        nominal=constant[0] if constant else 1.0,
    )


def torque_scorer(
    model: JointModel, train: Sequence[tuple[Motion, Series]], test: Sequence[tuple[Motion, Series]]
) -> Scorer:
    """Return what computes measured and needed torque of the training and test records."""

    def curves(records: Sequence[tuple[Motion, Series]], vector: FloatArray) -> list[Curve]:
        problem = torque_problem(model, records)
        outputs = problem.simulate(vector, problem.initial_starts())
        return [
            Curve(
                label=one.label, name=one.channels[0].name, time_s=one.time_s, measured=one.channels[0].values,
                simulated=output[one.channels[0].row], weight=one.channels[0].weight,
            )
            for one, output in zip(problem.series, outputs, strict=True)
        ]  # fmt: skip

    return Scorer(train=lambda vector: curves(train, vector), test=lambda vector: curves(test, vector))
