"""What one effect of the catalogue declares about itself. No physics here: that stands in `simulation/kernels/`."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Enum


class Port(Enum):
    """Where an effect enters the joint."""

    TORQUE = "torque"
    CURRENT = "current"
    SENSOR = "sensor"


class Kind(Enum):
    """What a parameter measures; it fixes unit and natural size. Values: (rotary unit, linear unit)."""

    TORQUE = ("N m", "N")
    SPEED = ("rad/s", "m/s")
    CURRENT = ("A", "A")
    INPUT = ("A", "N")
    TIME = ("s", "s")
    ANGLE = ("rad", "m")
    WAVE = ("1/rad", "1/m")
    RATIO = ("1", "1")
    VISCOUS = ("N m s/rad", "N s/m")
    QUADRATIC = ("N m s^2/rad^2", "N s^2/m^2")
    STIFFNESS = ("N m/rad", "N/m")


@dataclass(frozen=True, slots=True, kw_only=True)
class Ranges:
    """Sizes of the signals in the training records, from which starting values follow.

    Attributes:
        torque: rms of the motor torque, N m.
        speed: largest |speed|, rad/s.
        current: largest |input|, A.
        duration: longest record, s.
        step: nominal sample time, s.
        low, high: travel, rad.
        inertia: nominal inertia, kg m^2.
        rate: viscous friction over inertia, 1/s.
        waves: wave numbers, 1/rad, at which the torque residual, the residual over acceleration, and the relative
            speed residual peak over the angle; keys `torque`, `acceleration`, `speed`.
    """

    torque: float
    speed: float
    current: float
    duration: float
    step: float
    low: float
    high: float
    inertia: float
    rate: float
    waves: Mapping[str, tuple[float, ...]] = field(default_factory=dict)


STIFFEST_RAD_S = 300.0
"""A spring that swings the joint faster than this is rigid as far as a fit can tell: it would only cost sub-steps."""


def stiffest(r: Ranges) -> float:
    """Return the stiffness, N m/rad, beyond which a spring on the whole inertia counts as rigid."""
    return r.inertia * STIFFEST_RAD_S**2


Start = Mapping[str, float]
Starts = Callable[[Ranges], list[Start]]


@dataclass(frozen=True, slots=True, kw_only=True)
class EffectParameter:
    """One parameter of an effect.

    Attributes:
        slot: place in the kernel's parameter vector (`simulation/slots.py`).
        lower, upper: bounds; the sign constraints of physics live here.
        free: False for a shape constant that only the starting grid sets.
        logarithmic: fitted as its logarithm (positive scale parameters).
        meaning: one phrase for the report and the docs.
    """

    name: str
    slot: int
    kind: Kind
    lower: float
    upper: float
    meaning: str
    free: bool = True
    logarithmic: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Effect:
    """One effect: where it enters, its equation, and how a fit starts.

    Attributes:
        driver: the variable it acts through: a recording's column, `acceleration_rad_s2`, `time_s` or `frequency`.
        second_driver: a further variable that its law cannot do without, None for a law of one variable.
        starts: starting values as functions of the signals' sizes; constants that are not free are set here.
        contains: effects that this one reproduces exactly for some values of its parameters.
        shared: parameter names that are dropped (held neutral) when the effect named there is already in the model.
        limits: bounds that follow from the signals, by parameter name; they narrow those of the parameters.
        chaotic: True if the free run is chaotic: fits start on short windows, and a wider form error is allowed.
        inverse: True if an inverse-dynamics torque balance can show the effect. Motor-side effects cannot be judged
            there:
            the measured input stands on both sides, and a motor that makes no torque would balance a joint of no mass.
    """

    id: str
    port: Port
    driver: str
    equation: str
    parameters: tuple[EffectParameter, ...]
    starts: Starts
    signature: str
    confused_with: tuple[str, ...]
    reference: str
    second_driver: str | None = None
    contains: tuple[str, ...] = ()
    shared: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    limits: Callable[[Ranges], Mapping[str, tuple[float, float]]] | None = None
    inverse: bool = True
    chaotic: bool = False

    @property
    def wave(self) -> EffectParameter | None:
        """The fitted wave number over the angle; None without one."""
        return next((p for p in self.parameters if p.kind is Kind.WAVE and p.free), None)
