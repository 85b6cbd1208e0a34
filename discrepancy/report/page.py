"""The report as one self-contained HTML page: the first screen for everybody, then the evidence behind it."""

from collections.abc import Iterator
from html import escape

from plotly.offline import get_plotlyjs

from discrepancy.model.schema import Judge
from discrepancy.report import figures, law_figures, tables
from discrepancy.report.first_screen import first_screen
from discrepancy.report.frame import frame, zoom_buttons
from discrepancy.report.plain import called, quantity_name
from discrepancy.report.sentences import (
    floor_doubts,
    place_words,
    record_name,
    region_words,
    spline_words,
    unknown_words,
)
from discrepancy.report.style import SCRIPT, STYLE
from discrepancy.report.thin import worst_stretch
from discrepancy.result import GapResult

FAINT_SHARE = 0.05
"""Below this share a trace is not worth drawing: chance and the noise of the measured speed make as much."""
Section = tuple[str, str, str]
"""Anchor, title, body as HTML."""


def render_report(result: GapResult) -> str:
    """Return the page."""
    sections = list(_sections(result))
    links = "".join(f'<a href="#{key}">{escape(title)}</a> ' for key, title, _ in sections)
    bodies = "\n".join(
        f'<section aria-labelledby="{key}"><h2 id="{key}">{escape(title)}</h2>{body}</section>'
        for key, title, body in sections
    )
    return "\n".join(
        [
            "<!doctype html><html lang='en'><head><meta charset='utf-8'>",
            "<meta name='viewport' content='width=device-width, initial-scale=1'>",
            f"<title>Gap report: {escape(result.base_model.name)}</title><style>{STYLE}</style>",
            f"<script>{get_plotlyjs()}</script></head><body><main>",
            first_screen(result),
            f'<nav aria-label="Sections">{links}</nav>',
            bodies,
            f"</main><script>{SCRIPT}</script></body></html>",
        ]
    )


def _sections(result: GapResult) -> Iterator[Section]:
    yield "map", "Where the simulation was wrong", _residual_map(result)
    title = "How the gap shrank" if result.steps[1:] else "How large the error is"
    yield "stairs", title, _staircase(result)
    if result.steps[1:]:
        yield "laws", "What was added", _laws(result)
    if result.unknown is not None:
        yield "shape", "The part without a name", _unknown(result)
    if result.verdict == "none":
        yield "seen", "What would have been seen", _detectable(result)
    yield "curves", "Before and after, over time and frequency", _curves(result)
    yield "parameters", "Parameters at every step", _parameters(result)
    yield "rejected", "What was tried and rejected", _rejected(result)
    yield "lineage", "Where this model comes from", tables.lineage_list(result)
    yield "notes", "What to know about the data", _notes(result)


def _residual_map(result: GapResult) -> str:
    before = result.steps[0].places or result.steps[0].where
    if not before:
        return "<p>The records hold no position and no speed over which the error could be drawn.</p>"
    unit = "N" if result.base_model.is_linear_axis else "N m"
    output = next(iter(result.steps[0].test), "")
    after = result.pictures.left if len(result.steps) > 1 else ()
    listed = "; ".join(f"{place_words(p)}: {100 * p.share:.0f} %" for p in before)
    if before[0].share <= FAINT_SHARE:
        most = max(1.0, 100 * before[0].share)
        return f"<p>No variable explains what is left: none predicts more than {most:.0f} % of it.</p>"
    words = (
        f"<p>Before anything was added, the strongest trace is {escape(place_words(before[0]))} "
        f"({escape(region_words(before[0]))}). Several traces may show the same error, because the variables "
        "move together; a trace is a hint, and names are given only by fitting every effect.</p>"
    )
    parts = [words, frame(
        law_figures.shares(before, after, _left(result)), "shares", f"Shares of the disagreement. {listed}.",
        "Each bar: the share of the base model’s squared error that a curve over this one variable predicts on data "
        "it was not fitted to.",
    )]  # fmt: skip
    curves = law_figures.curves(before, unit, output)
    if curves is not None:
        caption = "What the recalibrated base model misses, over the variables with the largest shares."
        parts.append(frame(curves, "places", f"Curves of the missing torque. {listed}.", caption))
    return "".join(parts)


def _left(result: GapResult) -> float:
    """Return the part of the squared error on the training records that the last model leaves."""
    first, last = result.steps[0].train, result.steps[-1].train
    parts = [(last[name].rmse / max(first[name].rmse, 1e-300)) ** 2 for name in first]
    return min(1.0, sum(parts) / max(1, len(parts)))


