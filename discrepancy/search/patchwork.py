"""Laws that were patched together because the right one is not in the catalogue."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from discrepancy.effects.spec import Port
from discrepancy.effects.table import EFFECTS
from discrepancy.locate import Place
from discrepancy.search.curves import called
from discrepancy.search.outcome import Step

MANY_MINOR = 3
MINOR_SHARE = 0.15
"""An effect that closes less than this part of all that was closed is minor."""
LEFT_BY_PATCH = 0.25
"""A small law that leaves less than this part of what it closes is no patch."""
FloatArray = NDArray[np.float64]


def patchwork(steps: Sequence[Step], left: FloatArray) -> frozenset[str]:
    """Return the laws that were patched together because the right one is not in the catalogue.

    A second law over the same variables that closes little beside the first says that the first has the wrong form;
    so do three or more small ones over any variable. A patch does not fit either: what it leaves is about as large as
    what it closes. Small laws beside which hardly anything is left are what was missing.

    Args:
        steps: accepted models of a search, base first.
        left: what the largest significant curve beside the last of them would close, in the units of `Step.closed`,
            shape (C,); infinite where that is not known.
    """
    added = [step for step in steps if step.added is not None]
    total = np.sqrt(sum((step.closed**2 for step in added), np.zeros(1)))
    minor = [
        step
        for step in added
        if np.all(step.closed < MINOR_SHARE * total) and np.any(left > LEFT_BY_PATCH * np.max(step.closed))
    ]
    doubted = {str(step.added) for step in minor} if len(minor) >= MANY_MINOR else set()
    for small in minor:
        for big in added:
            if (
                np.any(big.closed >= MINOR_SHARE * total)
                and not _moves_by_itself(big)
                and _domain_of(big) == _domain_of(small)
            ):
                doubted |= {str(small.added), str(big.added)}
    return frozenset(doubted)


def place_of(step: Step) -> tuple[Port, str]:
    """Return port and driver of a step's effect."""
    effect = EFFECTS[str(step.added)]
    return effect.port, effect.driver


def _domain_of(step: Step) -> tuple[Port, str, str | None]:
    """Return over what a step's law is defined: friction that grows with the load is no correction to a law of it."""
    return *place_of(step), EFFECTS[str(step.added)].second_driver


def _moves_by_itself(step: Step) -> bool:
    """Return whether a step's effect is a motion, not a curve over a variable that a small law could correct."""
    return EFFECTS[str(step.added)].chaotic


def driver_id(place: Place, names: Mapping[str, str]) -> str:
    """Return the catalogue's word for a place's driver."""
    drivers = {effect.driver for effect in EFFECTS.values()}
    return next((name for name in called(place, names) if name in drivers), place.driver)
