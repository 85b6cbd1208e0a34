"""Say which laws helped for a while and closed nothing any more once another one was named.

Two laws of one shape hide each other: a constant force is the mean of a friction that depends on the direction. Which
of them a search names is a finding; that the other one would have been named without it should be said.
"""

from collections.abc import Sequence

import numpy as np

from discrepancy.effects.table import EFFECTS
from discrepancy.search.choice import Contender
from discrepancy.search.greedy import Round
from discrepancy.search.options import SearchOptions

SUBSTANTIAL = 0.5
"""A law is worth a word if it closed more than this part of what the named one closed (rms) in the same round."""


def explained_away(rounds: Sequence[Round], added: Sequence[str], options: SearchOptions) -> tuple[str, ...]:
    """Return a note for each law that a named one has made needless.

    Args:
        rounds: of a search in order; the last one judges beside all names.
        added: the names that stand.
        options: decision limits; a law helps if its held-out loss falls by more than `alarm`.
    """
    if len(rounds) < 2 or rounds[-1].winner is not None:
        return ()
    still = {c.name for c in rounds[-1].contenders if c.fall > options.alarm}
    notes: dict[str, str] = {}
    for one in rounds[:-1]:
        winner = one.winner
        if winner is None or winner.name not in added:
            continue
        for rival in one.contenders:
            # A richer form of the named law, or a simpler one, is no other finding.
            if rival.name in still | set(added) or _are_nested(rival.name, winner.name):
                continue
            if not _substantial(rival, winner, options):
                continue
            share = _size(rival) / _size(winner)
            notes[rival.name] = (
                f"{rival.name} alone would have closed {share:.0%} (rms) of what {winner.name} closed and predicts "
                f"nothing beside it any more: what looks like {rival.name} is a part of {winner.name}"
            )
    return tuple(notes.values())


def _size(contender: Contender) -> float:
    """Return what a contender closed, over all outputs."""
    return float(np.linalg.norm(contender.closed))


def _are_nested(one: str, other: str) -> bool:
    return one in EFFECTS[other].contains or other in EFFECTS[one].contains


def _substantial(rival: Contender, winner: Contender, options: SearchOptions) -> bool:
    return rival.fall > options.alarm and _size(rival) > SUBSTANTIAL * _size(winner)
