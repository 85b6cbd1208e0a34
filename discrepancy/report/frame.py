"""One figure on the page: drawn by plotly, with a caption, a text for those who cannot see it, and zoom buttons."""

from collections.abc import Sequence
from html import escape

import plotly.graph_objects as go
import plotly.io as pio

MEASURED, BEFORE, AFTER, NOISE = "#64748b", "#e8590c", "#1c7ed6", "#2f9e44"
"""Readable on white and on dark paper alike, and apart from each other for the colour-blind."""
PALETTE = (AFTER, BEFORE, NOISE, "#9c36b5", "#0c8599", "#a6691b")
CLEAR = "rgba(0,0,0,0)"
_CONFIG = {
    "displaylogo": False,
    "responsive": True,
    "displayModeBar": "hover",
    "modeBarButtonsToRemove": ["lasso2d", "select2d", "autoScale2d", "zoomIn2d", "zoomOut2d"],
}


def dress(figure: go.Figure, x: str, y: str, height: int = 340) -> go.Figure:
    """Give a figure the page's look: transparent paper, legend above, axis titles with units."""
    figure.update_layout(
        template="none",
        paper_bgcolor=CLEAR,
        plot_bgcolor=CLEAR,
        height=height,
        margin={"l": 64, "r": 16, "t": 52, "b": 48},
        font={"family": "system-ui, sans-serif", "size": 13},
        legend={"orientation": "h", "y": 1.0, "yanchor": "bottom", "x": 0.0, "title": {"text": ""}},
        hovermode="closest",
        modebar={"bgcolor": CLEAR, "color": "#808080", "activecolor": AFTER},
        colorway=list(PALETTE),
    )
    axis = {
        "showgrid": True,
        "gridcolor": "#808080",
        "zeroline": False,
        "title_standoff": 8,
        "ticks": "outside",
        "linecolor": "#808080",
    }
    figure.update_xaxes(**axis)
    # Without it a long tick label lies on the title.
    figure.update_yaxes(**axis, automargin=True)
    figure.update_xaxes(title_text=x, selector=-1)
    figure.update_yaxes(title_text=y, selector=0)
    return figure


def frame(figure: go.Figure, key: str, alt: str, caption: str = "", tools: str = "") -> str:
    """Return a figure as HTML.

    Args:
        figure: dressed.
        key: unique on the page; the same input gives the same page.
        alt: what the picture shows, for screen readers.
        caption: how to read it, plain text.
        tools: HTML of the buttons that belong to it.
    """
    drawn = pio.to_html(figure, full_html=False, include_plotlyjs=False, div_id=key, config=_CONFIG)
    words = f"<figcaption>{escape(caption)}</figcaption>" if caption else ""
    return (
        f'<figure>{tools}<div role="img" aria-label="{escape(alt, quote=True)}">{drawn}</div>{words}</figure>'
    )


def zoom_buttons(key: str, spans: Sequence[tuple[str, tuple[float, float]]]) -> str:
    """Return buttons that set the time axis of a figure to one of several spans, s."""
    buttons = "".join(
        f'<button type="button" data-zoom="{key}" data-from="{a:.6g}" data-to="{b:.6g}">{escape(name)}</button>'
        for name, (a, b) in spans
    )
    return f'<div class="tools" role="group" aria-label="Zoom">{buttons}</div>'
