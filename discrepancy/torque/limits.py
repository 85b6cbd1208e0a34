"""Limits of judging by torque: how the motion is filtered, and how exact a torque balance is expected to be.

Each stands in the middle of the range in which halves of the training records get the same names from both halves:
`benchmarks/real_data.py` varies each of them without opening a test record, docs/real_data.md holds its table.
"""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class TorqueLimits:
    """How a torque balance is made and judged.

    Attributes:
        material_rms: least relative fall of the rms error that an effect must bring. A torque balance has no noise
            floor to be judged in, so the rule of later rounds with a known floor is taken: half of what is left (rms)
            must be closed, 1 - sqrt(1 - 0.5^2).
        form_error: a law that contains a simpler one must close more than that by this part of it. What differs
            between two laws of friction lies at speeds where filtered accelerations are least known.
        rest_share: below this part of the largest speed a joint counts as resting: what friction does there the
            motion does not tell.
        differentiation_factor: edge of the filter that the motion passes before it is differentiated, in units of the
            edge that measured and computed torque share.
        band_factor: that shared edge in units of the frequency below which 95 % of the speed's power lies. Reversals
            make the torque much wider than the motion (a square wave of friction has harmonics falling with 1/n).
    """

    material_rms: float = 0.134
    form_error: float = 0.15
    rest_share: float = 0.05
    differentiation_factor: float = 3.0
    band_factor: float = 16.0
