"""What one block alone shows, and what a standard error holds beyond noise, are told apart from the rest."""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from daq.recording.recording import Recording
from discrepancy.data.series import read_series
from discrepancy.model.schema import JointModel
from discrepancy.prepare import prepare_simulation
from discrepancy.search.judge import held_out
from discrepancy.search.known import poorly_known
from discrepancy.search.outcome import SearchOutcome, Step
from discrepancy.search.state import polish, scan_effect
from discrepancy.simulation import slots as s

Recorder = Callable[[Mapping[int, float], int], Recording]


def test_what_one_block_alone_shows_does_not_carry_the_fit_away(
    nameplate: JointModel, record: Recorder
) -> None:
    train = [read_series(record({}, k), nameplate, str(k)) for k in (1, 2)]
    prepared = prepare_simulation(nameplate, train, None)
    problem, found = prepared.problem, prepared.state.fit
    first = problem.blocks(2.0)[0]
    rows = np.concatenate([np.arange(part.start, part.stop) for part in first])
    # A parameter that acts in one block, and a trace of it elsewhere, as a stop does that was touched once.
    local = np.full((found.residual.size, 1), 1e-6)
    local[rows, 0] = 1.0
    touched = replace(
        found, jacobian=np.hstack([found.jacobian, local]), residual=found.residual + local[:, 0]
    )
    plain = replace(found, residual=touched.residual)
    assert held_out(problem, touched).loss < 1.2 * held_out(problem, plain).loss


def test_an_error_that_is_not_noise_is_not_asked_about(nameplate: JointModel, record: Recorder) -> None:
    train = [read_series(record({s.COULOMB: 0.15}, k), nameplate, str(k)) for k in (1, 2)]
    prepared = prepare_simulation(nameplate, train, None)
    problem, ranges, name = prepared.problem, prepared.ranges, "coulomb_friction"
    state = polish(problem, scan_effect(problem, prepared.state, name, ranges), ranges)
    outcome = SearchOutcome(
        steps=(Step(state=prepared.state, added=None), Step(state=state, added=name)), rounds=(),
        problem=problem, ranges=ranges, context=prepared.context, names={},
    )  # fmt: skip
    assert poorly_known(outcome, state, name, {"level": 0.2}) == ({}, {"level": 0.2})
    assert poorly_known(outcome, state, name, {"level": 0.01}) == ({}, {})
    # The same where the noise alone is that large: its weight in the fit is what says so.
    loud = replace(state, fit=replace(state.fit, residual=state.fit.residual * 300.0))
    assert poorly_known(outcome, loud, name, {"level": 0.2}) == ({"level": 0.2}, {})
