"""Where a torque balance fails, asked beside the joint's own parameters.

In a narrow band of motion an inertia takes the place of a weight (both follow the angle of a swinging arm), so the
residual of the fitted balance is no curve over the angle any more though the weight is all that is missing. Here a
curve over each variable is fitted together with the joint's own parameters, and counts for what it predicts on held-out
blocks beyond these alone.
"""

from collections.abc import Mapping

import numpy as np

from discrepancy.data.ranges import measured_speed
from discrepancy.effects.spec import Port
from discrepancy.fitting.problem import SimulationProblem
from discrepancy.locate import Place, hat_basis, predicted_share, region_of, spread_knots
from discrepancy.search.noise import residual_parts
from discrepancy.search.state import State


def locate_beside(problem: SimulationProblem, state: State, names: Mapping[str, str]) -> Place:
    """Return the variable over which a curve explains most of what a torque balance leaves.

    Args:
        problem: a torque balance.
        state: the model, with the Jacobian of its fit.
        names: column names of `speed` and `position`.
    """
    target = -np.concatenate([record[0] for record in residual_parts(problem, state)])
    counts = np.concatenate([one.channels[0].weight for one in problem.series]) > 0
    own = state.fit.jacobian / np.maximum(np.linalg.norm(state.fit.jacobian, axis=0), 1e-300)
    own = own * np.linalg.norm(target)
    alone = predicted_share(own[counts], target[counts])[0]
    drivers = {
        "speed": np.concatenate([measured_speed(one) for one in problem.series]),
        "position": np.concatenate([one.angle for one in problem.series]),
    }
    found = []
    for key, values in drivers.items():
        x = values[counts]
        knots = spread_knots(x)
        hats = hat_basis(x, knots)
        basis = np.concatenate([hats, own[counts]], axis=1)
        share, coefficients = predicted_share(basis, target[counts])
        curve = coefficients[: knots.size]
        found.append(
            Place(
                port=Port.TORQUE, driver=names.get(key, key), region=region_of(x, (hats @ curve) ** 2),
                share=max(0.0, 1.0 - (1.0 - share) / max(1.0 - alone, 1e-12)),
                shape=tuple((float(a), float(b)) for a, b in zip(knots, curve, strict=True)),
            )
        )  # fmt: skip
    return max(found, key=lambda place: place.share)
