"""What the search leaves open, and the experiment, or the other measurement, that would settle it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from discrepancy.design.discovery import discover, search_of
from discrepancy.design.limits import RigLimits, limits_of_records
from discrepancy.design.measurements import other_measurement
from discrepancy.design.proposal import ENOUGH, propose
from discrepancy.design.question import Quantities, Question, Rival, known_errors
from discrepancy.effects.table import EFFECTS
from discrepancy.search.asking import Asker, between, rival_of
from discrepancy.search.choice import Contender
from discrepancy.search.entries import Entry, only_measurement, others, proposed, revealing, why_hidden
from discrepancy.search.greedy import Round
from discrepancy.search.options import SearchOptions
from discrepancy.search.outcome import SearchOutcome, Step
from discrepancy.search.same import Equivalent, exact_equivalents

MOST_RIVALS = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class _Open:
    """Rivals that may be told apart, and those that no motion tells apart."""

    step: Step
    done: Round
    rivals: tuple[Contender, ...]
    hopeless: tuple[Equivalent, ...]


def next_question(
    outcome: SearchOutcome, limits: RigLimits | None = None, values: Quantities | None = None
) -> Entry | None:
    """Return what to do next; None if nothing is open.

    Equivalents come first, a weight with a constant last of these, then the nearest laws where the verdict is
    `unknown`, then poorly known parameters, then richer laws that the data leave room for. Where nothing is named, or
    nothing that is named explains the rest, the question is what the records could hide.

    Args:
        outcome: the finished search.
        limits: of the rig; None takes what the records have shown safe.
        values: parameters of the last model with standard errors, by owner and name; None asks about none.
    """
    if outcome.is_torque:
        return None
    limits = limits or limits_of_records(outcome.problem.series)
    asker = Asker(outcome=outcome, limits=limits, errors=known_errors(values or {}))
    questions = [_open(step, done) for step, done in _rounds(outcome)]
    measurements = _measurements(outcome, questions)
    for question in questions:
        entry = _equivalents(asker, question)
        if entry is not None:
            return {**entry, **others(measurements)}
        measurements += _without_answer(question)
    entry = (
        _of_several(asker)
        or _unnamed(asker)
        or _poor_parameters(asker)
        or _richer_law(asker)
        or _hidden(asker)
    )
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


def _equivalents(asker: Asker, question: _Open) -> Entry | None:
    """Ask what tells a named effect from its equivalents, and for its parameters in the same record."""
    if len(question.rivals) < 2:
        return None
    first = rival_of(question.rivals[0])
    wanted = asker.wanted(first, first.name) if question.step is asker.outcome.steps[-1] else ()
    return between(asker, question.done, (question.rivals, asker.before(question.step)), wanted)


def _of_several(asker: Asker) -> Entry | None:
    """Ask what tells the whole model from one of several effects that is declared equivalent to it."""
    steps = asker.outcome.steps
    rivals = steps[-1].rivals
    if not rivals or rivals[0].state.added != steps[-1].state.added:
        return None
    first, other = rivals
    before = [step for step in steps if step.added != first.name]
    entry = between(asker, None, (rivals, before), asker.wanted(rival_of(first), first.name))
    if entry is None:
        return None
    more = other.state.added[-1]
    return {**entry, "separates": [first.name, more], "answers": [[first.name], [first.name, more]]}


def _unnamed(asker: Asker) -> Entry | None:
    """Ask about the nearest laws of the first round whose winner did not last, where something is left unnamed."""
    outcome = asker.outcome
    if outcome.unknown is None:
        return None
    kept = {step.added for step in outcome.steps}
    lost = [done for done in outcome.rounds if done.winner is None or done.winner.name not in kept]
    for done in lost[:1]:
        helping = [one for one in done.contenders if one.fall > SearchOptions().alarm][:MOST_RIVALS]
        return between(asker, done, (helping, outcome.steps))
    return None


def _poor_parameters(asker: Asker) -> Entry | None:
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


def _richer_law(asker: Asker) -> Entry | None:
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
            entry = between(asker, done, ((rival, done.winner), asker.before(step)))
            if entry is not None and entry["worth"] >= ENOUGH:
                return entry
    return None


def _hidden(asker: Asker) -> Entry | None:
    """Ask what the records could hide, where they have given no name to what is missing."""
    outcome = asker.outcome
    if outcome.verdict == "named":
        return None
    rest = outcome.ranges, SearchOptions(), outcome.context
    last = outcome.steps[-1].state
    found = discover(search_of(asker.stage(None), last, rest, outcome.context.excluded))
    return None if found is None else revealing(why_hidden(found, outcome.verdict), found)
