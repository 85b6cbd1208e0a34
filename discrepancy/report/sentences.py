"""The answer in sentences, for the page's first screen and for the terminal: plain text, no markup."""

import math
import re
from collections.abc import Iterator
from pathlib import PurePath

from discrepancy.effects.spec import Port
from discrepancy.effects.table import EFFECTS
from discrepancy.locate import Place
from discrepancy.model.schema import Quantity
from discrepancy.report import numbers
from discrepancy.report.plain import (
    called,
    called_together,
    join_words,
    parameter_meaning,
    parameter_name,
    quantity_name,
)
from discrepancy.result import GapResult, ResultStep

FLOOR_DOUBT = 0.7
"""An error below this part of the noise floor says that the floor is wrong."""
_LABEL = re.compile(r"^(train|test)\[(\d+)\]$")
_PORTS = {
    Port.TORQUE: "a torque",
    Port.CURRENT: "an error between the commanded and the acting current",
    Port.SENSOR: "an error of the sensor",
}


def headline(result: GapResult) -> str:
    """Return the verdict in one sentence."""
    if result.verdict == "none":
        return "Nothing is missing: the model explains the test data down to the noise."
    if result.verdict == "named":
        names = join_words([called(name) for name in result.effects])
        return f"The model lacks {names}; with that, nothing that matters is left."
    return "Something is missing that no effect of the catalogue explains."


def record_name(label: str) -> str:
    """Return what a record is called: its file's name, or its place if it has none."""
    match = _LABEL.match(label)
    if match is None:
        return PurePath(label).name
    return f"{'test' if match[1] == 'test' else 'training'} record {int(match[2]) + 1}"


def place_words(place: Place) -> str:
    """Return where a disagreement is, as a phrase."""
    driver = quantity_name(place.driver)
    return f"{_PORTS[place.port]} that follows the {driver}"


def region_words(place: Place) -> str:
    """Return the region of a place as numbers with their unit; where it is everywhere, say so.

    The region holds 80 % of what the curve explains.
    """
    if place.region is None:
        return "over its whole range"
    low, high = (numbers.significant(v, 2) for v in place.region)
    return f"mostly from {low} to {high} {numbers.output_unit(place.driver)}".rstrip()


def unknown_words(place: Place) -> str:
    """Return what is known about the part without a name."""
    return (
        f"It acts as {place_words(place)}; the {quantity_name(place.driver)} alone predicts "
        f"{numbers.percent(place.share)} of what is unexplained ({region_words(place)})."
    )


def spline_words(result: GapResult) -> str:
    """Return what a curve without a name would do; for answers that have one."""
    if result.spline is None:
        return ""
    return (
        f"A fitted curve of the torque over the {quantity_name(result.spline.driver)}, which names nothing, brings the "
        f"gap on test data from {numbers.percent(result.gap_after)} to {numbers.percent(result.spline.gap_after)}; "
        "its points stand in gap.json under unknown.spline, for use until the cause is understood."
    )


def gap_size(step: ResultStep, output: str, floor: float) -> float:
    """Return the rms gap of an output on test data in its unit: the error without what noise explains."""
    return math.sqrt(max(0.0, step.test[output].rmse ** 2 - floor**2))


def output_figures(result: GapResult) -> Iterator[str]:
    """Yield for each output how large the gap was and is, in units and in % of the signal."""
    for output, first in result.steps[0].test.items():
        unit, floor = numbers.output_unit(output), result.noise_floor.get(output, 0.0)
        last = result.steps[-1].test[output]
        before = gap_size(result.steps[0], output, floor)
        start = f"{quantity_name(output)}: "
        size = f"{numbers.significant(before)} {unit} ({numbers.percent(first.gap)} of the signal)"
        if first.gap == 0.0:
            size = f"below the noise floor of {numbers.significant(floor)} {unit}"
        if len(result.steps) == 1:
            yield f"{start}gap {size}; error {_error(first.rmse, unit)}, noise {_error(floor, unit)}"
        else:
            yield f"{start}gap {size} before, {_after(result, output, last.gap)}"


def _error(value: float, unit: str) -> str:
    return f"{numbers.significant(value)} {unit}".rstrip()


def _after(result: GapResult, output: str, gap: float) -> str:
    unit, floor = numbers.output_unit(output), result.noise_floor.get(output, 0.0)
    if gap == 0.0:
        return f"below the noise floor of {_error(floor, unit)} after"
    left = gap_size(result.steps[-1], output, floor)
    return f"{_error(left, unit)} ({numbers.percent(gap)}) after"


