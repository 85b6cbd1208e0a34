"""The figures of the report: each function returns one. Long signals are thinned before they are drawn."""

from collections.abc import Sequence

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray
from scipy.signal import welch

from discrepancy.evaluate import Curve
from discrepancy.result import GapResult

FloatArray = NDArray[np.float64]

MOST_POINTS = 2500
_MEASURED, _BEFORE, _AFTER = "#1c2430", "#c2410c", "#2563a8"


def thin(curve: Curve, most: int = MOST_POINTS) -> slice:
    """Return the rows that are drawn."""
    return slice(None, None, max(1, curve.time_s.size // most))


def _layout(figure: go.Figure, title: str, x: str, y: str) -> go.Figure:
    figure.update_layout(title=title, xaxis_title=x, yaxis_title=y, template="plotly_white", height=380)
    return figure


def staircase(result: GapResult) -> go.Figure:
    """Show the gap on test data, step by step, down to the noise floor."""
    names = ["recalibrated base", *(f"+ {(step.added or '').replace('_', ' ')}" for step in result.steps[1:])]
    figure = go.Figure()
    for output, score in result.steps[0].test.items():
        values = [100.0 * step.test[output].nrmse for step in result.steps]
        figure.add_bar(x=names, y=values, name=f"{output}: error", text=[f"{v:.2f} %" for v in values])
        floor = 100.0 * result.noise_floor.get(output, 0.0) * score.nrmse / max(score.rmse, 1e-300)
        figure.add_hline(y=floor, line_dash="dot", annotation_text=f"noise floor of {output}")
    return _layout(figure, "Error on the test record, step by step", "", "rms error, % of the signal")


def before_after(result: GapResult) -> go.Figure:
    """Show measurement, base model and extended model over time."""
    figure = go.Figure()
    for first, last in zip(result.steps[0].curves, result.steps[-1].curves, strict=True):
        rows = thin(first)
        time = first.time_s[rows]
        figure.add_scatter(
            x=time,
            y=first.measured[rows],
            name=f"{first.label} {first.name}",
            line={"color": _MEASURED, "width": 1},
        )
        figure.add_scatter(
            x=time, y=first.simulated[rows], name="base model", line={"color": _BEFORE, "width": 1}
        )
        figure.add_scatter(
            x=time, y=last.simulated[rows], name="extended model", line={"color": _AFTER, "width": 1}
        )
    return _layout(
        figure,
        "Measured and simulated",
        "time, s",
        ", ".join(dict.fromkeys(c.name for c in result.steps[0].curves)),
    )


def spectra(result: GapResult) -> go.Figure:
    """Show the spectrum of the error before and after."""
    figure = go.Figure()
    for step, colour, name in (
        (result.steps[0], _BEFORE, "base model"),
        (result.steps[-1], _AFTER, "extended model"),
    ):
        for curve in step.curves[:1]:
            frequency, power = _spectrum(curve)
            figure.add_scatter(x=frequency, y=np.sqrt(power), name=name, line={"color": colour, "width": 1})
    figure.update_xaxes(type="log")
    figure.update_yaxes(type="log")
    return _layout(
        figure,
        "Spectrum of the error on the test record",
        "frequency, Hz",
        "amplitude density, unit / sqrt(Hz)",
    )


def _spectrum(curve: Curve) -> tuple[FloatArray, FloatArray]:
    step = float(np.median(np.diff(curve.time_s)))
    frequency, power = welch(
        curve.measured - curve.simulated, fs=1.0 / step, nperseg=min(curve.time_s.size, 4096)
    )
    keep = np.unique(np.geomspace(1, frequency.size - 1, 400).astype(int))
    return frequency[keep], power[keep]


def residual_map(result: GapResult) -> go.Figure:
    """Show what the missing torque looks like over the variables that explain it."""
    figure = go.Figure()
    places: Sequence[object] = result.steps[0].where
    for place in result.steps[0].where if places else ():
        if place.shape:
            x, y = zip(*place.shape, strict=True)
            scale = max(abs(v) for v in x) or 1.0
            figure.add_scatter(
                x=[v / scale for v in x],
                y=y,
                name=f"{place.port.value} over {place.driver} ({place.share:.0%})",
            )
    return _layout(
        figure,
        "Missing torque before anything was added",
        "variable, relative to its largest value",
        "missing torque",
    )
