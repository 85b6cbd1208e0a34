"""Which of the judged candidates of a round is added, and which of the others this data cannot tell from it."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from discrepancy.effects.table import EFFECTS
from discrepancy.search.context import Context
from discrepancy.search.options import SearchOptions
from discrepancy.search.same import Equivalent, exact_equivalents
from discrepancy.search.state import State

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Contender:
    """A fitted candidate of one round.

    Attributes:
        fall: by how much it lowers the held-out loss of the round's starting model, in noise variances.
        closed: closed part of the gap by output, as rms in units of one sample's noise, shape (C,).
        part: the closed part of the gap over the whole gap (rms), of the output of which it closes most.
        size: number of fitted parameters of its effects.
    """

    name: str
    state: State
    white_loss: float
    fall: float = 0.0
    closed: FloatArray = field(default_factory=lambda: np.zeros(1))
    part: float = 1.0

    @property
    def size(self) -> int:
        """Number of fitted parameters of all added effects."""
        return self.state.size


def choose(
    judged: Sequence[Contender], options: SearchOptions, before: tuple[State, Context]
) -> Contender | None:
    """Return the contender to add: significant, material, and the simplest among those that do the same."""
    state, context = before
    least = context.least_added(options, state.present)
    part = 0.0
    if context.repeat_noise is not None:
        # A name whose gap hardly shrinks is not a name: it would only patch the form of what is missing.
        part = options.later_part if state.added else options.first_part
    passing = [
        c
        for c in judged
        if c.fall > context.least_fall(options, own_size(c))
        and np.any(c.closed > np.maximum(least, _least_to_replace(c, state, options, context)))
        and c.part > part
        and c.white_loss < (1.0 - options.material_rms) ** 2 * state.fit.loss
    ]
    if not passing:
        return None
    best = passing[0]
    for rival in passing[1:]:
        if rival.name not in EFFECTS[best.name].contains:
            continue
        # What the richer law closes beyond the simpler one, against all that it closes.
        if np.all(_apart(best, rival) < np.maximum(least, options.simpler * best.closed)):
            best = rival
    best = _fewest_parameters(best, passing, options, context)
    return _fewest_names(best, passing, options, before)


def _fewest_parameters(
    best: Contender, passing: Sequence[Contender], options: SearchOptions, context: Context
) -> Contender:
    """Return the law with the fewest parameters among those that differ from the best by less than forms err.

    No reduced law is exact, and one with more parameters follows the form errors of the right one too. The best is then
    declared equivalent.
    """
    same = [
        c
        for c in passing
        if np.all(_apart(best, c) <= options.form_error * best.closed)
        and _inseparable(best, c, options, context)
    ]
    return min([best, *same], key=own_size)


def _apart(first: Contender, second: Contender) -> FloatArray:
    """Return what the first closes beyond the second, rms by output in units of one sample's noise, shape (C,)."""
    return np.asarray(np.sqrt(np.maximum(0.0, first.closed**2 - second.closed**2)))


def _fewest_names(
    best: Contender, passing: Sequence[Contender], options: SearchOptions, before: tuple[State, Context]
) -> Contender:
    """Return a law that takes the place of a named one rather than a further name, where nothing tells them apart."""
    state, context = before
    if len(best.state.added) <= len(state.added):
        return best
    same = (c for c in passing if len(c.state.added) <= len(state.added))
    return next((c for c in same if _inseparable(best, c, options, context)), best)


def _inseparable(winner: Contender, rival: Contender, options: SearchOptions, context: Context) -> bool:
    """Return whether this data cannot tell two contenders apart."""
    close = winner.fall - rival.fall < options.doubt
    return close or bool(np.all(_apart(winner, rival) < 0.5 * context.material(options, ())))


def _shows(richer: Contender, winner: Contender, options: SearchOptions, context: Context) -> bool:
    """Return whether a law's further term is significant, though too small to be named.

    At a fraction of its strength the dip of Stribeck friction is the first part of it to go under.
    """
    further = own_size(richer) - own_size(winner)
    significant = richer.fall - winner.fall > context.least_fall(options, further)
    return significant and bool(np.any(_apart(richer, winner) > options.simpler * winner.closed))


def _least_to_replace(
    contender: Contender, state: State, options: SearchOptions, context: Context
) -> FloatArray:
    """Return what a law that contains a named one must close: the round that took the simpler one asked it too."""
    replaced = set(EFFECTS[contender.name].contains) & set(state.added)
    return options.simpler * context.closed if replaced else np.zeros(1)


def own_size(contender: Contender) -> int:
    """Return how many parameters the newest effect brought."""
    return sum(1 for p in contender.state.fit.parameters if p.owner == contender.name)


def equivalents_of(
    winner: Contender, judged: Sequence[Contender], options: SearchOptions, context: Context
) -> tuple[Equivalent, ...]:
    """Return the rivals that this data cannot tell from the winner, and richer laws of which it shows a trace."""
    found: list[Equivalent] = []
    for rival in judged:
        if rival.name == winner.name or rival.fall <= context.alarm(options):
            continue
        if winner.name in EFFECTS[rival.name].contains:
            if _shows(rival, winner, options, context):
                found.append(rival.name)
        elif _inseparable(winner, rival, options, context):
            # A rival that leaves the law which the winner has replaced stands beside it: both make the other answer.
            names = tuple(name for name in rival.state.added if name not in winner.state.added)
            found.append(names if len(names) > 1 else rival.name)
    found.extend(exact_equivalents(winner.state.added))
    return tuple(dict.fromkeys(found))
