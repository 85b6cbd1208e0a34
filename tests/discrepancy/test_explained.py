"""A law that another one has made needless is mentioned; one that never helped, or still helps, is not."""

from dataclasses import replace
from typing import cast

import numpy as np

from discrepancy.search.choice import Contender
from discrepancy.search.explained import explained_away
from discrepancy.search.greedy import Round
from discrepancy.search.options import SearchOptions
from discrepancy.search.state import State

OPTIONS = SearchOptions()
NO_STATE = cast(State, None)


def contender(name: str, fall: float, closed: float) -> Contender:
    return Contender(name=name, state=NO_STATE, white_loss=1.0, fall=fall, closed=np.array([closed]))


def judged(contenders: tuple[Contender, ...], winner: Contender | None) -> Round:
    return Round(
        start=NO_STATE, before=NO_STATE, contenders=contenders, winner=winner, equivalents=(),
        problem=None,  # type: ignore[arg-type]  # not looked at
    )  # fmt: skip


WINNER = contender("asymmetric_viscous_friction", 900.0, 4.0)
OFFSET = contender("load_torque_offset", 700.0, 3.6)
FIRST = judged((WINNER, OFFSET, contender("torque_ripple", 600.0, 0.5)), WINNER)


def test_a_law_that_closes_nothing_beside_the_named_one_is_mentioned() -> None:
    last = judged((replace(OFFSET, fall=2.0),), None)
    notes = explained_away((FIRST, last), ("asymmetric_viscous_friction",), OPTIONS)
    assert len(notes) == 1
    assert notes[0].startswith("load_torque_offset alone would have closed 90% (rms)")


def test_a_law_that_still_helps_is_not_called_needless() -> None:
    last = judged((OFFSET,), None)
    assert explained_away((FIRST, last), ("asymmetric_viscous_friction",), OPTIONS) == ()


def test_a_law_is_not_explained_by_a_name_that_was_taken_back() -> None:
    last = judged((replace(OFFSET, fall=2.0),), None)
    assert explained_away((FIRST, last), (), OPTIONS) == ()


def test_a_richer_form_of_the_named_law_is_not_mentioned() -> None:
    dry, richer = contender("coulomb_friction", 900.0, 4.0), contender("stribeck_friction", 890.0, 4.0)
    last = judged((replace(richer, fall=2.0),), None)
    assert explained_away((judged((dry, richer), dry), last), ("coulomb_friction",), OPTIONS) == ()
