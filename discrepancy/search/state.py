"""A model on its way: which effects it has, its fitted numbers, and what a candidate changes."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import takewhile

import numpy as np
from numpy.typing import NDArray

from discrepancy.effects.spec import Effect, Port, Ranges
from discrepancy.effects.table import EFFECTS
from discrepancy.fitting.levenberg import Fit, fit, glance
from discrepancy.fitting.parameters import (
    SMOOTHING_START_S,
    FitParameter,
    clear_effect,
    effect_parameters,
    write_start,
)
from discrepancy.fitting.problem import SimulationProblem, Starts
from discrepancy.simulation import slots as s
from discrepancy.simulation.kernels.smoothing import is_invisible

SCAN_KEEP = 2
FULL_ITERATIONS = 14
_GLANCE = 3
_UNSEEN = 1e-9
"""A parameter whose slope is less than this part of the steepest one does not show in the outputs."""
FloatArray = NDArray[np.float64]
RIVAL_START = 1.3
"""A second start is followed if its scanned loss is at most this multiple of the first one's."""


@dataclass(frozen=True, slots=True, kw_only=True)
class State:
    """A fitted model during the search.

    Attributes:
        base: parameters of the joint itself and of effects that the model file already held.
        given: ids of effects in the model file; they stay.
        added: ids that the search has added, in order.
        fit: the fitted point.
        nameplate: the kernel's vector before recalibration, None once effects were added.
    """

    base: tuple[FitParameter, ...]
    given: tuple[str, ...]
    added: tuple[str, ...]
    fit: Fit
    nameplate: NDArray[np.float64] | None = None

    @property
    def present(self) -> tuple[str, ...]:
        """All effects in the model."""
        return self.given + self.added

    @property
    def is_chaotic(self) -> bool:
        """Whether the free run is chaotic."""
        return any(EFFECTS[name].chaotic for name in self.present)

    @property
    def size(self) -> int:
        """Number of fitted parameters of the added effects."""
        return len(self.fit.parameters) - len(self.base)


def parameters_of(
    base: Sequence[FitParameter], given: Sequence[str], added: Sequence[str], ranges: Ranges
) -> list[FitParameter]:
    """Return all parameters that a model with these effects fits."""
    found = list(base)
    for i, name in enumerate(added):
        others = [*given, *added[:i], *added[i + 1 :]]
        found.extend(effect_parameters(EFFECTS[name], others, ranges))
    return found


def without(state: State, names: Sequence[str]) -> State:
    """Return the model with some added effects switched off (not refitted)."""
    vector = state.fit.vector
    for name in names:
        vector = clear_effect(vector, EFFECTS[name])
    kept = tuple(name for name in state.added if name not in names)
    return replace(state, added=kept, fit=replace(state.fit, vector=vector))


def refit(
    problem: SimulationProblem, state: State, ranges: Ranges, iterations: int = FULL_ITERATIONS
) -> State:
    """Fit the model again from where it stands."""
    parameters = parameters_of(state.base, state.given, state.added, ranges)
    return replace(state, fit=fit(problem, parameters, state.fit.vector, state.fit.starts, iterations))


def with_best_smoothing(problem: SimulationProblem, state: State, iterations: int = 4) -> State:
    """Return the state with the order of the speed's smoothing that fits better; nobody says which was used.

    A time constant too short for these samples to show has no slope that could lead a fit back: both orders are then
    tried from the start again.
    """
    vector = state.fit.vector.copy()
    if vector[s.OUTPUT_SMOOTHING] <= 0.0:
        return state
    orders = [5.0 - float(vector[s.SMOOTHING_ORDER])]
    if is_invisible(float(vector[s.OUTPUT_SMOOTHING]), problem.series[0].step):
        vector[s.OUTPUT_SMOOTHING] = SMOOTHING_START_S
        orders.append(float(vector[s.SMOOTHING_ORDER]))
    best = state.fit
    for order in orders:
        vector[s.SMOOTHING_ORDER] = order
        other = fit(problem, state.fit.parameters, vector, state.fit.starts, iterations)
        best = other if other.loss < best.loss else best
    return replace(state, fit=best)