def closed_words(result: GapResult) -> str | None:
    """Return which part of the gap is closed, None where nothing was added."""
    if result.gap_closed is None or len(result.steps) == 1:
        return None
    if result.gap_after == 0.0:
        return "the whole gap is closed: what is left is below the noise floor"
    if result.gap_closed < 0.0:
        return "the gap on the test data has grown: do not use the extended model there"
    return f"{numbers.percent(result.gap_closed)} of the gap is closed"


def known_values(name: str, result: GapResult) -> dict[str, str]:
    """Return those fitted values of an effect that the data determine, by what the parameter means."""
    term = next((t for t in result.terms if t.id == name), None)
    found = {} if term is None else {k: q for k, q in term.parameters.items() if not q.fixed}
    return {
        parameter_meaning(name, key): numbers.quantity(q) + (" (poorly known)" if poorly_known(q) else "")
        for key, q in found.items()
    }


def poorly_known(q: Quantity) -> bool:
    """Return whether the standard error is larger than half the value."""
    return q.std is not None and q.std > 0.5 * abs(q.value)


def effect_values(name: str, result: GapResult) -> dict[str, str]:
    """Return the fitted values of an effect of the final model with errors and units, by parameter."""
    term = next((t for t in result.terms if t.id == name), None)
    return {} if term is None else {key: numbers.quantity(q) for key, q in term.parameters.items()}


def floor_doubts(result: GapResult) -> Iterator[str]:
    """Yield a warning for each output whose error is far below what was taken for its noise."""
    for output, score in result.steps[-1].test.items():
        floor, unit = result.noise_floor.get(output, 0.0), numbers.output_unit(output)
        if score.rmse < FLOOR_DOUBT * floor:
            yield (
                f"the error of the {quantity_name(output)} on the test data, {_error(score.rmse, unit)}, is well "
                f"below the noise floor of {_error(floor, unit)}: the floor is estimated too high (the noise is not "
                "white, or it is smaller in the test record), so the true gap is larger than stated"
            )


def equivalent_words(result: GapResult) -> Iterator[tuple[str, str]]:
    """Yield for each named effect that is not alone: its name, and what this data cannot tell from it."""
    for step in result.steps[1:]:
        if step.equivalents and step.added in result.effects:
            others = [called_together(entry) for entry in step.equivalents]
            yield str(step.added), join_words(others, "or")


def change_words(result: GapResult) -> Iterator[str]:
    """Yield the nameplate values that the data correct."""
    for change in result.parameter_changes:
        unit = numbers.pretty_unit(result.base_model.parameters[change.parameter].unit)
        value = numbers.with_error(change.estimate, change.std)
        yield (
            f"{parameter_name(change.parameter)} is {value} {unit}, "
            f"not {numbers.significant(change.nameplate, 4)} {unit} as on the nameplate"
        )


def experiment_words(result: GapResult) -> str | None:
    """Return what to measure next, None where nothing is open."""
    plan = result.next_experiment
    if plan is None or not plan["excitation"]:
        return None
    excitation = plan["excitation"]
    settings = ", ".join(_setting(k, v) for k, v in excitation.items() if k != "kind")
    names = [called_together(one) for one in plan.get("answers", plan.get("separates", ()))]
    if "reveals" in plan:
        aim = "to see weaker effects than these records show"
    elif len(names) > 1:
        aim = f"to tell {join_words(names, 'from')} apart"
    else:
        aim = f"to measure {''.join(names)}"
    return f"{excitation['kind']}, {settings}, for {plan['duration_s']:g} s, {aim}"


def reason_words(result: GapResult) -> str:
    """Return what the next experiment is predicted to bring, the effects by their names."""
    why = str((result.next_experiment or {}).get("why", ""))
    for name in sorted(EFFECTS, key=len, reverse=True):
        why = why.replace(name, called(name))
    return why


def other_measurements(result: GapResult) -> Iterator[tuple[str, str]]:
    """Yield what no excitation tells apart, and the measurement that does."""
    plan = result.next_experiment or {}
    for one in plan.get("other_measurements", ()):
        names = join_words([called(name) for name in one["separates"]], "from")
        yield names, str(one["measurement"])


def measurement_words(result: GapResult) -> Iterator[str]:
    """Yield which other measurement would settle what no excitation does."""
    for names, what in other_measurements(result):
        yield f"no motion tells {names}: {what}"


def _setting(key: str, value: object) -> str:
    name, _, unit = key.rpartition("_")
    if isinstance(value, list):
        return f"{len(value)} {name.replace('_', ' ')} up to {numbers.trimmed(max(map(abs, value)))} {unit}"
    shown = numbers.trimmed(value) if isinstance(value, float) else str(value)
    if name and unit in ("A", "s", "Hz"):
        return f"{name.replace('_', ' ')} {shown} {unit}"
    return f"{key.replace('_', ' ')} {shown}"
