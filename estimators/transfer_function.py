"""The transfer function of an identified model: polynomials in z, poles, static gain, standard errors."""

from dataclasses import dataclass

import numpy as np

from estimators.model import DiscreteModel

# A static gain whose 1 + a_1 + a_2 + ... is closer to zero than this many standard errors has no known sign.
_GAIN_MARGIN = 2.0


@dataclass(frozen=True, slots=True, kw_only=True)
class TransferFunction:
    """B(z) / A(z) in descending powers of z.

    For order 2 and delay 1 this is the paper's (b0 z + b1) / (z^2 + a1 z + a2).
    """

    numerator: tuple[float, ...]
    denominator: tuple[float, ...]
    sample_time_s: float

    @property
    def text(self) -> str:
        """One line for a reader."""
        return f"({write_polynomial(self.numerator, 'z')}) / ({write_polynomial(self.denominator, 'z')})"


@dataclass(frozen=True, slots=True, kw_only=True)
class Pole:
    """A root of the denominator.

    Attributes:
        re: real part. im: imaginary part. magnitude: distance from the origin.
        std_re: standard error of the real part; NaN for a repeated root, whose error is not linear.
        std_im: standard error of the imaginary part.
        std_magnitude: standard error of the magnitude.
    """

    re: float
    im: float
    magnitude: float
    std_re: float
    std_im: float
    std_magnitude: float


@dataclass(frozen=True, slots=True, kw_only=True)
class StaticGain:
    """Output per input at rest, (b_0 + b_1 + ...) / (1 + a_1 + a_2 + ...).

    Attributes:
        value: inf or NaN where the denominator is zero.
        std: standard error.
        determined: whether 1 + a_1 + ... differs from zero by more than its error. An (almost) integrating
            model has no static gain that the data could know.
    """

    value: float
    std: float
    determined: bool


def form_transfer_function(model: DiscreteModel) -> TransferFunction:
    """Write the model in powers of z; terms that reach past the poles give poles at zero."""
    degree = model.structure.reach
    denominator = np.zeros(degree + 1)
    denominator[: model.a.size + 1] = np.concatenate([[1.0], model.a])
    numerator = np.zeros(degree - model.delay + 1)
    numerator[: model.b.size] = model.b
    return TransferFunction(
        numerator=tuple(map(float, numerator)),
        denominator=tuple(map(float, denominator)),
        sample_time_s=model.sample_time_s,
    )


def describe_poles(model: DiscreteModel) -> tuple[Pole, ...]:
    """Return the roots of A with standard errors by linear error propagation.

    d p / d a_i = -p^(na - i) / A'(p).
    """
    na = model.a.size
    polynomial = np.concatenate([[1.0], model.a])
    covariance = model.covariance[:na, :na]
    poles = []
    for root in model.poles:
        slope = np.polyval(np.polyder(polynomial), root)
        with np.errstate(all="ignore"):  # a repeated root has slope zero; its errors become NaN
            gradient = -(root ** np.arange(na - 1, -1, -1)) / slope
            along = np.real(np.conj(root) * gradient) / abs(root)
            errors = [
                float(np.sqrt(g @ covariance @ g)) for g in (np.real(gradient), np.imag(gradient), along)
            ]
        poles.append(
            Pole(
                re=float(root.real),
                im=float(root.imag),
                magnitude=float(abs(root)),
                std_re=errors[0],
                std_im=errors[1],
                std_magnitude=errors[2],
            )
        )
    return tuple(poles)


def find_static_gain(model: DiscreteModel) -> StaticGain:
    """Return the static gain with its standard error by linear error propagation."""
    na, nb = model.a.size, model.b.size
    covariance = model.covariance[: na + nb, : na + nb]
    below, above = 1.0 + float(model.a.sum()), float(model.b.sum())
    with np.errstate(all="ignore"):
        value = float(np.divide(above, below))
        gradient = np.concatenate([np.full(na, -value), np.ones(nb)]) / below
        std = float(np.sqrt(gradient @ covariance @ gradient))
        std_below = float(np.sqrt(covariance[:na, :na].sum()))
    determined = bool(np.isfinite(value) and abs(below) > _GAIN_MARGIN * std_below)
    return StaticGain(value=value, std=std, determined=determined)


def write_polynomial(coefficients: tuple[float, ...], variable: str) -> str:
    """Write a polynomial, highest power first, with four significant digits."""
    text = ""
    degree = len(coefficients) - 1
    for power, value in zip(range(degree, -1, -1), coefficients, strict=True):
        if value == 0.0 and degree > 0:
            continue
        factor = {0: "", 1: variable}.get(power, f"{variable}^{power}")
        number = "" if abs(value) == 1.0 and power > 0 else f"{abs(value):.4g}"
        term = f"{number} {factor}".strip()
        sign = "-" if value < 0 else "+"
        text = f"{text} {sign} {term}" if text else (f"-{term}" if value < 0 else term)
    return text or "0"