def with_best_form(problem: SimulationProblem, state: State, name: str, ranges: Ranges) -> State:
    """Return the state with the form of an added effect (the value of a parameter that is not fitted) that fits best.

    The scan tries every form from coarse starts, and a fit of the wrong form can end lower than one of the right form
    that began far away. From a fitted point all forms begin equally near.
    """
    return min((state, *fitted_forms(problem, state, name, ranges)), key=lambda one: one.fit.loss)


def with_best_forms(problem: SimulationProblem, state: State, ranges: Ranges) -> State:
    """Return the state with the form of every added effect that fits best, the newest effect's first.

    A form was chosen while later effects were missing: with each of them it is asked for again.
    """
    for name in reversed(state.added):
        state = with_best_form(problem, state, name, ranges)
    return state


def fitted_forms(
    problem: SimulationProblem, state: State, name: str, ranges: Ranges, iterations: int = 7
) -> list[State]:
    """Return the state with each form of an added effect, fitted from where it stands; none if it has no forms.

    The speed's smoothing is sought anew for each: one that is caught in a hollow of it must not lose for that. A form
    that is far behind after a few steps is not fitted to the end.
    """
    effect, found = EFFECTS[name], []
    for parameter in (p for p in effect.parameters if not p.free and not effect.chaotic):
        for form in sorted({one[parameter.name] for one in effect.starts(ranges) if parameter.name in one}):
            vector = state.fit.vector.copy()
            vector[parameter.slot] = form
            vectors = [vector]
            if vector[s.OUTPUT_SMOOTHING] > 0.0:
                vector[s.OUTPUT_SMOOTHING] = SMOOTHING_START_S
                vectors = [vector, vector.copy()]
                vectors[1][s.SMOOTHING_ORDER] = 5.0 - vector[s.SMOOTHING_ORDER]
            parameters, starts = state.fit.parameters, state.fit.starts
            fits = [glance(problem, parameters, (one, starts), _GLANCE, None) for one in vectors]
            best = min(fits, key=lambda one: one.loss)
            if best.loss <= RIVAL_START * state.fit.loss:
                best = fit(problem, parameters, best.vector, best.starts, iterations)
            found.append(replace(state, fit=best))
    return found


def refit_from(problem: SimulationProblem, state: State, starts: Starts) -> Fit:
    """Fit the model again on other samples of the same records."""
    return fit(problem, state.fit.parameters, state.fit.vector, starts, 4)


def scan_effect(problem: SimulationProblem, state: State, name: str, ranges: Ranges) -> list[State]:
    """Try every start of one more effect for a few steps; return the best, best first.

    Effects that the new one contains make way for it.
    """
    effect = EFFECTS[name]
    bare = without(state, [other for other in state.added if other in effect.contains])
    parameters = parameters_of(bare.base, bare.given, (*bare.added, name), ranges)
    vectors = starting_vectors(state, bare, effect, ranges)
    first = 2 if len(vectors) > SCAN_KEEP else 4
    reuse = state.fit.jacobian[:, : _shared(parameters, state.fit.parameters)]
    trials = [glance(problem, parameters, (vector, bare.fit.starts), first, reuse) for vector in vectors]
    if effect.port is Port.SENSOR and state.nameplate is not None:
        # A sensor that lies grossly drags the recalibrated joint far away: start from the nameplate too.
        lied = write_start(state.nameplate, effect, effect.starts(ranges)[0], bare.present)
        trials.append(fit(problem, parameters, lied, bare.fit.starts, 4))
    trials.sort(key=lambda trial: trial.loss)
    if bare.added != state.added:
        # A law that replaces a fitted simpler one has to find that one's parameters again.
        again = [fit(problem, parameters, one.vector, one.starts, 6) for one in trials[:SCAN_KEEP]]
        trials = sorted(again, key=lambda trial: trial.loss)
    return [
        replace(bare, added=(*bare.added, name), fit=trial, nameplate=None) for trial in trials[:SCAN_KEEP]
    ]


def _shared(parameters: Sequence[FitParameter], known: Sequence[FitParameter]) -> int:
    """Return how many leading parameters two models share."""
    same = (one == other for one, other in zip(parameters, known, strict=False))
    return sum(1 for _ in takewhile(bool, same))


