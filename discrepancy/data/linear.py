"""The bare linear joint over a record, J dw/dt = K i - B w: fast, and enough to judge units and identifiability."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from discrepancy.data.series import Series
from discrepancy.model.schema import BASE_SLOTS, JointModel
from discrepancy.simulation import slots as s

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class LinearJoint:
    """Nameplate values in SI; `names` tells what the model file calls each."""

    inertia: float
    viscous: float
    constant: float
    names: Mapping[str, str]

    @property
    def time_constant_s(self) -> float:
        """Time in which the speed follows the current."""
        return self.inertia / max(self.viscous, 1e-300)


def linear_joint(model: JointModel) -> LinearJoint:
    """Return the linear part of a model."""
    fields = {s.INERTIA: "inertia", s.VISCOUS: "viscous", s.TORQUE_CONSTANT: "constant"}
    names = {fields[BASE_SLOTS[name]]: name for name in model.parameters}
    values = {field: model.parameters[name].value for field, name in names.items()}
    return LinearJoint(
        inertia=values["inertia"],
        viscous=values.get("viscous", 0.0),
        constant=values.get("constant", 1.0),
        names=names,
    )


def linear_speed(series: Series, joint: LinearJoint) -> FloatArray:
    """Return the speed from rest at the start of each window, for an input held over each step, shape (n,)."""
    rate, step = joint.viscous / joint.inertia, series.step
    pole = np.exp(-rate * step)
    # Also for rate -> 0, where it is the step itself.
    weight = -np.expm1(-rate * step) / rate if rate * step > 1e-12 else step
    gain = joint.constant / joint.inertia * weight
    parts = [lfilter([0.0, gain], [1.0, -pole], series.input[a:b]) for a, b in series.edges]
    return np.concatenate(parts)


def start_decay(series: Series, joint: LinearJoint) -> FloatArray:
    """Return what a starting speed of 1 leaves in each window, shape (windows, n)."""
    rate = joint.viscous / joint.inertia
    found = np.zeros((len(series.edges), series.n))
    for row, (a, b) in zip(found, series.edges, strict=True):
        row[a:b] = np.exp(-rate * (series.time_s[a:b] - series.time_s[a]))
    return found
