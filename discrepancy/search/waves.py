"""Seek the wave numbers of named laws anew: a law of the angle may have settled in the hollow beside the right one.

A law with a wave number was fitted while later effects were missing, and had to make up for them: cogging was pulled to
a neighbouring number of periods, a weight to so long a wave that it took in a constant torque.
"""

from dataclasses import replace

import numpy as np

from discrepancy.effects.spec import Effect, EffectParameter, Ranges
from discrepancy.effects.table import EFFECTS
from discrepancy.fitting.levenberg import glance
from discrepancy.fitting.parameters import write_start
from discrepancy.fitting.problem import SimulationProblem
from discrepancy.search.noise import waves_left
from discrepancy.search.state import State, parameters_of, refit, without

_GLANCE = 2
_FOLLOWED = 2
_HOLLOW = 0.02
"""Starts whose wave number differs by less than this part from the fitted one lead back to it."""


def with_best_waves(problem: SimulationProblem, state: State, ranges: Ranges) -> State:
    """Return the state with each added effect's wave number in the hollow that fits best beside all the others."""
    if state.is_chaotic:
        return state
    for name in state.added:
        wave = EFFECTS[name].wave
        if wave is not None:
            state = _with_best_wave(problem, state, (EFFECTS[name], wave), ranges)
    return state


def _with_best_wave(
    problem: SimulationProblem, state: State, law: tuple[Effect, EffectParameter], ranges: Ranges
) -> State:
    effect, wave = law
    bare = without(state, [effect.id])
    seen = replace(ranges, waves=waves_left(problem, bare))
    now = float(state.fit.vector[wave.slot])
    others = [other for other in state.present if other != effect.id]
    vectors = [
        write_start(state.fit.vector, effect, start, others)
        for start in effect.starts(seen)
        if abs(start[wave.name] / now - 1.0) > _HOLLOW
    ]
    parameters = parameters_of(state.base, state.given, state.added, ranges)
    trials = [glance(problem, parameters, (vector, state.fit.starts), _GLANCE, None) for vector in vectors]
    for index in np.argsort([trial.loss for trial in trials])[:_FOLLOWED]:
        found = refit(problem, replace(state, fit=trials[index]), ranges)
        state = found if found.fit.loss < state.fit.loss else state
    return state