def plate_vectors(state: State, bare: State, effect: Effect, ranges: Ranges) -> list[FloatArray]:
    """Return where the fit of an effect starts at the nameplate, none once effects were added."""
    if state.nameplate is None:
        return []
    return [write_start(state.nameplate, effect, start, bare.present) for start in effect.starts(ranges)]


def nearest_vectors(problem: SimulationProblem, vectors: Sequence[FloatArray], at: Fit) -> list[FloatArray]:
    """Return the vectors in the order in which their simulations, as they are, come near to the records."""
    data = problem.measured()
    losses = [misfit(problem, data, problem.prepare(vector), at.starts) for vector in vectors]
    return [vectors[i] for i in np.argsort(losses)]


def misfit(problem: SimulationProblem, data: FloatArray, vector: FloatArray, starts: Starts) -> float:
    """Return the sum of squares that one simulation leaves; infinite if it runs away."""
    with np.errstate(over="ignore", invalid="ignore"):
        residual = data - problem.flatten(problem.simulate(vector, starts))
        loss = float(residual @ residual)
    return loss if np.isfinite(loss) else np.inf


def starting_vectors(state: State, bare: State, effect: Effect, ranges: Ranges) -> list[FloatArray]:
    """Return where the fit of an effect starts; numbers that it shares with one that makes way are kept."""
    kept = {p.slot for name in state.added if name in effect.contains for p in EFFECTS[name].parameters}
    kept &= {p.slot for p in effect.parameters}
    found: dict[bytes, FloatArray] = {}
    # Play makes a shaft look softer than it is: its contact is stiffer than the spring that fitted without play.
    stiffer = (1.0, 5.0, 25.0) if s.STIFFNESS in kept else (1.0,)
    for start in effect.starts(ranges):
        for factor in stiffer:
            vector = write_start(bare.fit.vector, effect, start, bare.present)
            for slot in kept:
                vector[slot] = state.fit.vector[slot]
            vector[s.STIFFNESS] *= factor
            for one in (vector, *_with_other_waves(vector, bare, effect, ranges)):
                found[one.tobytes()] = one
    return list(found.values())


def _with_other_waves(vector: FloatArray, bare: State, effect: Effect, ranges: Ranges) -> list[FloatArray]:
    """Return the vector with other wave numbers of a named law that may have made up for this effect.

    A sinusoid of so long a wave that the travel sees a bow of it takes in a constant: with the constant in the model
    its wave is another one, too far away for a step of a fit.
    """
    found: list[FloatArray] = []
    if effect.wave is not None:
        return found
    for name in (one for one in bare.added if one in effect.confused_with):
        wave = EFFECTS[name].wave
        if wave is None:
            continue
        for number in {start[wave.name] for start in EFFECTS[name].starts(ranges)}:
            found.append(vector.copy())
            found[-1][wave.slot] = number
    return found


def polish(problem: SimulationProblem, scanned: Sequence[State], ranges: Ranges) -> State:
    """Fit the scanned starts of one effect to the end, unless one is far behind, and return the best."""
    worth = [one for one in scanned if one.fit.loss <= RIVAL_START * scanned[0].fit.loss]
    best = min((refit(problem, one, ranges) for one in worth), key=lambda one: one.fit.loss)
    return with_unseen_parts(problem, best, ranges)


def with_unseen_parts(problem: SimulationProblem, state: State, ranges: Ranges) -> State:
    """Return the state with the newest effect's parameters that no output shows put back to where they started.

    A stop that a step has put out of reach has no slope that could lead it back.
    """
    effect = EFFECTS[state.added[-1]]
    slopes = np.linalg.norm(state.fit.jacobian, axis=0)
    unseen = {
        p.slot: p.name
        for p, slope in zip(state.fit.parameters, slopes, strict=True)
        if p.owner == effect.id and slope <= _UNSEEN * slopes.max()
    }
    vectors = []
    for slot, name in unseen.items():
        for value in sorted({one[name] for one in effect.starts(ranges) if name in one}):
            vectors.append(state.fit.vector.copy())
            vectors[-1][slot] = value
    trials = []
    for vector in nearest_vectors(problem, vectors, state.fit)[:SCAN_KEEP]:
        begun = replace(state, fit=replace(state.fit, vector=vector))
        trials.append(refit(problem, begun, ranges))
    return min((state, *trials), key=lambda one: one.fit.loss)
