"""Forms of a law: values that are chosen from a few, not fitted."""

from collections.abc import Callable, Mapping
from dataclasses import replace

import pytest

from daq.recording.recording import Recording
from discrepancy.data.series import read_series
from discrepancy.effects.table import EFFECTS
from discrepancy.fitting.parameters import write_start
from discrepancy.model.schema import JointModel
from discrepancy.prepare import prepare_simulation
from discrepancy.search.bench import make_bench
from discrepancy.search.standard_errors import form_variances
from discrepancy.search.state import fitted_forms, refit, with_best_form, with_best_forms
from discrepancy.simulation import slots as s
from tests.discrepancy.recorder import make_recording

Recorder = Callable[[Mapping[int, float], int], Recording]
STRIBECK = EFFECTS["stribeck_friction"]


@pytest.mark.parametrize("wrong", [1.0, 2.0])
def test_the_form_is_chosen_again_from_the_fitted_point(
    nameplate: JointModel, record: Recorder, wrong: float
) -> None:
    true = 3.0 - wrong
    hidden = {
        s.STRIBECK_COULOMB: 0.1,
        s.STRIBECK_EXTRA: 0.08,
        s.STRIBECK_SPEED: 0.1,
        s.STRIBECK_EXPONENT: true,
    }
    train = [read_series(record(hidden, seed), nameplate, f"train[{seed}]") for seed in (1, 2)]
    prepared = prepare_simulation(nameplate, train, None)
    start = {"coulomb_level": 0.1, "static_excess": 0.08, "stribeck_speed": 0.1, "exponent": wrong}
    vector = write_start(prepared.state.fit.vector, STRIBECK, start, ())
    state = replace(
        prepared.state, added=(STRIBECK.id,), fit=replace(prepared.state.fit, vector=vector), nameplate=None
    )
    fitted = refit(prepared.problem, state, prepared.ranges, 8)
    best = with_best_form(prepared.problem, fitted, STRIBECK.id, prepared.ranges)
    assert best.fit.vector[s.STRIBECK_EXPONENT] == true
    assert best.fit.loss < fitted.fit.loss
    assert best.fit.vector[s.STRIBECK_EXTRA] == pytest.approx(0.08, rel=0.05)


def test_the_form_of_an_earlier_effect_is_asked_for_again(nameplate: JointModel, record: Recorder) -> None:
    hidden = {s.STRIBECK_COULOMB: 0.1, s.STRIBECK_EXTRA: 0.08, s.STRIBECK_SPEED: 0.1, s.LOAD_OFFSET: 0.1}
    series = [read_series(record({**hidden, s.STRIBECK_EXPONENT: 2.0}, k), nameplate, str(k)) for k in (1, 2)]
    p = prepare_simulation(nameplate, series, None)
    start = {"coulomb_level": 0.1, "static_excess": 0.08, "stribeck_speed": 0.1, "exponent": 1.0}
    vector = write_start(p.state.fit.vector, STRIBECK, start, ())
    vector = write_start(vector, EFFECTS["load_torque_offset"], {"torque": 0.1}, ())
    both = replace(
        p.state,
        added=(STRIBECK.id, "load_torque_offset"),
        fit=replace(p.state.fit, vector=vector),
        nameplate=None,
    )
    fitted = refit(p.problem, both, p.ranges, 8)
    assert fitted.fit.vector[s.STRIBECK_EXPONENT] == 1.0
    best = with_best_forms(p.problem, fitted, p.ranges)
    assert best.fit.vector[s.STRIBECK_EXPONENT] == 2.0
    assert best.fit.loss < fitted.fit.loss


@pytest.mark.parametrize(("noise", "shows_the_form"), [(0.002, True), (0.2, False)])
def test_forms_that_fit_as_well_widen_the_standard_errors(
    nameplate: JointModel, noise: float, shows_the_form: bool
) -> None:
    hidden = {s.STRIBECK_COULOMB: 0.1, s.STRIBECK_EXTRA: 0.08, s.STRIBECK_SPEED: 0.1}
    records = [make_recording(hidden, seed, noise=noise) for seed in (1, 2)]
    train = [read_series(one, nameplate, f"train[{i}]") for i, one in enumerate(records)]
    p = prepare_simulation(nameplate, train, None)
    start = {"coulomb_level": 0.1, "static_excess": 0.08, "stribeck_speed": 0.1, "exponent": 2.0}
    vector = write_start(p.state.fit.vector, STRIBECK, start, ())
    begun = replace(p.state, added=(STRIBECK.id,), fit=replace(p.state.fit, vector=vector), nameplate=None)
    state = refit(p.problem, begun, p.ranges, 8)
    one, two = fitted_forms(p.problem, state, STRIBECK.id, p.ranges)
    index = [q.slot for q in state.fit.parameters].index(s.STRIBECK_EXTRA)
    apart = abs(float(one.fit.values[index] - two.fit.values[index]))
    error = form_variances(make_bench(p.problem, state, p.ranges, p.context), p.ranges)[index] ** 0.5
    assert apart > 0.003
    # Forms that fit equally well have half the weight each.
    assert (error < 0.01 * apart) if shows_the_form else (0.3 * apart < error < apart)
