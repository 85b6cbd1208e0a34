"""The conditions of the blind benchmark as one literal table, and the cases that follow from it.

The ids stand here in an order of their own, which fixes the seeds; the catalogue may be sorted as it likes. Effects of
the current port are asked with the reference as the model's input (`current_ref_A`), since only a simulation that
starts there can show them; all others with the measured current (`current_A`).
"""

import hashlib
from dataclasses import dataclass
from enum import Enum

from benchmarks.blind.seeds import OPENED, PER_ID, development_seeds, scoring_seeds

IDS = (
    "asymmetric_coulomb_friction",
    "asymmetric_viscous_friction",
    "backlash",
    "belt_compliance",
    "coulomb_friction",
    "current_loop_lag",
    "current_saturation",
    "current_sensor_gain",
    "current_sensor_offset",
    "end_stop",
    "gravity_unbalance",
    "inverter_dead_time",
    "load_dependent_friction",
    "load_torque_offset",
    "position_dependent_inertia",
    "potentiometer_nonlinearity",
    "presliding_hysteresis",
    "quadratic_drag",
    "rectified_speed_sensor",
    "speed_filter_lag",
    "stribeck_friction",
    "torque_constant_drift",
    "torque_ripple",
    "torque_saturation",
    "transport_delay",
    "viscous_friction_drift",
)
CURRENT_PORT = frozenset({"current_loop_lag", "current_saturation", "inverter_dead_time", "transport_delay"})
UNCOMBINED = frozenset({"rectified_speed_sensor", "current_sensor_gain", "inverter_dead_time"})
"""Another layout of the recording, another torque constant in disguise, and what the loop takes away: each is hidden
alone, under a base model without effects."""
OUTSIDE = ("eddy_current_brake", "rotor_heating", "sticky_spot")
SECOND_OUTSIDE = ("cubic_drag", "eddy_brake", "spring")
NOTHING = ("nothing",)


class Truth(Enum):
    """Whose physics hides the effects."""

    EMULATOR = "emulator"
    SECOND = "second"


class Training(Enum):
    """What the training records are."""

    REPEATED = "rich excitation, played twice"
    SINGLE = "rich excitation, played once"
    SINE = "the paper's sine, played twice"
    DRAWN = "rich excitation, played once or twice as the seed says"


class Noise(Enum):
    """What is added to the emulator's own sensor noise."""

    OWN = "nothing"
    WHITE = "white noise on the speed"
    COLOURED = "first-order noise on the speed"
    QUANTISED = "no noise at all, quantisation only"


@dataclass(frozen=True, slots=True, kw_only=True)
class Condition:
    """One condition.

    Attributes:
        number: fixes the seeds; never reused.
        ids: what the cases are counted by: the hidden effect, or the first of several.
        hidden: how many effects are hidden at once; the further ones are drawn from the seed.
        held: whether the base model already holds another effect, with its true values.
        strength: scale of the hidden effects.
        count: cases an id when nothing else is asked for.
    """

    number: int
    ids: tuple[str, ...] = IDS
    hidden: int = 1
    held: bool = False
    strength: float = 1.0
    training: Training = Training.REPEATED
    noise: Noise = Noise.OWN
    truth: Truth = Truth.EMULATOR
    count: int = 10

    @property
    def counted(self) -> tuple[str, ...]:
        """The ids that have cases."""
        combines = self.hidden > 1 or self.held
        return tuple(one for one in self.ids if not (combines and one in UNCOMBINED))


_SECOND = Truth.SECOND
CONDITIONS: dict[str, Condition] = {
    "full": Condition(number=0),
    "third": Condition(number=1, strength=0.3),
    "tenth": Condition(number=2, strength=0.1),
    "sine": Condition(number=3, training=Training.SINE),
    "single": Condition(number=4, training=Training.SINGLE),
    "held": Condition(number=5, held=True),
    "two": Condition(number=6, hidden=2),
    "three": Condition(number=7, hidden=3),
    "null_emulator": Condition(number=8, ids=NOTHING, hidden=0, training=Training.DRAWN, count=250),
    "null_white": Condition(
        number=9, ids=NOTHING, hidden=0, training=Training.DRAWN, noise=Noise.WHITE, count=250
    ),
    "null_coloured": Condition(
        number=10, ids=NOTHING, hidden=0, training=Training.DRAWN, noise=Noise.COLOURED, count=250
    ),
    "null_quantised": Condition(
        number=11, ids=NOTHING, hidden=0, training=Training.DRAWN, noise=Noise.QUANTISED, count=250
    ),
    "outside": Condition(number=12, ids=OUTSIDE, count=20),
    "second_full": Condition(number=13, truth=_SECOND),
    "second_third": Condition(number=14, truth=_SECOND, strength=0.3),
    "second_tenth": Condition(number=15, truth=_SECOND, strength=0.1),
    "second_sine": Condition(number=16, truth=_SECOND, training=Training.SINE),
    "second_null": Condition(
        number=17, ids=NOTHING, hidden=0, training=Training.DRAWN, truth=_SECOND, count=100
    ),
    "second_outside": Condition(number=18, ids=SECOND_OUTSIDE, truth=_SECOND, count=20),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """One case: what to hide and from which seed."""

    condition: str
    id: str
    seed: int

    @property
    def key(self) -> str:
        """Name of the case's files; it does not tell what is hidden."""
        return hashlib.sha256(f"{self.condition}/{self.seed}".encode()).hexdigest()[:16]


def list_cases(
    condition: str, *, scoring: bool, ids: tuple[str, ...] | None = None, count: int | None = None
) -> list[Case]:
    """Return the cases of a condition: one of each id, then the second of each, and so on.

    Scoring begins behind the cases whose answers have been opened. Ids that are not combined with others have no cases
    where several effects are hidden or one is held; their seeds stay theirs.

    Raises:
        ValueError: an id that the condition does not have, or more cases than there are seeds.
    """
    chosen = CONDITIONS[condition]
    unknown = sorted(set(ids or ()) - set(chosen.counted))
    if unknown:
        raise ValueError(
            f"condition {condition} has no id {', '.join(unknown)}; it has {', '.join(chosen.counted)}"
        )
    number = chosen.count if count is None else count
    seeds = scoring_seeds(chosen.number) if scoring else development_seeds(chosen.number)
    most = len(seeds) if len(chosen.ids) == 1 else PER_ID
    first = OPENED.get(condition, 0) if scoring else 0
    if first + number > most:
        raise ValueError(
            f"{number} cases an id asked for, condition {condition} has seeds for {most - first}"
        )
    return [
        Case(condition=condition, id=name, seed=seeds[PER_ID * j + k])
        for k in range(first, first + number)
        for j, name in enumerate(chosen.ids)
        if name in (chosen.counted if ids is None else ids)
    ]
