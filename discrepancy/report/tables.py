"""The tables of the page: parameters at every step, what was tried, what would have been seen, lineage."""

from collections.abc import Sequence
from html import escape

from discrepancy.effects.table import EFFECTS
from discrepancy.model.schema import Quantity
from discrepancy.report import numbers
from discrepancy.report.plain import called, does, parameter_meaning, parameter_name
from discrepancy.report.sentences import place_words, region_words
from discrepancy.result import GapResult, ResultStep


def table(head: Sequence[str], rows: Sequence[Sequence[str]], right: frozenset[int] = frozenset()) -> str:
    """Return a table; cells are HTML, columns in `right` hold numbers."""

    def cell(tag: str, k: int, text: str) -> str:
        scope = ' scope="col"' if tag == "th" else ""
        return f"<{tag}{scope}{' class=n' if k in right else ''}>{text}</{tag}>"

    top = "".join(cell("th", k, escape(text)) for k, text in enumerate(head))
    body = "".join(
        "<tr>" + "".join(cell("td", k, text) for k, text in enumerate(row)) + "</tr>" for row in rows
    )
    return f'<div class="wide"><table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table></div>'


def parameter_table(result: GapResult) -> str:
    """Return all parameters, one column a step: nameplate, recalibrated, and after each effect."""
    steps = result.steps
    head = [
        "parameter",
        "unit",
        "nameplate",
        "recalibrated",
        *(f"+ {called(str(s.added))}" for s in steps[1:]),
    ]
    rows = []
    for name, plate in result.base_model.parameters.items():
        cells = [_value(step.base.get(name), "held") for step in steps]
        rows.append([escape(parameter_name(name)), _unit(plate), numbers.significant(plate.value, 4), *cells])
    given = {term.id: term.parameters for term in result.base_model.effects}
    for effect in dict.fromkeys(name for step in steps for name in step.terms):
        keys = dict.fromkeys(key for step in steps for key in step.terms.get(effect, {}))
        for key in keys:
            values = [step.terms.get(effect, {}).get(key) for step in steps]
            known = next(q for q in values if q is not None)
            plate_value = given.get(effect, {}).get(key)
            first = "" if plate_value is None else numbers.significant(plate_value.value, 4)
            cells = [_value(q, "") for q in values]
            rows.append(
                [
                    f"{escape(called(effect))}: {escape(parameter_meaning(effect, key))}",
                    _unit(known),
                    first,
                    *cells,
                ]
            )
    return table(head, rows, frozenset(range(2, len(head))))


def _unit(q: Quantity) -> str:
    return escape(numbers.pretty_unit(q.unit))


def _value(q: Quantity | None, otherwise: str) -> str:
    if q is None:
        return otherwise
    return escape(numbers.with_error(q.value, None if q.fixed else q.std))


def score_table(result: GapResult) -> str:
    """Return the figures of every step on test and training data."""
    rows = []
    for step in result.steps:
        name = "base model, recalibrated" if step.added is None else f"+ {called(step.added)}"
        for output, score in step.test.items():
            unit, floor = numbers.output_unit(output), result.noise_floor.get(output, 0.0)
            rows.append(
                [
                    escape(name), escape(output), f"{numbers.significant(score.rmse)} {escape(unit)}",
                    numbers.percent(score.nrmse), _gap(score.gap, floor, unit),
                    numbers.percent(step.train[output].nrmse),
                ]
            )  # fmt: skip
    head = [
        "model",
        "output",
        "test: rms error",
        "of the signal",
        "gap beyond noise",
        "training: of the signal",
    ]
    return table(head, rows, frozenset({2, 3, 4, 5}))


def _gap(gap: float, floor: float, unit: str) -> str:
    if gap == 0.0:
        return f"below the noise floor of {numbers.significant(floor)} {escape(unit)}"
    return numbers.percent(gap)


def effect_details(step: ResultStep) -> str:
    """Return what the catalogue says of the effect of a step, and where the model before it was wrong."""
    name = str(step.added)
    effect = EFFECTS[name]
    seen = ", ".join(
        f"as {place_words(p)} ({region_words(p)}): {100 * p.share:.0f} %"
        for p in step.where
        if p.share >= 0.01
    )
    before = f"In the model before it the disagreement showed {seen}. " if seen else ""
    evidence = step.evidence
    proof = ""
    if isinstance(evidence.get("held_out_gain"), float) and isinstance(
        evidence.get("closed_in_noise"), float
    ):
        proof = (
            f"<p>It predicts data that were left out of the fit better by {evidence['held_out_gain']:.0f} "
            "noise variances (chance alone reaches about 30 among all that was tried) and closes an error of "
            f"{evidence['closed_in_noise']:.3g} times the noise of one sample.</p>"
        )
    return (
        f"<p>{escape(does(name)[:1].upper() + does(name)[1:])}. Equation: <code>{escape(effect.equation)}</code></p>"
        f"{proof}<p class=sub>{escape(before)}Reference: {escape(effect.reference)}.</p>"
    )


def rejected_table(result: GapResult) -> str:
    """Return every candidate that was tried and not taken, with its score and the reason in words."""
    if not result.rejected:
        return "<p>No other effect came near enough to be judged.</p>"
    rows = [
        [str(r.round + 1), escape(called(r.id)), _whole(r.fall), _small(r.closed), escape(r.reason)]
        for r in result.rejected
    ]
    head = ["round", "effect", "gain on left-out data", "error closed, in noise", "why not"]
    return table(head, rows, frozenset({0, 2, 3}))


def _whole(value: float) -> str:
    return f"{value:.0f}" if abs(value) >= 0.5 else "0"


def _small(value: float) -> str:
    return numbers.significant(value, 2) if value >= 0.001 else "below 0.001"


def detectable_table(result: GapResult) -> str:
    """Return how small each effect would have been seen."""
    rows = [
        [
            escape(called(one.id)), escape(parameter_meaning(one.id, one.parameter)),
            f"{numbers.significant(abs(one.size), 2)} {escape(numbers.pretty_unit(one.unit))}",
        ]
        for one in sorted(result.pictures.detectable, key=lambda one: called(one.id))
    ]  # fmt: skip
    return table(["effect", "its strength", "seen from about"], rows, frozenset({2}))


def lineage_list(result: GapResult) -> str:
    """Return the versions of the model, oldest first."""
    rows = []
    for entry in result.model.lineage:
        added = entry.get("added") or []
        names = [called(str(n)) for n in added] if isinstance(added, list | tuple) else [str(added)]
        then = f"then added: {', '.join(names)}" if names else "then recalibrated"
        rows.append(f"<li>Version {escape(str(entry.get('version', '?')))}, {escape(then)}</li>")
    rows.append(f"<li>Version {result.model.version}: <code>model.yaml</code> beside this page</li>")
    return f"<ol>{''.join(rows)}</ol>"
