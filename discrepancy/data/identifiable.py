"""Can these records tell the free nameplate parameters? If not: which, why, and which measurement would.

The bare linear joint is enough to ask: for each free parameter, how does the motion change when it is moved by 100 %
(to first order) while the other free parameters and the starting speeds make up for it as well as they can? What is
left of the change is all that a fit can hold on to.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from discrepancy.data.linear import LinearJoint, linear_joint, linear_speed, start_decay
from discrepancy.data.ranges import measured_speed
from discrepancy.data.series import SPEED, TORQUE, Series
from discrepancy.model.schema import JointModel

FloatArray = NDArray[np.float64]

LEAST_SHARE = 0.005
"""Part of the motion that a change of the parameter by 100 % must make; a model's form errors are of that size."""
WIDEST_ERROR = 0.3
"""Relative standard error from white noise alone above which a parameter is not known."""
_STEP = 1e-4
_MOST_WINDOWS = 20
_REMEDY = {
    "inertia": "record with faster changes of the current (shorter than about {time:.2g} s), or weigh it in",
    "viscous": "record longer stretches at steady speeds (several times {time:.2g} s)",
    "constant": "measure the torque at standstill, or give a known load",
}


def hold_unidentified(model: JointModel, train: Sequence[Series]) -> tuple[JointModel, list[str]]:
    """Hold free parameters that the records cannot tell at their nameplate values, the worst first.

    Returns:
        The model to fit, and a note for each parameter that is held.
    """
    notes: list[str] = []
    while True:
        found = _weakest(model, train)
        if found is None:
            return model, notes
        field, share = found
        joint = linear_joint(model)
        name = joint.names[field]
        notes.append(
            f"{name} cannot be identified from these records: moving it by 100 % changes the motion by {share:.2%} of "
            "its size once the other parameters make up for it. It is held at its nameplate value; to identify it, "
            + _REMEDY[field].format(time=min(joint.time_constant_s, 1e6))
        )
        held = replace(model.parameters[name], fixed=True)
        model = replace(model, parameters={**model.parameters, name: held})


def _weakest(model: JointModel, train: Sequence[Series]) -> tuple[str, float] | None:
    """Return the free parameter that the records tell least, and what it changes; None if all can be told."""
    joint = linear_joint(model)
    free = [field for field, name in joint.names.items() if not model.parameters[name].fixed]
    usable = [one for one in train if one.channels[0].row != TORQUE and len(one.edges) <= _MOST_WINDOWS]
    if not free or not usable:
        return None
    columns, size, noise = _sensitivities(joint, free, usable)
    shares = {}
    for k, field in enumerate(free):
        others = np.delete(columns, k, axis=1)
        left = columns[:, k] - others @ np.linalg.lstsq(others, columns[:, k], rcond=1e-10)[0]
        change = float(np.sqrt(np.mean(left**2)))
        error = noise / max(change * np.sqrt(left.size), 1e-300)
        if change < LEAST_SHARE * size or error > WIDEST_ERROR:
            shares[field] = change / size
    if not shares:
        return None
    weakest = min(shares, key=lambda field: shares[field])
    return weakest, shares[weakest]


def _sensitivities(
    joint: LinearJoint, free: Sequence[str], train: Sequence[Series]
) -> tuple[FloatArray, float, float]:
    """Return d speed / d log parameter without what starting speeds explain, the speed's size and its noise."""
    columns, sizes, noises = [], [], []
    for one in train:
        base = linear_speed(one, joint)
        speed = measured_speed(one)
        moved = [(linear_speed(one, _moved(joint, field, one, speed)) - base) / _STEP for field in free]
        both = np.stack([*moved, base], axis=1)
        starts = start_decay(one, joint).T
        both = both - starts @ np.linalg.lstsq(starts, both, rcond=None)[0]
        columns.append(both[:, :-1])
        sizes.append(np.mean(both[:, -1] ** 2))
        if one.channels[0].row == SPEED:
            scale = np.sqrt(np.mean(both[:, -1] ** 2)) / max(float(np.std(speed)), 1e-300)
            # Third differences of white noise: variance 20 times that of one sample.
            noises.append(1.4826 * float(np.median(np.abs(np.diff(speed, 3)))) / np.sqrt(20.0) * scale)
    return np.concatenate(columns), max(float(np.sqrt(np.mean(sizes))), 1e-300), max(noises, default=0.0)


def _moved(joint: LinearJoint, field: str, series: Series, speed: FloatArray) -> LinearJoint:
    """Return the joint with one number moved by a part of its size or, where that is 0, of one that would matter."""
    value = float(getattr(joint, field))
    scale = value or joint.constant * float(np.std(series.input)) / max(float(np.std(speed)), 1e-300)
    values = {"inertia": joint.inertia, "viscous": joint.viscous, "constant": joint.constant}
    values[field] += _STEP * scale
    return LinearJoint(names=joint.names, **values)
