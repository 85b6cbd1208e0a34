"""What the search leaves open, and the experiment, or the other measurement, that would settle it."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from discrepancy.design.discovery import discover, search_of
from discrepancy.design.limits import RigLimits, limits_of_records
from discrepancy.design.measurements import other_measurement
from discrepancy.design.prediction import Stage
from discrepancy.design.proposal import ENOUGH, Proposal, propose
from discrepancy.design.question import (
    Quantities,
    Question,
    Rival,
    Wanted,
    known_errors,
    wanted_of,
)
from discrepancy.effects.table import EFFECTS
from discrepancy.search.choice import Contender
from discrepancy.search.entries import Entry, only_measurement, others, proposed, revealing, why_hidden
from discrepancy.search.greedy import Round
from discrepancy.search.known import GOOD_ERROR, POOR_ERROR, poorly_known
from discrepancy.search.options import SearchOptions
from discrepancy.search.outcome import SearchOutcome, Step
from discrepancy.search.outputs import output_counts
from discrepancy.search.same import Equivalent, exact_equivalents

MOST_RIVALS = 3
LEAST = 0.05
"""Below this share of what is needed by every pair, a proposal does not tell rivals apart."""
SAFETY = 2.0
"""A predicted distance scatters by twice its root when it is measured: ask for more than the search does."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Open:
    """Rivals that may be told apart, and those that no motion tells apart."""

    step: Step
    done: Round
    rivals: tuple[Contender, ...]
    hopeless: tuple[Equivalent, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class _Asker:
    """The finished search, the rig's limits, and how well each parameter of the last model is known."""

    outcome: SearchOutcome
    limits: RigLimits
    errors: Mapping[str, Mapping[str, float]]

    def stage(self, done: Round | None) -> Stage:
        """Return where predictions are made, in the noise that a round (the whole search) was judged in."""
        problem = self.outcome.problem if done is None else done.problem
        return Stage(
            template=problem.series[0], noise=problem.noise, limits=self.limits, known=problem.series
        )

    def before(self, step: Step) -> tuple[Step, ...]:
        """Return the steps that were accepted before this one."""
        names = [one.added for one in self.outcome.steps]
        return self.outcome.steps[: names.index(step.added)]

    def wanted(self, rival: Rival, owner: str) -> tuple[Wanted, ...]:
        """Return which parameters of an effect are known too poorly."""
        told, _ = poorly_known(self.outcome, rival.state, owner, self.errors.get(owner, {}))
        return wanted_of(rival.state, owner, told, (POOR_ERROR, GOOD_ERROR))


def next_question(
    outcome: SearchOutcome, limits: RigLimits | None = None, values: Quantities | None = None
) -> Entry | None:
    """Return what to do next; None if nothing is open.

    Equivalents come first, then the nearest laws where the verdict is `unknown`,
    then poorly known parameters, then richer laws that the data leave room for. Where nothing is named, or nothing
    that is named explains the rest, the question is what the records could hide.

    Args:
        outcome: the finished search.
        limits: of the rig; None takes what the records have shown safe.
        values: parameters of the last model with standard errors, by owner and name; None asks about none.
    """
    if outcome.is_torque:
        return None
    limits = limits or limits_of_records(outcome.problem.series)
    asker = _Asker(outcome=outcome, limits=limits, errors=known_errors(values or {}))
    questions = [_open(step, done) for step, done in _rounds(outcome)]
    measurements = _measurements(outcome, questions)
    for question in questions:
        entry = _equivalents(asker, question)
        if entry is not None:
            return {**entry, **others(measurements)}
        measurements += _without_answer(question)
    entry = _unnamed(asker) or _poor_parameters(asker) or _richer_law(asker) or _hidden(asker)
    if entry is not None:
        return {**entry, **others(measurements)}
    return only_measurement(measurements)


def _rounds(outcome: SearchOutcome) -> list[tuple[Step, Round]]:
    """Return each added effect with the round that chose it."""
    rounds = {done.winner.name: done for done in outcome.rounds if done.winner is not None}
    return [(step, rounds[str(step.added)]) for step in outcome.steps[1:] if step.added in rounds]


def _open(step: Step, done: Round) -> _Open:
    """Split an effect's equivalents into those with other equations and those with the same."""
    same = set(exact_equivalents(step.state.added[: step.state.added.index(str(step.added)) + 1]))
    states = {c.name: c for c in done.contenders}
    names = [str(step.added), *(e for e in step.equivalents if isinstance(e, str) and e not in same)]
    rivals = tuple(states[name] for name in names if name in states)
    hopeless = tuple(e for e in step.equivalents if e in same)
    return _Open(step=step, done=done, rivals=rivals[:MOST_RIVALS], hopeless=hopeless)


def _measurements(outcome: SearchOutcome, questions: Sequence[_Open]) -> list[dict[str, Any]]:
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


def _without_answer(question: _Open) -> list[dict[str, Any]]:
    """Return what would settle rivals that no admissible excitation separates."""
    names = [one.name for one in question.rivals]
    return [
        {"separates": [names[0], other], "measurement": other_measurement(names[0], other)}
        for other in names[1:]
    ]


def _rival(contender: Contender) -> Rival:
    return Rival(name=contender.name, state=contender.state)


def _needed(
    outcome: SearchOutcome,
    before: Sequence[Step],
    pair: tuple[Contender, Contender],
    duration_s: float,
) -> float:
    """Return the distance, in noise variances, that is wanting until the search tells two rivals apart.

    Args:
        outcome: the finished search.
        before: steps accepted before the round in question; what they closed decides what is visible.
        pair: the rivals as they stand; what already tells them apart counts.
        duration_s: of the record that is to do it.
    """
    options, problem = SearchOptions(), outcome.problem
    closed = np.sqrt(sum((step.closed**2 for step in before), np.zeros(1)))
    visible = 0.5 * replace(outcome.context, closed=closed).material(options, ())
    counts = output_counts(problem)
    first, other = pair
    fall = SAFETY * options.doubt - max(0.0, first.fall - other.fall)
    apart = SAFETY * visible**2 * (counts + duration_s / problem.series[0].step)
    apart = apart - np.maximum(0.0, first.closed**2 - other.closed**2) * counts
    # The output that tells them apart first suffices.
    return max(1.0, fall, float(np.min(apart * outcome.context.bin_size)))


def _equivalents(asker: _Asker, question: _Open) -> Entry | None:
    """Ask what tells a named effect from its equivalents, and for its parameters in the same record."""
    if len(question.rivals) < 2:
        return None
    first = _rival(question.rivals[0])
    wanted = asker.wanted(first, first.name) if question.step is asker.outcome.steps[-1] else ()
    return _between(asker, question.done, (question.rivals, asker.before(question.step)), wanted)


def _between(
    asker: _Asker,
    done: Round,
    rest: tuple[Sequence[Contender], Sequence[Step]],
    wanted: tuple[Wanted, ...] = (),
) -> Entry | None:
    contenders, before = rest
    if len(contenders) < 2:
        return None

    def needed(duration_s: float, i: int) -> float:
        return _needed(asker.outcome, before, (contenders[0], contenders[i + 1]), duration_s)

    rivals = tuple(_rival(one) for one in contenders)
    stage = asker.stage(done)
    proposal = propose(stage, Question(rivals=rivals, needed=needed, wanted=wanted))
    if (
        proposal is None
        or max(d / needed(proposal.duration_s, i) for i, d in enumerate(proposal.distances)) < LEAST
    ):
        return None
    return proposed(_apart(stage, rivals, proposal), [one.name for one in rivals], proposal)


def _apart(stage: Stage, rivals: Sequence[Rival], proposal: Proposal) -> str:
    """Return what the prediction says, in the output's own unit."""
    channel = stage.template.channels[0].name
    samples = proposal.duration_s / stage.template.step
    told = [
        f"{other.name} stays {math.sqrt(far / samples) * stage.noise.sigma[channel]:.2g} (rms of {channel}) off"
        for other, far in zip(rivals[1:], proposal.distances, strict=True)
    ]
    return f"refitted to what {rivals[0].name} predicts here, {', '.join(told)}"


def _unnamed(asker: _Asker) -> Entry | None:
    """Ask about the nearest laws of the first round whose winner did not last, where something is left unnamed."""
    outcome = asker.outcome
    if outcome.unknown is None:
        return None
    kept = {step.added for step in outcome.steps}
    lost = [done for done in outcome.rounds if done.winner is None or done.winner.name not in kept]
    for done in lost[:1]:
        helping = [one for one in done.contenders if one.fall > SearchOptions().alarm][:MOST_RIVALS]
        return _between(asker, done, (helping, outcome.steps))
    return None


def _poor_parameters(asker: _Asker) -> Entry | None:
    """Ask for all poorly known parameters of all named effects at once."""
    last = Rival(name="", state=asker.outcome.steps[-1].state)
    wanted = tuple(one for owner in last.state.added for one in asker.wanted(last, owner))
    if not wanted:
        return None
    question = Question(rivals=(last,), needed=lambda _, __: 1.0, wanted=wanted)
    proposal = propose(asker.stage(None), question)
    if proposal is None:
        return None
    parameters = [last.state.fit.parameters[one.index] for one in wanted]
    told = [
        f"{p.name} of {p.owner} is known to {one.known:.0%} only; this would leave {left:.1%}"
        for p, one, left in zip(parameters, wanted, proposal.errors, strict=True)
    ]
    entry = proposed("; ".join(told), list(dict.fromkeys(p.owner for p in parameters)), proposal)
    predicted = [
        {"effect": p.owner, "parameter": p.name, "relative_std": left}
        for p, left in zip(parameters, proposal.errors, strict=True)
    ]
    return {**entry, "predicted": predicted}


def _richer_law(asker: _Asker) -> Entry | None:
    """Ask about laws that contain a named one, fit as well, and would differ visibly where nobody has looked yet."""
    options, outcome = SearchOptions(), asker.outcome
    for step, done in _rounds(outcome):
        if done.winner is None or step.equivalents:
            continue
        for rival in done.contenders:
            if (
                step.added not in EFFECTS[rival.name].contains
                or done.winner.fall - rival.fall > options.doubt
            ):
                continue
            # Here the richer law is the truth that the simpler one would have to follow.
            entry = _between(asker, done, ((rival, done.winner), asker.before(step)))
            if entry is not None and entry["worth"] >= ENOUGH:
                return entry
    return None


def _hidden(asker: _Asker) -> Entry | None:
    """Ask what the records could hide, where they have given no name to what is missing."""
    outcome = asker.outcome
    if outcome.verdict == "named":
        return None
    rest = outcome.ranges, SearchOptions(), outcome.context
    last = outcome.steps[-1].state
    found = discover(search_of(asker.stage(None), last, rest, outcome.context.excluded))
    return None if found is None else revealing(why_hidden(found, outcome.verdict), found)
