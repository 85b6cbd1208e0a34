"""One law that explains it goes before two that explain it as well, a simple one before one of more parameters."""

from dataclasses import replace

import numpy as np
import pytest

from discrepancy.data.series import read_series
from discrepancy.effects.table import EFFECTS
from discrepancy.fitting.parameters import fit_parameter
from discrepancy.model.schema import JointModel
from discrepancy.prepare import Prepared, prepare_simulation
from discrepancy.search.choice import Contender, choose, equivalents_of
from discrepancy.search.options import SearchOptions
from tests.discrepancy.recorder import make_recording

LIMITS = SearchOptions()


@pytest.fixture
def friction(nameplate: JointModel) -> Prepared:
    """Return a joint whose dry friction was named in the first round."""
    series = [read_series(make_recording({}, seed), nameplate, str(seed)) for seed in (1, 2)]
    prepared = prepare_simulation(nameplate, series, None)
    return replace(prepared, state=replace(prepared.state, added=("coulomb_friction",)))


def contender(prepared: Prepared, added: tuple[str, ...], fall: float) -> Contender:
    state = replace(prepared.state, added=added)
    closed = np.array([fall**0.5 / 10.0])
    return Contender(name=added[-1], state=state, white_loss=0.0, fall=fall, closed=closed, part=1.0)


def rival(prepared: Prepared, name: str, closed: float, fall: float) -> Contender:
    """Return a contender with the parameters of its effect."""
    effect = EFFECTS[name]
    own = [fit_parameter(effect, one, prepared.ranges) for one in effect.parameters if one.free]
    fit = replace(prepared.state.fit, parameters=(*prepared.state.fit.parameters, *own))
    state = replace(prepared.state, added=(*prepared.state.added, name), fit=fit)
    amount = np.array([closed])
    return Contender(name=name, state=state, white_loss=0.0, fall=fall, closed=amount, part=1.0)


@pytest.mark.parametrize(("lead", "named"), [(6.0, "stribeck_friction"), (6000.0, "transport_delay")])
def test_a_richer_friction_goes_before_friction_and_a_delay_unless_they_fit_better(
    friction: Prepared, lead: float, named: str
) -> None:
    delay = contender(friction, ("coulomb_friction", "transport_delay"), 300.0 + lead)
    dip = contender(friction, ("stribeck_friction",), 300.0)
    winner = choose([delay, dip], LIMITS, (friction.state, friction.context))
    assert winner is not None
    assert winner.name == named


def test_the_two_names_together_are_the_other_answer(friction: Prepared) -> None:
    delay = contender(friction, ("coulomb_friction", "transport_delay"), 306.0)
    dip = contender(friction, ("stribeck_friction",), 300.0)
    found = equivalents_of(dip, [delay, dip], LIMITS, friction.context)
    assert found == (("coulomb_friction", "transport_delay"),)


@pytest.mark.parametrize(("closed", "named"), [(2.9999, "current_loop_lag"), (2.999, "belt_compliance")])
def test_a_lag_goes_before_a_belt_that_fits_better_by_less_than_forms_err(
    friction: Prepared, closed: float, named: str
) -> None:
    belt = rival(friction, "belt_compliance", 3.0, 50_000.0)
    lag = rival(friction, "current_loop_lag", closed, 49_900.0)
    winner = choose([belt, lag], LIMITS, (friction.state, friction.context))
    assert winner is not None
    assert winner.name == named


@pytest.mark.parametrize(
    ("fall", "closed", "found"),
    [
        pytest.param(2439.0, 0.6554, ("stribeck_friction",), id="a trace of a dip"),
        pytest.param(2410.0, 0.6554, (), id="no more than its parameters are worth"),
        pytest.param(2439.0, 0.6524, (), id="less than forms err"),
    ],
)
def test_a_dip_too_small_to_be_named_is_not_denied(
    friction: Prepared, fall: float, closed: float, found: tuple[str, ...]
) -> None:
    level = rival(friction, "coulomb_friction", 0.6523, 2374.0)
    dip = rival(friction, "stribeck_friction", closed, fall)
    assert choose([dip, level], LIMITS, (friction.state, friction.context)) is level
    assert equivalents_of(level, [dip, level], LIMITS, friction.context) == found
