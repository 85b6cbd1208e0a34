"""What a discrepancy analysis found, in plain sentences for a terminal."""

from collections.abc import Iterator

from discrepancy.model.schema import Quantity
from discrepancy.result import GapResult, ResultStep
from server.services.discrepancy import GapAnalysis

OPENINGS = {
    "none": "nothing material is missing; the recalibrated model explains the test record down to its noise",
    "named": "effects are missing, and with them nothing material is left",
    "unknown": "something is missing that no effect of the catalogue explains",
}


def describe_gap(analysis: GapAnalysis) -> Iterator[str]:
    """Yield the answer line by line: verdict, effects, parameters, figures, what is left open."""
    result = analysis.result
    yield f"verdict: {result.verdict}: {OPENINGS[result.verdict]}"
    yield from _effects(result)
    yield from _unknown(result)
    for change in result.parameter_changes:
        yield (
            f"  nameplate: {change.parameter} {change.nameplate:.4g} is really "
            f"{change.estimate:.4g} ± {change.std:.1g}"
        )
    yield from _figures(result)
    yield from (f"note: {note}" for note in result.notes)
    experiment = result.next_experiment
    if experiment is not None:
        yield f"next experiment: {experiment['why']}"
        yield f"  {_excitation(experiment['excitation'])}, {experiment['duration_s']:g} s"
        yield f"  play it: jointscope run {analysis.experiment} --rig RIG.yaml"


def _effects(result: GapResult) -> Iterator[str]:
    known = {term.id: term.parameters for term in result.terms}
    for step in result.steps[1:]:
        name = str(step.added)
        values = ", ".join(f"{key} {_value(q)}" for key, q in known.get(name, step.parameters).items())
        yield f"  + {name}: {values}"
        if step.equivalents:
            yield f"    this data cannot tell it from: {_equivalents(step)}"


def _equivalents(step: ResultStep) -> str:
    return "; ".join(one if isinstance(one, str) else " with ".join(one) for one in step.equivalents)


def _value(quantity: Quantity) -> str:
    error = "" if quantity.std is None else f" ± {quantity.std:.1g}"
    return f"{quantity.value:.4g}{error} {quantity.unit}".rstrip()


def _unknown(result: GapResult) -> Iterator[str]:
    where = result.unknown
    if where is not None:
        yield (
            f"  left over: a {where.port.value} error over {where.driver}, "
            f"which predicts {where.share:.0%} of it (its shape is in the report)"
        )


def _figures(result: GapResult) -> Iterator[str]:
    floors = ", ".join(f"{name} {value:.3g}" for name, value in result.noise_floor.items())
    if result.gap_closed is None:
        yield f"gap on test data: {result.gap_before:.2%} of the signal; noise floor: {floors}"
        return
    yield (
        f"gap on test data: {result.gap_before:.2%} of the signal before, {result.gap_after:.2%} after: "
        f"{result.gap_closed:.1%} closed; noise floor: {floors}"
    )


def _excitation(excitation: dict[str, object]) -> str:
    settings = ", ".join(f"{key} {value}" for key, value in excitation.items() if key != "kind")
    return f"{excitation['kind']}: {settings}"
