"""Charts as PNG files, drawn without a display and without a browser (docs/decisions/0002)."""

from collections.abc import Iterable
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from server.reports.charts import Chart, Panel, Role, Trace
from server.reports.style import MEASURED_COLOUR, model_colour

PANEL_HEIGHT_IN = 2.1
WIDTH_IN = 11.0
DPI = 110


def write_png_files(charts: Iterable[Chart], out: Path) -> list[Path]:
    """Draw each chart into `out/KEY.png`."""
    return [_write_png(chart, out / f"{chart.key}.png") for chart in charts]


def _write_png(chart: Chart, path: Path) -> Path:
    count = len(chart.panels)
    figure = Figure(figsize=(WIDTH_IN, PANEL_HEIGHT_IN * count + 0.6), dpi=DPI, layout="constrained")
    FigureCanvasAgg(figure)
    figure.suptitle(chart.title, fontsize=13)
    grid = figure.subplots(
        count, 1, squeeze=False, sharex="all" if chart.x_label.startswith("time") else False
    )
    for axes, panel in zip(grid[:, 0], chart.panels, strict=True):
        _draw(axes, panel)
    grid[-1, 0].set_xlabel(chart.x_label)
    if chart.x_range is not None:
        grid[-1, 0].set_xlim(*chart.x_range)
    figure.savefig(path)
    return path


def _draw(axes: Axes, panel: Panel) -> None:
    for trace in panel.traces:
        _draw_trace(axes, trace)
    if panel.band is not None:
        axes.axhspan(-panel.band, panel.band, color="0.5", alpha=0.18, linewidth=0)
    if panel.y_range is not None:
        axes.set_ylim(*panel.y_range)
    axes.set_title(panel.title, fontsize=10, loc="left")
    axes.set_ylabel(panel.y_label, fontsize=8)
    axes.tick_params(labelsize=8)
    axes.grid(visible=True, linewidth=0.4, alpha=0.6)
    axes.margins(x=0.01)
    if len(panel.traces) > 1:
        # Above the axes: inside, it would hide some of the data.
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), fontsize=8, ncols=8, frameon=False)


def _draw_trace(axes: Axes, trace: Trace) -> None:
    if trace.role is Role.MEASURED:
        axes.plot(trace.x, trace.y, color=MEASURED_COLOUR, linewidth=1.6, label=trace.name, zorder=1)
        return
    colour = model_colour(trace.number)
    if trace.stems:
        axes.plot(trace.x, trace.y, "o-", color=colour, markersize=2.5, linewidth=0.9, label=trace.name)
    else:
        axes.plot(trace.x, trace.y, color=colour, linewidth=0.9, label=trace.name, zorder=2)