def _staircase(result: GapResult) -> str:
    alt = "; ".join(
        f"{'base model' if s.added is None else called(s.added)}: "
        + ", ".join(f"{quantity_name(o)} {100 * v.nrmse:.2f} %" for o, v in s.test.items())
        for s in result.steps
    )
    caption = (
        "Error on test records, which were not used for fitting. The axis is logarithmic. "
        "The dotted line is the noise of the measurement, as far as the records show it."
    )
    if len(result.steps) == 1:
        words = "Nothing was added. Error and noise on the test records, which were not used for fitting:"
        return f"<p>{words}</p>{tables.score_table(result)}"
    drawn = frame(figures.staircase(result), "stairs-figure", f"Error on test data. {alt}.", caption)
    return drawn + tables.score_table(result)


def _laws(result: GapResult) -> str:
    parts = []
    for k, step in enumerate(result.steps[1:]):
        name = called(str(step.added))
        parts.append(f"<h3>{escape(name[:1].upper() + name[1:])}</h3>")
        if step.law is not None:
            alt = f"{step.law.y_name} over {step.law.x_name}: measured means with error bars, and the law of {name}."
            caption = (
                f"Dots: what the model without {name} leaves, as measured on the training records and averaged; "
                "bars: 95 % intervals of these means. Line: the fitted law; band: 95 %, from the "
                "errors of its parameters. Samples at rest are left out."
            )
            parts.append(frame(law_figures.law(step.law, name), f"law-{k}", alt, caption))
        parts.append(tables.effect_details(step))
    return "".join(parts)


def _unknown(result: GapResult) -> str:
    place, picture = result.unknown, result.pictures.unknown
    if place is None:
        return ""
    parts = [f"<p>{escape(unknown_words(place))}</p>"]
    if result.spline is not None:
        parts.append(f"<p>{escape(spline_words(result))}</p>")
    if picture is not None:
        alt = f"{picture.y_name} over {picture.x_name}, measured means with error bars."
        caption = (
            "What the last model leaves, as measured on the training records and averaged, with 95 % intervals. "
            "No law of the catalogue has this shape."
        )
        parts.append(frame(law_figures.law(picture, "unknown"), "unknown-figure", alt, caption))
    return "".join(parts)


def _detectable(result: GapResult) -> str:
    if not result.pictures.detectable:
        return "<p>Judged by torque, or nothing could be computed: see what was tried below.</p>"
    return (
        "<p>“Nothing is missing” is worth as much as the data. In these records each effect would have been seen, and "
        "its name asked for, from about this strength on (expected for the noise found here; an estimate, good to "
        "about a factor of two). Effects with a limit or a gap instead of a strength are not in the list.</p>"
        + tables.detectable_table(result)
    )


def _curves(result: GapResult) -> str:
    parts = []
    pairs = list(zip(result.steps[0].curves, result.steps[-1].curves, strict=True))
    for k, pair in enumerate(pairs):
        first = pair[0]
        name = f"{record_name(first.label)}: {quantity_name(first.name)}"
        span = worst_stretch(first)
        whole = (float(first.time_s[0]), float(first.time_s[-1]))
        key = f"time-{k}"
        alt = f"{name}, measured and simulated over time, and the errors below."
        caption = "Above: the signals. Below: the errors; the band holds 95 % of pure measurement noise."
        tools = zoom_buttons(key, [("Whole record", whole), ("Worst stretch", span)])
        parts.append(
            f"<h3>{escape(name)}</h3>" + frame(figures.over_time(result, pair), key, alt, caption, tools)
        )
        alt = f"{name}, spectrum of the error before and after, and of the noise."
        caption = (
            "Where the curve lies on the noise, the model has nothing left to explain at that frequency."
        )
        parts.append(frame(figures.spectra(result, pair), f"spectrum-{k}", alt, caption))
    return "".join(parts) or "<p>No curves were kept.</p>"


def _parameters(result: GapResult) -> str:
    return (
        "<p>Value ± standard error. “held” parameters stay at the nameplate. The joint’s own parameters move when an "
        "effect is added: what the base model had to stretch is let go.</p>" + tables.parameter_table(result)
    )


def _rejected(result: GapResult) -> str:
    return (
        "<p>Gain on left-out data: by how much the effect predicts blocks of data that its fit did not see better than "
        "the model before, in noise variances; by chance the best of all tries reaches about 30. Error closed: the rms "
        "of what it explains, in units of the noise of one sample.</p>" + tables.rejected_table(result)
    )


def _notes(result: GapResult) -> str:
    notes = [*result.notes, *(text[:1].upper() + text[1:] + "." for text in floor_doubts(result))]
    if result.base_model.judge_by is Judge.TORQUE:
        notes.append("Judged by torque: measured motion, the torque it needs compared with the motor's.")
    for output, floor in result.noise_floor.items():
        source = "from repeated records" if output in result.pictures.noise else "estimated from the residual"
        notes.append(f"Noise floor of {output}: {floor:.3g} (standard deviation of one sample), {source}.")
    return "<ul>" + "".join(f"<li>{escape(note)}</li>" for note in notes) + "</ul>"
