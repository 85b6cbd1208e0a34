"""Laws that were patched together because the right one is not in the catalogue."""

from collections.abc import Mapping, Sequence

import numpy as np

from discrepancy.effects.spec import Port
from discrepancy.effects.table import EFFECTS
from discrepancy.locate import Place
from discrepancy.search.bench import Bench
from discrepancy.search.curves import called, judge_curves
from discrepancy.search.options import SearchOptions
from discrepancy.search.outcome import Step

MANY_MINOR = 3
MINOR_SHARE = 0.15
"""An effect that closes less than this part of all that was closed is minor."""


def patchwork(steps: Sequence[Step], shown: frozenset[tuple[Port, str]] | None = None) -> frozenset[str]:
    """Return the laws that were patched together because the right one is not in the catalogue.

    A second law over the same variables that closes little beside the first says that the first has the wrong form;
    so do three or more small ones over any variable.

    Args:
        steps: accepted models of a search, base first.
        shown: where something significant is still left, None if not known; two laws over a variable over which nothing
            is left are two laws, not a patch.
    """
    added = [step for step in steps if step.added is not None]
    total = np.sqrt(sum((step.closed**2 for step in added), np.zeros(1)))
    minor = [step for step in added if np.all(step.closed < MINOR_SHARE * total)]
    doubted = {str(step.added) for step in minor} if len(minor) >= MANY_MINOR else set()
    for small in minor:
        for big in added:
            is_left = shown is None or place_of(small) in shown
            if big not in minor and is_left and _domain_of(big) == _domain_of(small):
                doubted |= {str(small.added), str(big.added)}
    return frozenset(doubted)


def still_shown(
    bench: Bench, options: SearchOptions, names: Mapping[str, str]
) -> frozenset[tuple[Port, str]]:
    """Return the ports and drivers over which a curve beside the model is significant, material or not."""
    least = bench.context.alarm(options)
    curves = (c for c in judge_curves(bench, names) if c.judged.fall > least + options.per_parameter * c.size)
    return frozenset((c.place.port, driver_id(c.place, names)) for c in curves)


def place_of(step: Step) -> tuple[Port, str]:
    """Return port and driver of a step's effect."""
    effect = EFFECTS[str(step.added)]
    return effect.port, effect.driver


def _domain_of(step: Step) -> tuple[Port, str, str | None]:
    """Return over what a step's law is defined: friction that grows with the load is no correction to a law of it."""
    return *place_of(step), EFFECTS[str(step.added)].second_driver


def driver_id(place: Place, names: Mapping[str, str]) -> str:
    """Return the catalogue's word for a place's driver."""
    drivers = {effect.driver for effect in EFFECTS.values()}
    return next((name for name in called(place, names) if name in drivers), place.driver)
