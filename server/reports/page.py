"""The report of an identification: one HTML file with everything in it, readable without a network."""

from collections.abc import Iterable, Iterator
from html import escape

from estimators.result import IdentificationResult, Mode, Phase
from server.reports.charts import Chart
from server.reports.comparison import MODE_TITLES, Row, comparison_rows, describe_models, format_measure
from server.reports.interactive import chart_html, plotly_script
from server.services.dataset import PreparedData

STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; color: #1b1f24; }
body { margin: 2rem auto; max-width: 1100px; padding: 0 1rem; }
h1 { font-size: 1.6rem; margin-bottom: .2rem; } h2 { font-size: 1.2rem; margin-top: 2.2rem; }
p.sub { color: #57606a; margin-top: 0; }
ul.verdict { background: #f3f7fb; border-left: 4px solid #0072b2; padding: .8rem 1rem .8rem 2rem; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { padding: .25rem .8rem; text-align: right; border-bottom: 1px solid #d8dee4; }
th:first-child, td:first-child { text-align: left; }
tr.phase td { font-weight: 600; background: #f6f8fa; } tr.trivial td { color: #57606a; font-style: italic; }
dt { font-weight: 600; margin-top: .7rem; } dd { margin-left: 1.2rem; }
dd.formula { font-family: ui-monospace, monospace; }
.scroll { overflow-x: auto; } footer { color: #57606a; font-size: .85rem; margin-top: 3rem; }
"""


FRAME = """<!doctype html>
<html lang="en"><head><meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title><style>{style}</style>{script}</head>
<body>
{body}
</body></html>
"""
HINT = '<p class="sub">Drag to zoom, double-click to see all, click a name to hide it.</p>'
LEGEND = (
    "Adjusted R², 1 is perfect. "
    "<b>A priori</b>: predicted before the sample was used, parameters still adapting. "
    "<b>A posteriori</b>: the same sample after the update, which flatters an estimator that follows. "
    "<b>Frozen one-step</b>: final parameters, measured past. "
    "<b>Free run</b>: final parameters, simulated from the input alone."
)


def render_page(
    result: IdentificationResult,
    train: PreparedData,
    test: PreparedData,
    charts: Iterable[Chart],
    footer: str,
) -> str:
    """Return the page.

    Args:
        result: the comparison.
        train: training data.
        test: test data.
        charts: what `server.reports.charts` made of them.
        footer: versions and date.
    """
    title = f"Identification of {test.output[0]} from {test.input[0]}"
    body = "\n".join(
        [
            f"<h1>{escape(title)}</h1>",
            f'<p class="sub">{escape(_subtitle(result, train, test))}</p>',
            '<ul class="verdict">' + _items(result.verdict) + "</ul>",
            "<h2>Comparison</h2>",
            _comparison_table(result, train.output[1]),
            "<h2>Models</h2>",
            _models(result),
            *(f"<h2>{escape(chart.title)}</h2>\n{HINT}{chart_html(chart)}" for chart in charts),
            _residual_summary(result),
            "<h2>Excitation and conditioning</h2>",
            f"<ul>{_items(result.excitation.sentences)}</ul>",
            _selection(result),
            "<h2>Data</h2>",
            f"<ul>{_items(_data_lines(train, test))}</ul>",
            f"<footer>{escape(footer)}</footer>",
        ]
    )
    return FRAME.format(title=escape(title), style=STYLE, script=plotly_script(), body=body)


def _subtitle(result: IdentificationResult, train: PreparedData, test: PreparedData) -> str:
    options = result.options
    return (
        f"trained on {train.source.name}, tested on {test.source.name}; "
        f"sample time {result.train.sample_time_s:g} s, order {options.order}, delay {options.delay}"
    )


def _items(lines: Iterable[str]) -> str:
    return "".join(f"<li>{escape(line)}</li>" for line in lines)


def _comparison_table(result: IdentificationResult, unit: str) -> str:
    heads = ["estimator", *(MODE_TITLES[mode] for mode in Mode), f"free-run rmse [{unit}]", "time [ms]"]
    rows = "".join(_comparison_lines(list(comparison_rows(result)), len(heads)))
    head = "".join(f"<th>{escape(text)}</th>" for text in heads)
    return (
        '<div class="scroll"><table class="comparison"><thead><tr>'
        + head
        + f"</tr></thead><tbody>{rows}</tbody>"
        f"</table></div><p>{LEGEND}</p>"
    )


def _comparison_lines(rows: list[Row], width: int) -> Iterator[str]:
    phase: Phase | None = None
    for row in rows:
        if row.phase is not phase:
            phase = row.phase
            yield f'<tr class="phase"><td colspan="{width}">{phase.value}</td></tr>'
        cells = [row.title, *row.figures.values(), row.free_run_rmse, row.time_ms]
        kind = ' class="trivial"' if "=" in row.title else ""
        yield f"<tr{kind}>" + "".join(f"<td>{escape(cell)}</td>" for cell in cells) + "</tr>"


def _models(result: IdentificationResult) -> str:
    lines = []
    for method, (title, details) in zip(result.methods.values(), describe_models(result), strict=True):
        pairs = zip(method.parameter_names, method.theta, method.standard_errors, strict=True)
        parameters = ", ".join(f"{name} = {format_measure(value, std)}" for name, value, std in pairs)
        lines.append(f"<dt>{escape(title)}</dt>")
        lines += [f'<dd class="formula">{escape(text)}</dd>' for text in (*details, parameters)]
    return f"<dl>{''.join(lines)}</dl>"


def _residual_summary(result: IdentificationResult) -> str:
    lines = []
    for method in result.methods.values():
        residuals = method.residuals
        white = "white" if residuals.white else "not white"
        explained = "explained" if residuals.input_explained else "not fully explained"
        lines.append(
            f"{method.title}: residual {white} (Ljung-Box {residuals.ljung_box:.4g}, "
            f"p = {residuals.ljung_box_p:.3g}); the input's effect is {explained}."
        )
    return f"<ul>{_items(lines)}</ul>"


def _selection(result: IdentificationResult) -> str:
    selection = result.selection
    if selection is None:
        return ""
    rows = "".join(
        f"<tr><td>{c.order}</td><td>{c.delay}</td><td>{c.bic:.1f}</td><td>{c.r2:.5f}</td></tr>"
        for c in selection.candidates
    )
    return (
        "<h2>Order and delay</h2><p>Ranked by free run on training data that the fit has not seen "
        "(BIC; a difference of a few units means nothing).</p>"
        "<table><thead><tr><th>order</th><th>delay</th><th>BIC</th><th>free-run R²</th>"
        f"</tr></thead><tbody>{rows}</tbody></table>"
    )


def _data_lines(train: PreparedData, test: PreparedData) -> Iterator[str]:
    for name, data in (("training", train), ("test", test)):
        for note in data.notes:
            yield f"{name}: {note}"
