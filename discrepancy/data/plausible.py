"""Do the sizes of input and motion fit together? A unit wrong by 1000, or a sign, shows before anything is fitted."""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from discrepancy.data.linear import linear_joint, linear_speed, start_decay
from discrepancy.data.ranges import measured_speed
from discrepancy.data.series import POSITION, SPEED, TORQUE, Series
from discrepancy.errors import GapInputError
from discrepancy.model.schema import JointModel

FloatArray = NDArray[np.float64]

IN_STEP = 0.7
"""Correlation from which the motion follows what the nameplate predicts, whatever its size."""
AGAINST = -0.9
FAR_OFF = 30.0
"""No nameplate is wrong by so much: a unit is."""
ODD = 4.0
MIXED = 1.6
"""A factor this near to that of a mix-up of units suggests it; friction and a rough nameplate take the rest."""
SUSPECTS = (
    (1000.0, "mA, mm or g where A, m or kg are meant"),
    (180.0 / np.pi, "degrees where radians are meant"),
    (60.0, "per minute where per second is meant"),
    (30.0 / np.pi, "rpm where rad/s is meant"),
    (2.0 * np.pi, "turns where radians are meant"),
)


def check_sizes(series: Series, model: JointModel) -> list[str]:
    """Return a note where sizes look odd.

    Raises:
        GapInputError: the motion follows the input as predicted, but its size or sign cannot be right.
    """
    compared = _compare(series, model)
    if compared is None:
        return []
    name, predicted, seen = compared
    low, high = float(np.std(predicted)), float(np.std(seen))
    if low <= 0.0 or high <= 0.0:
        return []
    likeness = float(np.corrcoef(predicted, seen)[0, 1])
    if likeness < AGAINST:
        raise GapInputError(
            f"{series.label}: {name} moves against {model.input} (correlation {likeness:.2f} with what the nameplate "
            f"predicts): one of the two has the wrong sign; turn the sign of that column"
        )
    ratio = high / low
    factor = max(ratio, 1.0 / ratio)
    if likeness < IN_STEP or factor < ODD:
        return []
    text = (
        f"{series.label}: {name} varies by {high:.3g} where the nameplate predicts {low:.3g} from {model.input}, "
        f"{_spoken(factor)} times {'more' if ratio > 1.0 else 'less'}, though in step with it (correlation "
        f"{likeness:.2f}){_suspect(factor) or '.'}"
    )
    if factor >= FAR_OFF:
        raise GapInputError(
            f"{text} A unit must be wrong: check those of {model.input}, of {name} and of the model's parameters"
        )
    return [f"{text} Check the units"]


def _compare(series: Series, model: JointModel) -> tuple[str, FloatArray, FloatArray] | None:
    """Return a name, what the nameplate predicts and what was measured, without what a starting speed explains."""
    joint = linear_joint(model)
    if series.channels[0].row == TORQUE:
        width = 2.0
        speed = np.gradient(gaussian_filter1d(series.angle, width), series.time_s)
        needed = joint.inertia * np.gradient(speed, series.time_s) + joint.viscous * speed
        torque = series.channels[0]
        keep = torque.weight > 0
        return f"the torque from {model.input}", needed[keep], torque.values[keep]
    followed = [channel for channel in series.channels if channel.row in (SPEED, POSITION)]
    if not followed:
        return None
    basis = np.vstack([start_decay(series, joint), np.ones(series.n)]).T if len(series.edges) < 20 else None
    predicted, seen = linear_speed(series, joint), measured_speed(series)
    if basis is not None:
        both = np.stack([predicted, seen], axis=1)
        predicted, seen = (both - basis @ np.linalg.lstsq(basis, both, rcond=None)[0]).T
    return f"the speed in {followed[0].name}", predicted, seen


def _spoken(factor: float) -> str:
    return f"{factor:.0f}" if factor >= 20.0 else f"{factor:.1f}"


def _suspect(factor: float) -> str:
    """Return the mix-up of units that makes about this factor, where there is one."""
    size, words = min(SUSPECTS, key=lambda suspect: abs(np.log(factor / suspect[0])))
    return f": {words}?" if 1.0 / MIXED < factor / size < MIXED else ""
