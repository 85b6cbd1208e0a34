"""What a discrepancy analysis found, in plain sentences for a terminal."""

from collections.abc import Iterator

from discrepancy.report import sentences
from discrepancy.report.plain import called_together
from discrepancy.result import GapResult, ResultStep
from server.services.discrepancy import GapAnalysis


def describe_gap(analysis: GapAnalysis) -> Iterator[str]:
    """Yield the answer line by line: verdict, effects, parameters, figures, what is left open."""
    result = analysis.result
    yield f"verdict: {result.verdict}: {sentences.headline(result)}"
    yield from _effects(result)
    if result.unknown is not None:
        yield f"  without a name: {sentences.unknown_words(result.unknown)} Its shape is in the report."
    yield from (f"  nameplate: {change}" for change in sentences.change_words(result))
    yield from _figures(result)
    yield from (f"note: {note}" for note in (*result.notes, *sentences.floor_doubts(result)))
    plan = sentences.experiment_words(result)
    yield from (f"what would tell more: {line}" for line in sentences.measurement_words(result))
    if plan is not None and result.next_experiment is not None:
        yield f"next experiment: {plan} ({result.next_experiment['why']})"
        yield f"  play it: jointscope run {analysis.experiment} --rig RIG.yaml"


def _effects(result: GapResult) -> Iterator[str]:
    for step in result.steps[1:]:
        name = str(step.added)
        known = sentences.effect_values(name, result)
        values = ", ".join(f"{key} {value}" for key, value in known.items())
        yield f"  + {name}: {values}"
        if step.equivalents:
            yield f"    this data cannot tell it from: {_equivalents(step)}"


def _equivalents(step: ResultStep) -> str:
    """Return the equivalents by their ids, and in words: the ids are what model files take."""
    return "; ".join(
        f"{one if isinstance(one, str) else ' with '.join(one)} ({called_together(one)})"
        for one in step.equivalents
    )


def _figures(result: GapResult) -> Iterator[str]:
    yield from (f"test data: {line}" for line in sentences.output_figures(result))
    closed = sentences.closed_words(result)
    if closed is not None:
        yield f"  {closed}"
