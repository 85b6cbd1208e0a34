"""Figures over time and frequency, and the staircase of the gap: each function returns one."""

from textwrap import wrap

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray
from plotly.subplots import make_subplots

from discrepancy.evaluate import Curve
from discrepancy.report.frame import AFTER, BEFORE, MEASURED, NOISE, PALETTE, dress
from discrepancy.report.numbers import output_unit, significant
from discrepancy.report.plain import called, quantity_name
from discrepancy.report.spectra import spectrum, white_density
from discrepancy.report.thin import thin, within
from discrepancy.result import GapResult

FloatArray = NDArray[np.float64]

BEFORE_NAME, AFTER_NAME = "base model, recalibrated", "extended model"


def titled(output: str) -> str:
    """Return an axis title: quantity and unit."""
    return f"{quantity_name(output)}, {output_unit(output)}".rstrip(", ")


def _line(
    figure: go.Figure,
    curve: tuple[str, FloatArray, FloatArray],
    colour: str,
    dash: str = "solid",
    row: int = 0,
) -> None:
    """Add a thinned line; `row` is that of a figure with several, 0 for a plain one."""
    name, time, values = curve
    x, y = thin(time, values)
    figure.add_scatter(
        x=x.astype(np.float32), y=y.astype(np.float32), name=name, mode="lines", legendgroup=name,
        line={"color": colour, "width": 1.4, "dash": dash}, showlegend=row < 2,
        **({"row": row, "col": 1} if row else {}),
    )  # fmt: skip


def stretch(result: GapResult, curves: tuple[Curve, Curve], span: tuple[float, float]) -> go.Figure:
    """Show the stretch in which the base model is worst: measured, before, after."""
    first, last = curves
    rows = within(first, span)
    figure = go.Figure()
    _line(figure, ("measured", first.time_s[rows], first.measured[rows]), MEASURED)
    _line(figure, (BEFORE_NAME, first.time_s[rows], first.simulated[rows]), BEFORE, dash="dash")
    if len(result.steps) > 1:
        _line(figure, (AFTER_NAME, last.time_s[rows], last.simulated[rows]), AFTER)
    return dress(figure, "time, s", titled(first.name), 330)


def over_time(result: GapResult, curves: tuple[Curve, Curve]) -> go.Figure:
    """Show a whole record: the signals above, the errors below with the band of the noise."""
    first, last = curves
    figure = make_subplots(rows=2, cols=1, shared_xaxes=True, row_heights=[0.6, 0.4], vertical_spacing=0.06)
    _line(figure, ("measured", first.time_s, first.measured), MEASURED, row=1)
    pairs = [(first, BEFORE, BEFORE_NAME), (last, AFTER, AFTER_NAME)][: min(2, len(result.steps))]
    for curve, colour, name in pairs:
        _line(figure, (name, curve.time_s, curve.simulated), colour, row=1)
        _line(figure, (name, curve.time_s, curve.measured - curve.simulated), colour, row=2)
    floor = result.noise_floor.get(first.name, 0.0)
    figure.add_hrect(
        y0=-2 * floor, y1=2 * floor, row=2, col=1, line_width=0, fillcolor=NOISE, opacity=0.25,
    )  # fmt: skip
    dress(figure, "", "", 480)
    figure.update_xaxes(title_text="time, s", row=2, col=1)
    figure.update_yaxes(title_text=titled(first.name), row=1, col=1)
    figure.update_yaxes(title_text=f"error, {output_unit(first.name)}".rstrip(", "), row=2, col=1)
    return figure


def spectra(result: GapResult, curves: tuple[Curve, Curve]) -> go.Figure:
    """Show the spectrum of the error before and after, and of the noise."""
    first, last = curves
    figure = go.Figure()
    pairs = [(first, BEFORE, BEFORE_NAME), (last, AFTER, AFTER_NAME)][: min(2, len(result.steps))]
    for curve, colour, name in pairs:
        found = spectrum(curve.time_s, (curve.measured - curve.simulated) * (curve.weight > 0))
        figure.add_scatter(
            x=found.frequency, y=found.density, name=f"error of the {name}", line={"color": colour}
        )
    noise = result.pictures.noise.get(first.name)
    if noise is not None:
        name = "noise, measured from repeated records"
        figure.add_scatter(
            x=noise.frequency, y=noise.density, name=name, line={"color": NOISE, "dash": "dot"}
        )
    else:
        level = white_density(result.noise_floor.get(first.name, 0.0), first.time_s)
        ends = [1.0 / max(first.time_s[-1], 1e-9), 0.5 / float(np.median(np.diff(first.time_s)))]
        name = "noise floor, if it were white"
        figure.add_scatter(x=ends, y=[level, level], name=name, line={"color": NOISE, "dash": "dot"})
    figure.update_xaxes(type="log")
    figure.update_yaxes(type="log", exponentformat="power")
    return dress(figure, "frequency, Hz", f"amplitude density, {output_unit(first.name)}/√Hz")


def staircase(result: GapResult) -> go.Figure:
    """Show the error on test data, model by model, down to the noise floor; a logarithmic axis."""
    labels = ["base model, recalibrated", *(f"+ {called(str(step.added))}" for step in result.steps[1:])]
    names = ["<br>".join(wrap(label, 19)) for label in labels]
    figure = go.Figure()
    for k, (output, first) in enumerate(result.steps[0].test.items()):
        signal = first.rmse / max(first.nrmse, 1e-300)
        errors = [step.test[output].rmse for step in result.steps]
        colour = PALETTE[k % len(PALETTE)]
        text = [f"{significant(e)} {output_unit(output)}<br>{100 * e / signal:.2f} %" for e in errors]
        figure.add_scatter(
            x=names, y=[100.0 * e / signal for e in errors], text=text, textposition="top center",
            mode="lines+markers+text", line={"shape": "hvh", "color": colour}, marker={"size": 10},
            name=f"error of the {quantity_name(output)}",
        )  # fmt: skip
        floor = 100.0 * result.noise_floor.get(output, 0.0) / signal
        if floor > 0.0:
            figure.add_scatter(
                x=names, y=[floor] * len(names), mode="lines", line={"dash": "dot", "color": NOISE},
                name=f"noise floor of the {quantity_name(output)}",
            )  # fmt: skip
    dress(figure, "", "rms error on test data, % of the signal")
    figure.update_yaxes(type="log", dtick="D2", range=_log_range(figure))
    figure.update_xaxes(range=[-0.5, len(names) - 0.5], tickangle=0, automargin=True)
    return figure


def _log_range(figure: go.Figure) -> list[float]:
    values = [v for trace in figure.data for v in trace.y if v > 0.0]
    return [float(np.log10(min(values)) - 0.25), float(np.log10(max(values)) + 0.35)]
