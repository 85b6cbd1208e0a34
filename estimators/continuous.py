"""From the discrete model to the continuous one whose input is held between samples (ZOH inversion)."""

from dataclasses import dataclass

import numpy as np

from estimators.matrix_logarithm import take_logarithm
from estimators.model import DiscreteModel
from estimators.transfer_function import write_polynomial

# A pole whose angle is this close to pi (rad), or whose size is this close to 0, has no usable logarithm.
_ANGLE_MARGIN = 1e-9
_SIZE_MARGIN = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class ContinuousModel:
    """B(s) / A(s) exp(-s dead_time_s), coefficients in descending powers of s.

    Attributes:
        numerator: of s, in output unit per input unit and s^-k.
        denominator: of s, leading 1.
        dead_time_s: (delay - 1) sample times; the hold itself accounts for the first.
        poles: roots of the denominator, rad/s.
    """

    numerator: tuple[float, ...]
    denominator: tuple[float, ...]
    dead_time_s: float
    poles: tuple[complex, ...]

    @property
    def text(self) -> str:
        """One line for a reader."""
        ratio = f"({write_polynomial(self.numerator, 's')}) / ({write_polynomial(self.denominator, 's')})"
        return ratio if self.dead_time_s == 0 else f"{ratio} exp(-{self.dead_time_s:.4g} s)"


@dataclass(frozen=True, slots=True, kw_only=True)
class ContinuousRefusal:
    """There is no continuous model; `reason` says why."""

    reason: str


def convert_to_continuous(model: DiscreteModel) -> ContinuousModel | ContinuousRefusal:
    """Invert the zero-order hold by the matrix logarithm.

    With x(k+1) = F x(k) + G u(k), [[A, B], [0, 0]] = log([[F, G], [0, 1]]) / Ts (K. J. Astrom, B. Wittenmark,
    Computer-Controlled Systems, 3rd ed. 1997, section 2.3). The principal logarithm is the continuous system
    without poles beyond the Nyquist frequency. It does not exist for a pole at zero or on the negative real
    axis: no continuous system of this order, sampled with a hold, has one.
    """
    reason = _find_obstacle(model)
    if reason:
        return ContinuousRefusal(reason=reason)
    na = model.a.size
    block = np.zeros((na + 1, na + 1))
    block[0, :na] = -model.a
    block[1:na, : na - 1] = np.eye(na - 1)
    block[0, na] = block[na, na] = 1.0
    logarithm = take_logarithm(block)
    if logarithm is None:
        return ContinuousRefusal(reason="the matrix logarithm of the model is not accurate enough to be used")
    generator = logarithm / model.sample_time_s
    A, B = generator[:na, :na], generator[:na, na:]
    C = np.zeros((1, na))
    C[0, : model.b.size] = model.b
    denominator = np.real(np.poly(A))
    # det(sI - A + B C) = det(sI - A) (1 + C (sI - A)^-1 B)
    numerator = (np.real(np.poly(A - B @ C)) - denominator)[1:]
    return ContinuousModel(
        numerator=tuple(map(float, numerator)),
        denominator=tuple(map(float, denominator)),
        dead_time_s=(model.delay - 1) * model.sample_time_s,
        poles=tuple(complex(pole) for pole in np.linalg.eigvals(A)),
    )


def _find_obstacle(model: DiscreteModel) -> str:
    if not (np.all(np.isfinite(model.a)) and np.all(np.isfinite(model.b))):
        return "the model's parameters are not finite"
    if model.b.size > model.a.size:
        return (
            f"nb={model.b.size} exceeds na={model.a.size}: the input terms beyond the poles are a finite "
            "impulse response, which no continuous system of this order has"
        )
    for pole in model.poles:
        if abs(pole) < _SIZE_MARGIN:
            return f"pole at z = {pole.real:.4g}: a sampled continuous system has no pole at zero"
        if pole.real < 0 and abs(np.angle(pole)) > np.pi - _ANGLE_MARGIN:
            return (
                f"pole at z = {pole.real:.4g}, on the negative real axis: no continuous system of this "
                "order, sampled with a hold, has it; lower the order or choose another sample time"
            )
    return ""
