"""The first screen: the verdict and four answers for somebody who knows motors, not statistics."""

from collections.abc import Iterator
from html import escape

from discrepancy.evaluate import Curve
from discrepancy.report import figures, sentences
from discrepancy.report.frame import frame
from discrepancy.report.plain import called, does, quantity_name
from discrepancy.report.thin import worst_stretch
from discrepancy.result import GapResult

HERO = "stretch"
_BADGES = {"named": "NAMED", "none": "NOTHING MISSING", "unknown": "UNKNOWN"}


def first_screen(result: GapResult) -> str:
    """Return the verdict, the answers and the picture."""
    rows = "".join(f"<dt>{escape(title)}</dt><dd>{body}</dd>" for title, body in _facts(result))
    return (
        f'<h1>Gap report: {escape(result.base_model.name)}</h1><div class="{result.verdict}">'
        f'<p class="verdict"><span class="badge">{_BADGES[result.verdict]}</span>'
        f"{escape(sentences.headline(result))}</p></div>"
        f'<div class="first"><dl class="facts">{rows}</dl>{_picture(result)}</div>'
    )


def _facts(result: GapResult) -> Iterator[tuple[str, str]]:
    yield "What is missing?", _missing(result)
    yield "How big is it?", _size(result)
    yield "What else could it be?", _alternatives(result)
    yield "What to measure next?", _next(result)
    changes = list(sentences.change_words(result))
    if changes:
        yield "What else is off?", _items([_capital(change) + "." for change in changes])


def _missing(result: GapResult) -> str:
    found = [_named(name, result) for name in result.effects]
    if result.unknown is not None:
        shape = f"<b>Something without a name.</b> {escape(sentences.unknown_words(result.unknown))}"
        doubt = (
            "<p>Beside it these laws describe the data best so far; they may be wrong:</p>" if found else ""
        )
        return f"{shape}{doubt}{_items(found) if found else ''}"
    if not found:
        return (
            "Nothing that these records could show. How small an effect they would have shown stands "
            '<a href="#seen">below</a>.'
        )
    return _items(found)


def _named(name: str, result: GapResult) -> str:
    values = ", ".join(
        f"{meaning} {value}" for meaning, value in sentences.known_values(name, result).items()
    )
    return (
        f"<b>{escape(_capital(called(name)))}</b>: {escape(does(name))}."
        f'<br><span class="sub">{escape(_capital(values))}</span>'
    )


def _size(result: GapResult) -> str:
    lines = [escape(_capital(line)) + "." for line in sentences.output_figures(result)]
    closed = sentences.closed_words(result)
    if closed is not None:
        lines.append(f"<b>{escape(_capital(closed))}</b>, on records that were not used for fitting.")
    return _items(lines)


def _alternatives(result: GapResult) -> str:
    lines = [
        f"What is called {escape(called(name))} here could as well be <b>{escape(others)}</b>: "
        "this data cannot tell them apart."
        for name, others in sentences.equivalent_words(result)
    ]
    if lines:
        return _items(lines)
    if result.verdict == "unknown":
        return "No law of the catalogue fits the part without a name; its shape is drawn below."
    if result.verdict == "none":
        return "Nothing was found, so nothing has to be told apart."
    return "Nothing in the catalogue: every other effect predicts the held-out data worse."


def _next(result: GapResult) -> str:
    words = sentences.experiment_words(result)
    more = [f"No motion tells {names}: <b>{what}</b>." for names, what in _measurements(result)]
    if words is not None:
        reason = escape(_capital(sentences.reason_words(result)))
        return _items([f'{escape(_capital(words))}.<br><span class="sub">{reason}.</span>', *more])
    if more:
        return _items(more)
    if result.verdict == "unknown":
        place = result.unknown
        driver = "the motion" if place is None else f"the {quantity_name(place.driver)}"
        return f"No proposal. A record that varies {escape(driver)} slowly, alone, shows the shape best."
    if result.verdict == "none":
        return "No record within these limits would show much weaker effects than the records so far do."
    return "Nothing is open that another experiment would settle."


def _measurements(result: GapResult) -> Iterator[tuple[str, str]]:
    """Yield what no excitation tells apart, and the other measurement that does, as HTML."""
    for names, what in sentences.other_measurements(result):
        yield escape(names), escape(what)


def _picture(result: GapResult) -> str:
    pairs = list(zip(result.steps[0].curves, result.steps[-1].curves, strict=True))
    if not pairs:
        return "<p>No curves were kept.</p>"
    pair = max(pairs, key=lambda p: _relative_error(p[0]))
    span = worst_stretch(pair[0])
    name, quantity = sentences.record_name(pair[0].label), quantity_name(pair[0].name)
    when = f"from {span[0]:.3g} to {span[1]:.3g} s of {name}"
    alt = f"Measured {quantity} {when}, with the base model" + (
        " and the extended model." if len(result.steps) > 1 else "."
    )
    caption = f"Test data, {when}: where the base model is furthest off."
    return frame(figures.stretch(result, pair, span), HERO, alt, caption)


def _relative_error(curve: Curve) -> float:
    error = curve.measured - curve.simulated
    return float(error.std() / max(float(curve.measured.std()), 1e-300))


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def _items(lines: list[str]) -> str:
    if len(lines) == 1:
        return lines[0]
    return "<ul>" + "".join(f"<li>{line}</li>" for line in lines) + "</ul>"
