"""Make the answer of what the search accepted: parameters with errors, figures at full rate, the extended model."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from discrepancy.design.detectable import detectable_effects
from discrepancy.design.limits import RigLimits
from discrepancy.effects.spec import Port
from discrepancy.effects.table import EFFECTS
from discrepancy.evaluate import Curve, Scorer, score_curves
from discrepancy.fitting.parameters import BASE, NUISANCES
from discrepancy.locate import Place
from discrepancy.model.schema import BASE_SLOTS, EffectTerm, JointModel, Quantity
from discrepancy.report.law import LawMaker
from discrepancy.report.pictures import Detectable, Pictures
from discrepancy.report.spectra import noise_spectra
from discrepancy.result import GapResult, NamelessTerm, ParameterChange, Rejected, ResultStep, total_gap
from discrepancy.search.bench import Bench
from discrepancy.search.known import beyond_motion
from discrepancy.search.open_questions import next_question
from discrepancy.search.options import SearchOptions
from discrepancy.search.outcome import SearchOutcome, Step
from discrepancy.search.spline import SplineTerm, fit_spline
from discrepancy.search.standard_errors import robust_covariance, standard_errors
from discrepancy.search.state import State
from discrepancy.simulation import slots as s

CHANGE_SIGMAS = 4.0
"""A nameplate value counts as changed beyond this many standard errors and beyond 1 %."""


def quantities(
    outcome: SearchOutcome, step: Step, bench: Bench | None, model: JointModel
) -> dict[tuple[str, str], Quantity]:
    """Return all fitted and constant parameters with standard errors, by (owner, name)."""
    state, errors = step.state, step.errors
    if errors is None:
        errors = standard_errors(outcome.problem, state.fit, (bench, outcome.ranges))
    column = 1 if model.is_linear_axis else 0
    found: dict[tuple[str, str], Quantity] = {}
    for i, parameter in enumerate(state.fit.parameters):
        value = float(state.fit.vector[parameter.slot])
        std = math.hypot(float(errors[i]), step.apart.get(parameter.slot, 0.0))
        unit = model.parameters[parameter.name].unit if parameter.name in model.parameters else ""
        found[parameter.owner, parameter.name] = Quantity(value=value, std=std, unit=unit)
    for name in state.present:
        for p in EFFECTS[name].parameters:
            known = found.get((name, p.name))
            unit = p.kind.value[column]
            value = float(state.fit.vector[p.slot])
            if abs(value) < 1e29:
                found[name, p.name] = Quantity(
                    value=value, unit=unit, std=known.std if known else None, fixed=known is None
                )
    return found


def extended_model(model: JointModel, values: dict[tuple[str, str], Quantity], state: State) -> JointModel:
    """Return the model with recalibrated parameters and added effects, one version on."""
    parameters = {}
    for name, quantity in model.parameters.items():
        fitted = values.get((BASE, name))
        parameters[name] = quantity if fitted is None else replace(fitted, unit=quantity.unit)
    terms = tuple(
        EffectTerm(id=name, parameters={n: q for (owner, n), q in values.items() if owner == name})
        for name in state.present
    )
    entry = {
        "version": model.version,
        "added": list(state.added),
        "parameters": {n: q.value for n, q in model.parameters.items()},
    }
    return replace(
        model,
        parameters=parameters,
        effects=terms,
        version=model.version + 1,
        lineage=(*model.lineage, entry),
    )


def parameter_changes(
    model: JointModel, values: dict[tuple[str, str], Quantity]
) -> tuple[ParameterChange, ...]:
    """Return the nameplate values that the data correct materially."""
    found = []
    for name, quantity in model.parameters.items():
        fitted = values.get((BASE, name))
        if fitted is None or fitted.std is None:
            continue
        far = abs(fitted.value - quantity.value)
        if far > CHANGE_SIGMAS * fitted.std and far > 0.01 * abs(quantity.value):
            found.append(
                ParameterChange(
                    parameter=name, nameplate=quantity.value, estimate=fitted.value, std=fitted.std
                )
            )
    return tuple(found)


def column_names(model: JointModel) -> dict[str, str]:
    """Return what the drivers are called in this model's recordings."""
    linear = model.is_linear_axis
    return {
        "speed": "speed_m_s" if linear else "speed_rad_s",
        "position": "position_m" if linear else "position_rad",
        "input": model.input,
        "acceleration": "acceleration_m_s2" if linear else "acceleration_rad_s2",
        "time": "time_s",
    }


@dataclass(frozen=True, slots=True, kw_only=True)
class Scored:
    """Curves of one model at full rate."""

    train: Sequence[Curve]
    test: Sequence[Curve]


def result_step(
    step: Step,
    values: Mapping[tuple[str, str], Quantity],
    places: Sequence[Place],
    curves: Scored,
    floor: dict[str, float],
) -> ResultStep:
    """Give the figures of one accepted model; `places` is where the one before it disagreed."""
    owner = step.added or BASE
    first = list(places[:3])
    if step.added is not None:
        first = _own_place_first(step.added, first)
    evidence: dict[str, float | int | str] = {
        "held_out_gain": step.fall,
        "closed_in_noise": float(np.max(step.closed)),
    }
    return ResultStep(
        added=step.added,
        parameters={name: q for (own, name), q in values.items() if own == owner and name not in NUISANCES},
        equivalents=step.equivalents,
        where=tuple(first),
        evidence=evidence,
        train=score_curves(curves.train, floor),
        test=score_curves(curves.test, floor),
        curves=tuple(curves.test),
        base={name: q for (own, name), q in values.items() if own == BASE and name not in NUISANCES},
        terms={
            term: {name: q for (own, name), q in values.items() if own == term} for term in step.state.present
        },
        places=tuple(places),
    )


