"""The answer: verdict, steps, figures; as Python objects and as `gap.json`."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from discrepancy.evaluate import Curve, Score
from discrepancy.locate import Place
from discrepancy.model.reader import quantity_to_dict
from discrepancy.model.schema import EffectTerm, JointModel, Quantity
from discrepancy.report.pictures import LawPicture, Pictures
from discrepancy.search.same import Equivalent

SCHEMA = "jointscope.gap/1"


@dataclass(frozen=True, slots=True, kw_only=True)
class ParameterChange:
    """A nameplate value that the data correct."""

    parameter: str
    nameplate: float
    estimate: float
    std: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ResultStep:
    """One accepted model with its figures.

    Attributes:
        added: effect that made it, None for the recalibrated base.
        where: where the model before it disagreed.
        evidence: numbers behind the decision.
        curves: test curves for the report.
        base: the joint's own parameters as fitted at this step, by name.
        terms: the effects of this step's model with their values, by id.
        places: every place that was looked at, largest share first; `where` holds the first few.
        law: the newest effect's law over what the model without it leaves, None for the base.
    """

    added: str | None
    parameters: Mapping[str, Quantity]
    equivalents: tuple[Equivalent, ...]
    where: tuple[Place, ...]
    evidence: Mapping[str, float | int | str]
    train: Mapping[str, Score]
    test: Mapping[str, Score]
    curves: tuple[Curve, ...] = ()
    base: Mapping[str, Quantity] = field(default_factory=dict)
    terms: Mapping[str, Mapping[str, Quantity]] = field(default_factory=dict)
    places: tuple[Place, ...] = ()
    law: LawPicture | None = None

    def to_dict(self) -> dict[str, Any]:
        """Return the entry of `steps` in `gap.json`."""
        return {
            "added": self.added,
            "parameters": {name: quantity_to_dict(q) for name, q in self.parameters.items()},
            "base_parameters": {name: quantity_to_dict(q) for name, q in self.base.items()},
            "equivalents": [e if isinstance(e, str) else list(e) for e in self.equivalents],
            "where": [place.to_dict() for place in self.where],
            "evidence": dict(self.evidence),
            "outputs": {
                name: {"train": self.train[name].to_dict(), "test": self.test[name].to_dict()}
                for name in self.test
            },
        }


@dataclass(frozen=True, slots=True, kw_only=True)
class NamelessTerm:
    """A curve that closes the gap without a name.

    Attributes:
        points: (variable, torque on the joint).
        gap_after: gap on test data with it.
    """

    driver: str
    points: tuple[tuple[float, float], ...]
    gap_after: float

    def to_dict(self) -> dict[str, Any]:
        """Return `unknown.spline` of `gap.json`."""
        return {
            "driver": self.driver,
            "points": [list(point) for point in self.points],
            "gap_after": self.gap_after,
            "is_a_finding": False,
        }


@dataclass(frozen=True, slots=True, kw_only=True)
class Rejected:
    """A candidate that was tried and not taken."""

    round: int
    id: str
    fall: float
    closed: float
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class GapResult:
    """What the workflow found.

    Attributes:
        model: the extended model, usable as the next model file.
        terms: the named effects with their values.
        spline: for `unknown`, a curve that closes the gap without a name, where one does.
        pictures: what the report draws beyond the steps: the measured noise, what is left, what would have been seen.
    """

    verdict: str
    effects: tuple[str, ...]
    unknown: Place | None
    parameter_changes: tuple[ParameterChange, ...]
    gap_before: float
    gap_after: float
    noise_floor: Mapping[str, float]
    steps: tuple[ResultStep, ...]
    next_experiment: Mapping[str, Any] | None
    base_model: JointModel
    model: JointModel
    rejected: tuple[Rejected, ...] = ()
    notes: tuple[str, ...] = ()
    terms: tuple[EffectTerm, ...] = field(default=())
    spline: NamelessTerm | None = None
    pictures: Pictures = field(default_factory=Pictures)

    def with_names(self, names: Mapping[str, str]) -> "GapResult":
        """Return the same answer with the workflow's labels (`test[0]`) replaced by the records' own names.

        Args:
            names: what to call a record, by label.
        """

        def named(text: str) -> str:
            for label, name in names.items():
                text = text.replace(label, name)
            return text

        steps = tuple(
            replace(step, curves=tuple(replace(c, label=named(c.label)) for c in step.curves))
            for step in self.steps
        )
        return replace(self, steps=steps, notes=tuple(named(note) for note in self.notes))

    @property
    def gap_closed(self) -> float | None:
        """Closed share of the gap on test data; None if nothing was added."""
        if self.verdict == "none" or self.gap_before <= 0.0:
            return None
        return 1.0 - self.gap_after / self.gap_before

    def to_dict(self) -> dict[str, Any]:
        """Return the content of `gap.json`."""
        unknown = self.unknown
        return {
            "schema": SCHEMA,
            "verdict": self.verdict,
            "effects": list(self.effects),
            "unknown": None
            if unknown is None
            else {
                "port": unknown.port.value,
                "driver": unknown.driver,
                "share_explained": round(unknown.share, 4),
                "shape": [list(point) for point in unknown.shape],
                "spline": None if self.spline is None else self.spline.to_dict(),
            },
            "parameter_changes": [
                {"parameter": c.parameter, "nameplate": c.nameplate, "estimate": c.estimate, "std": c.std}
                for c in self.parameter_changes
            ],
            "gap_before": self.gap_before,
            "gap_after": self.gap_after,
            "gap_closed": self.gap_closed,
            "noise_floor": dict(self.noise_floor),
            "steps": [step.to_dict() for step in self.steps],
            "next_experiment": None if self.next_experiment is None else dict(self.next_experiment),
            "rejected": [
                {
                    "round": r.round,
                    "id": r.id,
                    "held_out_gain": r.fall,
                    "closed_in_noise": r.closed,
                    "reason": r.reason,
                }
                for r in self.rejected
            ],
            "notes": list(self.notes),
        }


def total_gap(scores: Mapping[str, Score], outputs: Sequence[str]) -> float:
    """Return one number for several outputs: the rms of their gaps."""
    gaps = [scores[name].gap for name in outputs if name in scores]
    return float((sum(g * g for g in gaps) / max(1, len(gaps))) ** 0.5)
