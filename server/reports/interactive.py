"""Charts as interactive plotly figures, for a page that carries plotly itself."""

import numpy as np
import plotly.graph_objects as go
from plotly.offline import get_plotlyjs
from plotly.subplots import make_subplots

from server.reports.charts import Chart, Panel, Role, Trace
from server.reports.style import MEASURED_COLOUR, model_colour

PANEL_HEIGHT_PX = 230


def plotly_script() -> str:
    """Return the library as a script element: the page needs no network."""
    return f"<script>{get_plotlyjs()}</script>"


def chart_html(chart: Chart) -> str:
    """Return one chart as a div with its data."""
    count = len(chart.panels)
    figure = make_subplots(
        rows=count,
        cols=1,
        shared_xaxes=chart.x_label.startswith("time"),
        vertical_spacing=0.25 / max(count, 2),
        subplot_titles=[panel.title for panel in chart.panels],
    )
    named: set[str] = set()
    for row, panel in enumerate(chart.panels, start=1):
        _add_panel(figure, panel, row, named)
    figure.update_xaxes(title_text=chart.x_label, row=count, col=1)
    if chart.x_range is not None:
        figure.update_xaxes(range=list(chart.x_range))
    figure.update_annotations(font_size=13, x=0.0, xanchor="left")
    figure.update_layout(
        height=PANEL_HEIGHT_PX * count + 80,
        margin={"l": 70, "r": 20, "t": 40, "b": 50},
        template="plotly_white",
        legend={"orientation": "h", "y": 1.0, "yanchor": "bottom", "x": 1.0, "xanchor": "right"},
        modebar={"orientation": "v"},
    )
    html: str = figure.to_html(full_html=False, include_plotlyjs=False, div_id=chart.key)
    return html


def _add_panel(figure: go.Figure, panel: Panel, row: int, named: set[str]) -> None:
    for trace in panel.traces:
        figure.add_trace(_scatter(trace, first=trace.name not in named), row=row, col=1)
        named.add(trace.name)
    if panel.band is not None:
        figure.add_hrect(
            y0=-panel.band, y1=panel.band, fillcolor="grey", opacity=0.18, line_width=0, row=row, col=1
        )
    figure.update_yaxes(title_text=panel.y_label, title_font_size=11, row=row, col=1)
    if panel.y_range is not None:
        figure.update_yaxes(range=list(panel.y_range), row=row, col=1)


def _scatter(trace: Trace, *, first: bool) -> go.Scatter:
    measured = trace.role is Role.MEASURED
    colour = MEASURED_COLOUR if measured else model_colour(trace.number)
    return go.Scatter(
        # Single precision: a third of the digits of the JSON file, more than any screen shows.
        x=trace.x.astype(np.float32),
        y=trace.y.astype(np.float32),
        name=trace.name,
        legendgroup=trace.name,
        showlegend=first,
        mode="lines+markers" if trace.stems else "lines",
        marker={"size": 4},
        line={"color": colour, "width": 2.2 if measured else 1.2},
    )
