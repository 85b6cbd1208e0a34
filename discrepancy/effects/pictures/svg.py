"""Draw a picture of the catalogue as an SVG file: the same picture gives the same bytes (docs/decisions/0002)."""

import re
from collections.abc import Mapping
from io import StringIO

from matplotlib import style
from matplotlib.axes import Axes
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator, StrMethodFormatter

from discrepancy.effects.pictures.spec import Look, Note, Panel, Picture

WIDTH_IN, HEIGHT_IN = 7.0, 3.1
_LEFT_IN, _RIGHT_IN, _BOTTOM_IN, _TOP_IN, _BETWEEN_IN = 0.75, 0.15, 0.5, 0.62, 0.85
_GUIDE, _INK = "#94a3b8", "#1c2430"
_LOOKS: Mapping[Look, tuple[str, str, float]] = {
    Look.WITHOUT: ("#64748b", "--", 1.3),
    Look.FIRST: ("#1c7ed6", "-", 2.0),
    Look.SECOND: ("#e8590c", "-", 1.6),
    Look.THIRD: ("#2f9e44", "-", 1.6),
}
"""Colour, style and width; the colours of the reports, apart from each other for the colour-blind."""
_RULES: Mapping[str, object] = {
    "svg.hashsalt": "jointscope",
    "svg.fonttype": "none",
    # Which points it drops would depend on the last digit.
    "path.simplify": False,
    "font.family": "sans-serif",
    # Of the same width nearly everywhere: the words are measured with the first.
    "font.sans-serif": ["DejaVu Sans", "Verdana"],
    "font.size": 9.0,
    "text.color": _INK,
    "axes.labelcolor": _INK,
    "axes.edgecolor": _GUIDE,
    "axes.unicode_minus": False,
    "xtick.color": _INK,
    "ytick.color": _INK,
}
_NO_METADATA = {"Creator": None, "Date": None, "Format": None, "Type": None}
_COORDINATES = re.compile(r' (?:d|x|y|transform)="[^"]*"')
_NUMBER = re.compile(r"-?\d+\.\d+")


def _draw(picture: Picture) -> Figure:
    """Return the figure of a picture, panels side by side."""
    figure = Figure(figsize=(WIDTH_IN, HEIGHT_IN), facecolor="white")
    count = len(picture.panels)
    width = (WIDTH_IN - _LEFT_IN - _RIGHT_IN - (count - 1) * _BETWEEN_IN) / count
    figure.text(
        0.15 / WIDTH_IN, 1.0 - 0.12 / HEIGHT_IN, picture.title, fontsize=10.5, fontweight="bold", va="top"
    )
    for k, panel in enumerate(picture.panels):
        left = _LEFT_IN + k * (width + _BETWEEN_IN)
        height = HEIGHT_IN - _BOTTOM_IN - _TOP_IN
        place = (left / WIDTH_IN, _BOTTOM_IN / HEIGHT_IN, width / WIDTH_IN, height / HEIGHT_IN)
        _draw_panel(figure.add_axes(place), panel)
    return figure


def write_svg(picture: Picture) -> str:
    """Return a picture as the text of an SVG file, coordinates rounded to a hundredth of a point."""
    text = StringIO()
    # Not as the user's own settings would have it.
    with style.context(["default", dict(_RULES)]):
        figure = _draw(picture)
        FigureCanvasSVG(figure)
        figure.savefig(text, format="svg", metadata=_NO_METADATA)
    return _COORDINATES.sub(_round_off, text.getvalue())


def _round_off(attribute: re.Match[str]) -> str:
    # Another processor may compute another last digit: it must not show in the file.
    return _NUMBER.sub(lambda number: f"{float(number[0]) + 0.0:.2f}".rstrip("0").rstrip("."), attribute[0])


def _draw_panel(axes: Axes, panel: Panel) -> None:
    if panel.logarithmic:
        _set_logarithmic(axes)
    axes.grid(visible=True, color="#e2e8f0", linewidth=0.6)
    axes.set_axisbelow(True)
    for level in panel.levels:
        axes.axhline(level, color=_GUIDE, linewidth=0.9, linestyle=":")
    for place in panel.places:
        axes.axvline(place, color=_GUIDE, linewidth=0.9, linestyle=":")
    for line in panel.lines:
        colour, dashes, width = _LOOKS[line.look]
        axes.plot(line.x, line.y, label=line.name or "_", color=colour, linestyle=dashes, linewidth=width)
    for note in panel.notes:
        _draw_note(axes, note)
    axes.margins(x=0.02, y=0.12)
    axes.set_xlabel(panel.x)
    axes.set_ylabel(panel.y)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    named = sum(bool(line.name) for line in panel.lines)
    if named:
        axes.legend(
            loc="lower left", bbox_to_anchor=(-0.01, 0.99), ncols=named, frameon=False, borderpad=0.1,
            handlelength=1.8, columnspacing=1.2,
        )  # fmt: skip


def _set_logarithmic(axes: Axes) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter(StrMethodFormatter("{x:g}"))
        axis.set_minor_locator(NullLocator())


def _draw_note(axes: Axes, note: Note) -> None:
    axes.annotate(
        note.text,
        (note.x, note.y),
        textcoords="offset points",
        xytext=(0.0, 2.5),
        ha=note.align,
        fontsize=8.5,
    )
