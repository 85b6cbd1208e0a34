"""Try another effect in the place of each named one, once nothing more is added.

Effects that enter one by one are judged while the later ones are still missing: a law may have been taken for following
two effects a little each. With all the others in the model it competes again with the whole catalogue (the exchange
step of floating forward selection, P. Pudil et al., Pattern Recognition Letters 15, 1994). A law with fewer parameters
that these data cannot tell from the named one takes its place too. Where all others, after a few steps from every
start, close less than half of what the named one closes, they are left behind and nothing is fitted to the end. An
effect that a round chose beside exactly the others has competed with the catalogue there.
"""

from collections.abc import Sequence

from discrepancy.effects.spec import Ranges
from discrepancy.fitting.problem import SimulationProblem
from discrepancy.search.context import Context
from discrepancy.search.greedy import Round, run_round, screen
from discrepancy.search.judge import held_out
from discrepancy.search.options import SearchOptions
from discrepancy.search.outcome import Step
from discrepancy.search.state import State, refit, with_best_smoothing, without

AGAIN = 8


def exchange(
    problem: SimulationProblem,
    found: tuple[State, Sequence[Step]],
    ranges: Ranges,
    limits: tuple[SearchOptions, Context],
    rounds: Sequence[Round] = (),
) -> tuple[State, list[Step], Round] | None:
    """Return the model in which one effect has made way for a better one, its steps and that round; None if none has.

    Args:
        problem: with white noise weights.
        found: the model so far and its steps.
        ranges: sizes of the signals.
        limits: options and the search's context.
        rounds: those that were run; what one chose beside these very effects has competed with all others there.
    """
    current, steps = found
    options, context = limits
    if len(current.added) < 2 or current.is_chaotic:
        return None
    for name in current.added:
        if any(_chose(done, name, current) for done in rounds):
            continue
        reduced = refit(problem, without(current, [name]), ranges, AGAIN)
        screened = screen(problem, reduced, ranges, context)
        if screened.in_reach == {name}:
            continue
        done = run_round(problem, reduced, ranges, options, context, screened)
        winner = done.winner
        if winner is None or winner.name == name or name in winner.state.added:
            continue
        better = with_best_smoothing(problem, refit(problem, winner.state, ranges, AGAIN))
        simpler = better.size < current.size and name in done.equivalents
        if not simpler and not _is_better(done, (better, current), ranges, limits):
            continue
        kept = [step for step in steps if step.added is None or step.added in better.added]
        step = Step(
            state=better,
            added=winner.name,
            equivalents=done.equivalents,
            fall=winner.fall,
            closed=winner.closed,
        )
        return better, [*kept, step], done
    return None


def _chose(done: Round, name: str, current: State) -> bool:
    """Return whether a round chose an effect beside exactly the others of a model."""
    chosen = done.winner is not None and done.winner.name == name
    return chosen and set(done.start.added) == set(current.added) - {name}


def _is_better(
    done: Round, pair: tuple[State, State], ranges: Ranges, limits: tuple[SearchOptions, Context]
) -> bool:
    """Return whether the first model predicts held-out blocks clearly better, its parameters paid for."""
    options, context = limits
    new, old = (refit(done.problem, state, ranges, 3) for state in pair)
    unit = min(new.fit.loss, old.fit.loss) / done.problem.rows
    if context.repeat_noise is not None:
        unit = max(1.0, unit)
    gained = held_out(done.problem, old.fit).loss - held_out(done.problem, new.fit).loss
    return gained / unit > options.doubt + options.per_parameter * (new.size - old.size)
