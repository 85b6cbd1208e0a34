"""The report as one self-contained HTML page. The first screen is for people who know motors, not statistics."""

from html import escape

import plotly.io as pio

from discrepancy.effects.table import EFFECTS
from discrepancy.report import figures
from discrepancy.result import GapResult, ResultStep

_STYLE = """
body{font:16px/1.5 system-ui,sans-serif;max-width:1080px;margin:2rem auto;padding:0 1rem;color:#1c2430}
h1{font-size:1.7rem;margin-bottom:.2rem}h2{margin-top:2.2rem;border-bottom:1px solid #d5dbe3}
.answer{background:#f1f5fa;border-left:6px solid #2563a8;padding:1rem 1.2rem;font-size:1.1rem}
table{border-collapse:collapse;width:100%}td,th{padding:.3rem .6rem;border-bottom:1px solid #e3e7ec;text-align:left}
td.n{text-align:right;font-variant-numeric:tabular-nums}.small{color:#5a6472;font-size:.9rem}
"""


def render_report(result: GapResult) -> str:
    """Return the page."""
    parts = [
        "<!doctype html><html lang='en'><head><meta charset='utf-8'>",
        "<meta name='viewport' content='width=device-width, initial-scale=1'>",
        f"<title>Gap report: {escape(result.base_model.name)}</title><style>{_STYLE}</style></head><body>",
        f"<h1>Where simulation and measurement part: {escape(result.base_model.name)}</h1>",
        f"<div class='answer'>{_answer(result)}</div>",
        _embed(figures.staircase(result), first=True),
        "<h2>Before and after, on the test record</h2>",
        _embed(figures.before_after(result)),
        _embed(figures.spectra(result)),
        "<h2>Where the simulation was wrong</h2>",
        _embed(figures.residual_map(result)),
        "<h2>What was added</h2>",
        *(_step_table(step) for step in result.steps),
        "<h2>What was tried and rejected</h2>",
        _rejected(result),
        "<h2>What to know about the data</h2>",
        "<ul>" + "".join(f"<li>{escape(note)}</li>" for note in result.notes) + "</ul>"
        if result.notes
        else "<p>Nothing unusual.</p>",
        "</body></html>",
    ]
    return "\n".join(parts)


def _embed(figure: object, *, first: bool = False) -> str:
    html = pio.to_html(figure, full_html=False, include_plotlyjs=first, config={"displaylogo": False})
    return str(html)


def spoken(name: str) -> str:
    """Return an effect's id as words."""
    return name.replace("_", " ")


def _answer(result: GapResult) -> str:
    """Return the answer in sentences."""
    words = []
    if result.verdict == "none":
        words.append(
            "<b>Nothing material is missing.</b> After recalibration the model reproduces the test record down "
            "to its noise."
        )
    if result.effects:
        names = ", then ".join(f"<b>{spoken(name)}</b>" for name in result.effects)
        words.append(f"The model lacked {names}.")
    if result.unknown is not None:
        where = result.unknown
        words.append(
            f"<b>Something else is missing that the catalogue does not know.</b> It acts as a "
            f"{where.port.value} error and "
            f"follows {escape(where.driver)}, which predicts {where.share:.0%} of what is left."
        )
    if result.gap_closed is not None:
        words.append(
            f"On a test record that was not used for fitting, the gap fell from {result.gap_before:.2%} to "
            f"{result.gap_after:.2%} "
            f"of the signal: {result.gap_closed:.1%} of it is closed."
        )
    words.extend(
        f"The nameplate's {spoken(change.parameter)} {change.nameplate:.4g} is really {change.estimate:.4g} "
        f"(± {change.std:.2g})."
        for change in result.parameter_changes
    )
    others = sorted({_equivalent(e) for step in result.steps for e in step.equivalents})
    if others:
        words.append(f"This data cannot tell it from: {', '.join(others)}.")
    return " ".join(words)


def _equivalent(entry: str | tuple[str, ...]) -> str:
    return spoken(entry) if isinstance(entry, str) else " with ".join(spoken(name) for name in entry)


def _step_table(step: ResultStep) -> str:
    title = "Recalibrated base model" if step.added is None else spoken(step.added).capitalize()
    equation = "" if step.added is None else f"<p><code>{escape(EFFECTS[step.added].equation)}</code></p>"
    rows = "".join(
        f"<tr><td>{escape(spoken(name))}</td><td class='n'>{q.value:.5g}</td>"
        f"<td class='n'>{'' if q.std is None else f'± {q.std:.2g}'}</td><td>{escape(q.unit)}</td></tr>"
        for name, q in step.parameters.items()
    )
    head = "<tr><th>parameter</th><th>value</th><th>std. error</th><th>unit</th></tr>"
    return f"<h3>{title}</h3>{equation}<table>{head}{rows}</table>"


def _rejected(result: GapResult) -> str:
    rows = "".join(
        f"<tr><td class='n'>{r.round + 1}</td><td>{spoken(r.id)}</td><td class='n'>{r.fall:.0f}</td>"
        f"<td class='n'>{r.closed:.3f}</td><td>{escape(r.reason)}</td></tr>"
        for r in result.rejected
    )
    return (
        "<table><tr><th>round</th><th>effect</th><th>gain on held-out blocks</th><th>closed, in "
        "noise</th><th>why not</th></tr>"
        f"{rows}</table>"
    )