def make_pictures(
    outcome: SearchOutcome,
    trained: Sequence[Curve],
    model: JointModel,
    floor: dict[str, float],
    left: Sequence[Place],
) -> Pictures:
    """Return what the report draws beyond the steps."""
    problem, last = outcome.problem, outcome.steps[-1].state
    series = problem.series
    repeated = () if outcome.is_torque else trained
    unknown = outcome.unknown
    detectable: tuple[Detectable, ...] = ()
    if outcome.verdict == "none" and not outcome.is_torque:
        detectable = detectable_effects(problem, last, SearchOptions(), outcome.context)
    return Pictures(
        noise=noise_spectra(repeated, series), left=tuple(left), detectable=detectable,
        unknown=None if unknown is None else law_maker(outcome, model).nameless(unknown),
    )  # fmt: skip


def law_maker(outcome: SearchOutcome, model: JointModel) -> LawMaker:
    """Return what draws the laws of the last model."""
    problem, last = outcome.problem, outcome.steps[-1].state
    covariance = robust_covariance(problem, last.fit)
    return LawMaker(problem=problem, state=last, covariance=covariance, linear=model.is_linear_axis)


def _own_place_first(name: str, places: Sequence[Place]) -> list[Place]:
    effect = EFFECTS[name]
    best = max((p.share for p in places if p.driver == effect.driver), default=0.0)
    region = next((p.region for p in places if p.driver == effect.driver), None)
    own = Place(port=Port(effect.port), driver=effect.driver, region=region, share=best)
    return [own, *(p for p in places if p.driver != effect.driver)]


def rejected_candidates(outcome: SearchOutcome, options: SearchOptions) -> tuple[Rejected, ...]:
    """Return every judged candidate that was not taken, with the reason."""
    found = []
    for i, one in enumerate(outcome.rounds):
        for contender in one.contenders:
            if one.winner is not None and contender.name == one.winner.name:
                continue
            if contender.fall <= options.alarm:
                reason = "does not predict the held-out blocks better"
            elif np.all(contender.closed <= options.material_noise):
                reason = "significant but too small to matter"
            else:
                reason = "helps, but less than the effect that was taken"
            found.append(
                Rejected(
                    round=i,
                    id=contender.name,
                    fall=contender.fall,
                    closed=float(np.max(contender.closed)),
                    reason=reason,
                )
            )
    return tuple(found)


def nameless(
    term: SplineTerm, scorer: Scorer, floor: dict[str, float], judged: Sequence[str]
) -> NamelessTerm:
    """Score a curve on the test records."""
    gap = total_gap(score_curves(scorer.test(term.vector), floor), judged)
    return NamelessTerm(driver=term.driver, points=term.points, gap_after=gap)


def assemble(
    model: JointModel,
    outcome: SearchOutcome,
    scorer: Scorer,
    rest: tuple[dict[str, float], Sequence[str], RigLimits | None],
) -> GapResult:
    """Return the answer.

    Args:
        model: as the question named it.
        outcome: the finished search.
        scorer: judges a model on the records.
        rest: noise floor by output, notes for the user, and limits of the rig if it is known.
    """
    floor, notes, limits = rest
    scored = [
        Scored(train=scorer.train(step.state.fit.vector), test=scorer.test(step.state.fit.vector))
        for step in outcome.steps
    ]
    benches = [outcome.bench(step.state) for step in outcome.steps]
    places = [outcome.places(step.state, bench) for step, bench in zip(outcome.steps, benches, strict=True)]
    known = [
        quantities(outcome, step, bench, model) for step, bench in zip(outcome.steps, benches, strict=True)
    ]
    steps = [
        result_step(step, values, before, curves, floor)
        for step, values, before, curves in zip(
            outcome.steps, known, (places[0], *places[:-1]), scored, strict=True
        )
    ]
    term = None
    if outcome.unknown is not None:
        last_state = outcome.steps[-1].state
        term = fit_spline(outcome.problem, last_state, outcome.ranges, outcome.unknown, outcome.names)
    laws = law_maker(outcome, model)
    steps = [step if step.added is None else replace(step, law=laws.named(step.added)) for step in steps]
    last = outcome.steps[-1]
    judged = [name for name in model.outputs if name in steps[0].test] or list(steps[0].test)
    values = known[-1]
    new = extended_model(model, values, last.state)
    changes = parameter_changes(model, values)
    if model.input == "current_A" and any(BASE_SLOTS[c.parameter] == s.TORQUE_CONSTANT for c in changes):
        # One number: nothing but the reading of the current and the torque that it stands for.
        steps[0] = replace(steps[0], equivalents=("current_sensor_gain",))
    return GapResult(
        verdict=outcome.verdict,
        effects=last.state.added,
        unknown=outcome.unknown,
        parameter_changes=changes,
        gap_before=total_gap(steps[0].test, judged),
        gap_after=total_gap(steps[-1].test, judged),
        noise_floor=floor,
        steps=tuple(steps),
        next_experiment=next_question(outcome, limits, values),
        base_model=model,
        model=new,
        rejected=rejected_candidates(outcome, SearchOptions()),
        notes=(*notes, *outcome.notes, *beyond_motion(outcome, values)),
        terms=new.effects,
        spline=None if term is None else nameless(term, scorer, floor, judged),
        pictures=make_pictures(outcome, scored[-1].train, model, floor, places[-1]),
    )
