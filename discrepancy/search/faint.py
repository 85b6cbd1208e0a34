"""Small effects beside large ones: named where, together, they close nearly all that the large ones leave.

No reduced model is exact, and a law of the catalogue may follow the error of form of a large one: a further effect must
close a part of all that has been closed. What follows such an error follows some of it. Where one or two further laws
take what is left down to the noise, that was no error of form. Only torques count: an error of timing or of the
sensor's model, the commonest there are, is of the very form of a lag.
"""

from collections.abc import Callable
from dataclasses import replace

from discrepancy.effects.spec import Port
from discrepancy.effects.table import EFFECTS
from discrepancy.search.choice import choose
from discrepancy.search.course import Course
from discrepancy.search.greedy import closed_part
from discrepancy.search.options import SearchOptions
from discrepancy.search.state import refit

MOST_FAINT = 2
"""How many such effects there may be."""
_LIKE_LAGS = frozenset(
    name for name, one in EFFECTS.items() if one.port is not Port.TORQUE or one.driver == "frequency"
)


def with_faint_effects(
    course: Course, options: SearchOptions, follow: Callable[[Course, SearchOptions], Course]
) -> Course:
    """Return the course followed with small effects too, where that closes nearly all that is left; else the course.

    Args:
        course: at its end.
        options: decision limits of the search.
        follow: adds effects to a course, from `course`.
    """
    start, usual = course.current, course.context.excluded
    last = next((one for one in reversed(course.rounds) if one.winner is None), None)
    if course.context.repeat_noise is None or start.is_chaotic or not start.added or last is None:
        return course
    faint = replace(options, form_error=options.faint_form_error)
    # What is named may be chosen again when it competes with the catalogue once more.
    unfit = usual | (_LIKE_LAGS - set(start.added))
    may_enter = [one for one in last.contenders if one.name not in unfit]
    if choose(may_enter, faint, (last.start, course.context)) is None:
        return course
    further = follow(replace(course, context=replace(course.context, excluded=unfit)), faint)
    further = replace(further, context=replace(further.context, excluded=usual))
    if further.current.is_chaotic or len(further.current.added) > len(start.added) + MOST_FAINT:
        return course
    problem, ranges = course.problem, course.ranges
    before, after = (refit(problem, one, ranges, 3) for one in (start, further.current))
    return further if closed_part(problem, before, after) >= options.whole_part else course
