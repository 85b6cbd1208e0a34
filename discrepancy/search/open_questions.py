"""What the search leaves open, and the experiment, or the other measurement, that would settle it."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from discrepancy.design.excitations import RAMP_S
from discrepancy.design.limits import RigLimits, limits_of_records
from discrepancy.design.measurements import other_measurement
from discrepancy.design.prediction import Stage
from discrepancy.design.proposal import Proposal, Rival, measure, separate
from discrepancy.effects.table import EFFECTS
from discrepancy.fitting.parameters import NUISANCES, FitParameter
from discrepancy.search.finish import SearchOutcome, Step
from discrepancy.search.greedy import Round
from discrepancy.search.options import SearchOptions
from discrepancy.search.outputs import output_counts
from discrepancy.search.same import Equivalent, exact_equivalents
from discrepancy.search.standard_errors import robust_covariance

POOR_ERROR = 0.05
"""A parameter whose relative standard error is larger counts as poorly known."""
GOOD_ERROR = 0.03
"""What an experiment for a poorly known parameter aims at: coloured noise leaves more than is predicted."""
MOST_RIVALS = 3
SAFETY = 2.0
"""A predicted distance scatters by twice its root when it is measured: ask for more than the search does."""

Entry = Mapping[str, Any]  # Any: values of the JSON object `next_experiment`


@dataclass(frozen=True, slots=True, kw_only=True)
class _Question:
    """Rivals that may be told apart, and those that no motion tells apart."""

    rivals: tuple[Rival, ...]
    hopeless: tuple[Equivalent, ...]


def next_question(outcome: SearchOutcome, limits: RigLimits | None = None) -> Entry | None:
    """Return what to do next; None if nothing is open.

    Equivalents come first, then the nearest laws where the verdict is `unknown`,
    then poorly known parameters, then richer laws that the data leave room for.

    Args:
        outcome: the finished search.
        limits: of the rig; None takes what the records have shown safe.
    """
    if outcome.is_torque or outcome.verdict == "none":
        return None
    stage = Stage(
        template=outcome.problem.series[0],
        noise=outcome.problem.noise,
        limits=limits or limits_of_records(outcome.problem.series),
    )
    questions = [_question(step, done) for step, done in _rounds(outcome)]
    measurements = _measurements(outcome, questions)
    for question in questions:
        entry = _between(stage, question.rivals, outcome)
        if entry is not None:
            return {**entry, **_others(measurements)}
        measurements += _without_answer(question)
    entry = _unnamed(stage, outcome) or _poor_parameter(stage, outcome) or _richer_law(stage, outcome)
    if entry is not None:
        return {**entry, **_others(measurements)}
    return _only_measurement(measurements)


def _rounds(outcome: SearchOutcome) -> list[tuple[Step, Round]]:
    """Return each added effect with the round that chose it."""
    rounds = {done.winner.name: done for done in outcome.rounds if done.winner is not None}
    return [(step, rounds[str(step.added)]) for step in outcome.steps[1:] if step.added in rounds]


def _question(step: Step, done: Round) -> _Question:
    """Split an effect's equivalents into those with other equations and those with the same."""
    same = set(exact_equivalents(step.state.added[: step.state.added.index(str(step.added)) + 1]))
    states = {c.name: c.state for c in done.contenders}
    names = [str(step.added), *(e for e in step.equivalents if isinstance(e, str) and e not in same)]
    rivals = tuple(Rival(name=name, state=states[name]) for name in names if name in states)
    return _Question(rivals=rivals[:MOST_RIVALS], hopeless=tuple(e for e in step.equivalents if e in same))


def _measurements(outcome: SearchOutcome, questions: Sequence[_Question]) -> list[dict[str, Any]]:
    """Return what would settle the pairs whose equations are the same."""
    found = []
    for (step, _), question in zip(_rounds(outcome), questions, strict=True):
        for rival in question.hopeless:
            rivals = [rival] if isinstance(rival, str) else list(rival)
            found.append(
                {
                    "separates": [str(step.added), *rivals],
                    "measurement": other_measurement(str(step.added), rival),
                }
            )
    return found


def _without_answer(question: _Question) -> list[dict[str, Any]]:
    """Return what would settle rivals that no admissible excitation separates."""
    names = [one.name for one in question.rivals]
    return [
        {"separates": [names[0], other], "measurement": other_measurement(names[0], other)}
        for other in names[1:]
    ]


def _needed(outcome: SearchOutcome, duration_s: float) -> float:
    """Return the distance, in noise variances of a binned sample, at which the search tells two rivals apart."""
    options, problem, context = SearchOptions(), outcome.problem, outcome.context
    visible = 0.5 * context.material(options, ())
    bins = output_counts(problem) + duration_s / problem.series[0].step
    # The output that tells them apart first suffices.
    return SAFETY * max(options.doubt, float(np.min(visible**2 * bins * context.bin_size)))


