"""Could the named laws be the nearest ones in the catalogue, and not the right ones? And is anything left beside them?

Three signs. A curve over some variable would still be admitted as an effect: over a variable that is not theirs by the
same limits as every effect, over their own variable by a wider one (the right law with slightly wrong constants leaves
such a curve too). A fitted parameter is pressed to its bound and leaving it would be admitted; at a bound that says
what these records can show (`Effect.limits`: a level that the motor never overcame) significance alone decides: the
law was seen only where it is another, simpler one. The same holds for a level of friction inside its bounds if the
largest that the motor could have met would do as well. And, where repeats show the noise, what is left is much more
than noise.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from discrepancy.effects.spec import Kind, Ranges
from discrepancy.effects.table import EFFECTS
from discrepancy.fitting.levenberg import Fit, fit
from discrepancy.fitting.parameters import BASE, FitParameter
from discrepancy.locate import Place
from discrepancy.search.bench import Bench, Judgement
from discrepancy.search.curves import Curve, called, share_of
from discrepancy.search.options import SearchOptions

FloatArray = NDArray[np.float64]

_REFIT_STEPS = 4
LEFT_BESIDE = 0.3
"""A significant curve casts doubt on names that closed no more than about three times as much."""
FAINTEST = 0.02
"""Least such curve, in units of one sample's noise."""
ABOUT = 0.9
"""Two places show about the same if the shares that they explain differ by less than a tenth."""


def find_doubts(
    bench: Bench, rest: tuple[Ranges, SearchOptions], names: Mapping[str, str], curves: Sequence[Curve]
) -> list[Place]:
    """Return where the model fails, the plainest first; several curves may show the same failure.

    Args:
        bench: the model, judged by simulation, under both noise models.
        rest: sizes of the signals, limits of the search.
        names: column names of the drivers.
        curves: what curves over each variable would gain, from `judge_curves`.
    """
    ranges, options = rest
    state, context = bench.state, bench.context
    material = context.material(options, state.present)

    def admits(found: Judgement, size: int, least: FloatArray) -> bool:
        seen = bool(np.any(found.closed > least))
        return seen and found.fall > context.least_fall(options, size)

    own = {EFFECTS[name].driver for name in state.present}
    # What is left must not be about as large as what was named, however small both are.
    beside_names = np.maximum(FAINTEST, LEFT_BESIDE * context.closed) if state.added else material

    def least(curve: Curve) -> FloatArray:
        is_own = bool(called(curve.place, names) & own)
        usual = np.maximum(material, options.own_form_error * context.closed) if is_own else material
        return np.minimum(usual, beside_names)

    admitted = [curve.place for curve in curves if admits(curve.judged, curve.size, least(curve))]
    if admitted:
        return admitted
    stretched = never_overcome(bench, ranges, options)
    if stretched:
        effect = EFFECTS[stretched[0].owner]
        return [Place(port=effect.port, driver=effect.driver, region=None, share=0.0)]
    for i in pressed(bench.state.fit, state.added):
        parameter = state.fit.parameters[i]
        effect = EFFECTS[parameter.owner]
        judged = bench.judge(bench.sharp.jacobian[:, [i]], bench.state.fit.jacobian[:, [i]], (i,))
        unseen = effect.limits is not None and parameter.name in effect.limits(ranges)
        if admits(judged, 1, material) or (unseen and judged.fall > context.alarm(options)):
            return [Place(port=effect.port, driver=effect.driver, region=None, share=share_of(bench, judged))]
    if context.repeat_noise is not None and curves:
        left = bench.excess
        part = options.chaotic_left_gap if state.is_chaotic else options.left_gap
        least_left = np.maximum(options.left_noise, options.left_signal * context.signal)
        if np.any(left > np.maximum(least_left, part * context.gap)):
            return [curves[0].place]
    return []


def significant_left(bench: Bench, curves: Sequence[Curve], options: SearchOptions) -> FloatArray:
    """Return what the largest significant curve would close, rms by output in noise of one sample, shape (C,)."""
    least_fall = bench.context.least_fall
    seen = (one.judged.closed for one in curves if one.judged.fall > least_fall(options, one.size))
    return np.asarray(np.max([np.zeros_like(bench.excess), *seen], axis=0))


def seen_again(curves: Sequence[Curve], doubts: Sequence[Place]) -> Place | None:
    """Return where most shows; of places that show about as much, the one that was plainest beside the named laws."""
    if not curves:
        return doubts[0] if doubts else None
    best = curves[0].place
    near = [one.place for one in curves if one.judged.fall > 0.0 and one.place.share >= ABOUT * best.share]
    again = (one for doubt in doubts for one in near if (one.port, one.driver) == (doubt.port, doubt.driver))
    return next(again, best)


def pressed(fit: Fit, owners: tuple[str, ...]) -> list[int]:
    """Return which parameters of these effects sit on a bound that the data would cross."""
    gradient = fit.jacobian.T @ fit.residual
    found = []
    for i, p in enumerate(fit.parameters):
        value, near = float(fit.vector[p.slot]), 1e-6
        below = value <= p.lower + near * max(abs(p.lower), near) and gradient[i] < 0.0
        above = value >= p.upper - near * abs(p.upper) and gradient[i] > 0.0
        # A spring at its stiffest is rigid: the bound says what a fit can resolve, not what a joint can be.
        rigid = above and p.owner != BASE and _kind(p.owner, p.name) is Kind.STIFFNESS
        if p.owner in owners and (below or above) and not rigid:
            found.append(i)
    return found


def never_overcome(bench: Bench, ranges: Ranges, options: SearchOptions) -> list[FitParameter]:
    """Return the levels of friction that could as well be as large as the motor's torque: none was ever seen to slide.

    What only stretched and never slid is a spring.
    """
    found, fitted = [], bench.state.fit
    for parameter in fitted.parameters:
        limits = EFFECTS[parameter.owner].limits if parameter.owner in bench.state.added else None
        if limits is None or parameter.name not in limits(ranges):
            continue
        if _kind(parameter.owner, parameter.name) is not Kind.TORQUE:
            continue
        vector = fitted.vector.copy()
        vector[parameter.slot] = parameter.upper
        rest = [one for one in fitted.parameters if one is not parameter]
        largest = fit(bench.problem, rest, vector, fitted.starts, _REFIT_STEPS)
        if largest.loss - fitted.loss <= options.doubt * bench.unit:
            found.append(parameter)
    return found


def _kind(owner: str, name: str) -> Kind:
    return next(p.kind for p in EFFECTS[owner].parameters if p.name == name)