def _between(stage: Stage, rivals: Sequence[Rival], outcome: SearchOutcome) -> Entry | None:
    if len(rivals) < 2:
        return None
    proposal = separate(stage, rivals, lambda duration_s: _needed(outcome, duration_s))
    if proposal is None:
        return None
    return _entry(_apart(stage, rivals, proposal), [one.name for one in rivals], proposal)


def _apart(stage: Stage, rivals: Sequence[Rival], proposal: Proposal) -> str:
    """Return what the prediction says, in the output's own unit."""
    channel = stage.template.channels[0].name
    samples = proposal.duration_s / stage.template.step
    told = [
        f"{other.name} stays {math.sqrt(far / samples) * stage.noise.sigma[channel]:.2g} (rms of {channel}) off"
        for other, far in zip(rivals[1:], proposal.distances, strict=True)
    ]
    return f"refitted to what {rivals[0].name} predicts here, {', '.join(told)}"


def _unnamed(stage: Stage, outcome: SearchOutcome) -> Entry | None:
    """Ask about the nearest laws of the first round whose winner did not last, where something is left unnamed."""
    if outcome.unknown is None:
        return None
    kept = {step.added for step in outcome.steps}
    lost = [done for done in outcome.rounds if done.winner is None or done.winner.name not in kept]
    for done in lost[:1]:
        helping = [one for one in done.contenders if one.fall > SearchOptions().alarm][:MOST_RIVALS]
        return _between(stage, [Rival(name=one.name, state=one.state) for one in helping], outcome)
    return None


def _poor_parameter(stage: Stage, outcome: SearchOutcome) -> Entry | None:
    last = outcome.steps[-1].state
    # What only the making of the recordings leaves open no motion settles.
    covariance = robust_covariance(outcome.problem, last.fit, NUISANCES)
    for i, parameter in enumerate(last.fit.parameters):
        value = abs(float(last.fit.vector[parameter.slot]))
        if _at_bound(parameter, float(last.fit.vector[parameter.slot])):
            continue  # a shape at the end of its range has nothing to be measured
        if parameter.owner in last.added and covariance[i, i] > (POOR_ERROR * value) ** 2:
            proposal = measure(stage, last, parameter.owner, GOOD_ERROR)
            if proposal is None:
                continue
            known = math.sqrt(covariance[i, i]) / max(value, 1e-12)
            why = (
                f"{parameter.name} of {parameter.owner} is known to {known:.0%} only; "
                f"this would leave {proposal.distances[0]:.1%}"
            )
            return _entry(why, [parameter.owner], proposal)
    return None


def _at_bound(parameter: FitParameter, value: float) -> bool:
    """Return whether a fitted value is pressed against an end of its range other than zero."""
    ends = [end for end in (parameter.lower, parameter.upper) if math.isfinite(end) and end != 0.0]
    return any(abs(value - end) <= 1e-6 * abs(end) for end in ends)


def _richer_law(stage: Stage, outcome: SearchOutcome) -> Entry | None:
    """Ask about laws that contain a named one, fit as well, and would differ visibly where nobody has looked yet."""
    options = SearchOptions()
    for step, done in _rounds(outcome):
        if done.winner is None or step.equivalents:
            continue
        for rival in done.contenders:
            if (
                step.added not in EFFECTS[rival.name].contains
                or done.winner.fall - rival.fall > options.doubt
            ):
                continue
            pair = (
                Rival(name=str(step.added), state=done.winner.state),
                Rival(name=rival.name, state=rival.state),
            )
            # Here the richer law is the truth that the simpler one would have to follow.
            entry = _between(stage, pair[::-1], outcome)
            if entry is not None and entry["worth"] >= 1.0:
                return entry
    return None


def _entry(why: str, separates: Sequence[str], proposal: Proposal) -> dict[str, Any]:
    return {
        "why": why,
        "separates": list(separates),
        "duration_s": proposal.duration_s,
        "excitation": {**proposal.excitation, "ramp_s": RAMP_S},
        "worth": round(proposal.worth, 3),
    }


def _others(measurements: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    return {"other_measurements": list(measurements)} if measurements else {}


def _only_measurement(measurements: Sequence[Mapping[str, Any]]) -> Entry | None:
    """Return the answer where no excitation helps: another sensor or load would."""
    if not measurements:
        return None
    names = list(dict.fromkeys(name for one in measurements for name in one["separates"]))
    return {
        "why": "no current that this rig may be sent tells them apart: another measurement would",
        "separates": names,
        "excitation": {},
        "other_measurements": list(measurements),
    }
