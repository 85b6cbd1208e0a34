"""Figures over the joint's own variables: the residual map and the laws."""

from collections.abc import Sequence

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from discrepancy.effects.spec import Port
from discrepancy.locate import Place
from discrepancy.report.frame import AFTER, BEFORE, MEASURED, dress
from discrepancy.report.numbers import output_unit
from discrepancy.report.pictures import LawPicture
from discrepancy.report.plain import quantity_name

MOST_CURVES = 4


def short_place(place: Place) -> str:
    """Return a place as a label of a few words."""
    port = {Port.TORQUE: "torque", Port.CURRENT: "current", Port.SENSOR: "sensor"}[place.port]
    return f"{port} error over {quantity_name(place.driver)}"


def shares(before: Sequence[Place], after: Sequence[Place], left: float) -> go.Figure:
    """Show for each place which share of the disagreement a curve over its variable predicts.

    Args:
        before: places of the base model.
        after: places of the extended model, may be empty.
        left: part of the base model's squared error that the extended model leaves: its shares count that much.
    """
    order = sorted(before, key=lambda place: place.share)
    labels = [short_place(place) for place in order]
    figure = go.Figure()
    known = {(p.port, p.driver): left * p.share for p in after}
    groups = [("base model, recalibrated", BEFORE, [p.share for p in order])]
    if after:
        groups.insert(0, ("extended model", AFTER, [known.get((p.port, p.driver), 0.0) for p in order]))
    for name, colour, values in groups:
        figure.add_bar(
            y=labels, x=[100.0 * v for v in values], name=name, orientation="h", marker={"color": colour},
            text=[f"{100 * v:.0f} %" for v in values], textposition="outside", cliponaxis=False,
        )  # fmt: skip
    dress(
        figure,
        "share of the error, %",
        "",
        90 + 44 * len(order),
    )
    figure.update_layout(legend={"traceorder": "reversed"})
    figure.update_xaxes(range=[0, 108])
    figure.update_yaxes(automargin=True, showgrid=False)
    return figure


def curves(places: Sequence[Place], torque_unit: str, output: str) -> go.Figure | None:
    """Show the curve of each of the strongest places, None if no place has one."""
    drawn = [place for place in places if len(place.shape) > 1][:MOST_CURVES]
    if not drawn:
        return None
    titles = [f"{short_place(p)}: {100 * p.share:.0f} %" for p in drawn]
    rows = (len(drawn) + 1) // 2
    figure = make_subplots(
        rows=rows, cols=2, subplot_titles=titles, vertical_spacing=0.5 / rows, horizontal_spacing=0.14
    )
    for k, place in enumerate(drawn):
        x, missing = zip(*place.shape, strict=True)
        # A law opposes the motion; what is missing drives it. Drawn is the load, as in the pictures of the laws.
        y = missing if place.port is Port.SENSOR else tuple(-v for v in missing)
        where = {"row": k // 2 + 1, "col": k % 2 + 1}
        figure.add_scatter(x=x, y=y, mode="lines+markers", line={"color": BEFORE}, showlegend=False, **where)
    dress(figure, "", "", 60 + 270 * rows)
    for k, place in enumerate(drawn):
        where = {"row": k // 2 + 1, "col": k % 2 + 1}
        unit = output_unit(output) if place.port is Port.SENSOR else torque_unit
        figure.update_xaxes(title_text=_driver_title(place.driver), **where)
        figure.update_yaxes(title_text=f"{_what(place)}, {unit}", **where)
    figure.update_annotations(font_size=13)
    return figure


def _what(place: Place) -> str:
    return "error" if place.port is Port.SENSOR else "missing load"


def _driver_title(driver: str) -> str:
    unit = "A/s" if driver == "frequency" else output_unit(driver)
    return f"{quantity_name(driver)}, {unit}".rstrip(", ")


def law(picture: LawPicture, name: str) -> go.Figure:
    """Show measured cells with error bars and the law with its band on top."""
    points = picture.points
    figure = go.Figure()
    if picture.low.size:
        figure.add_scatter(
            x=np.concatenate([picture.law_x, picture.law_x[::-1]]),
            y=np.concatenate([picture.high, picture.low[::-1]]),
            fill="toself", mode="lines", line={"width": 0}, fillcolor="rgba(28,126,214,0.25)",
            name="its 95 % band", hoverinfo="skip",
        )  # fmt: skip
    figure.add_scatter(
        x=points.x, y=points.mean, mode="markers", name="measured, mean with 95 % interval",
        marker={"color": MEASURED, "size": 6}, customdata=points.count,
        hovertemplate="%{x:.4g}: %{y:.4g} (%{customdata} samples)<extra></extra>",
        error_y={"array": points.error, "color": MEASURED, "thickness": 1.2, "width": 2},
    )  # fmt: skip
    if picture.law.size:
        figure.add_scatter(
            x=picture.law_x, y=picture.law, mode="lines", name=name, line={"color": AFTER, "width": 2}
        )
    figure.add_hline(y=0.0, line={"color": "#808080", "width": 1})
    title = f"{picture.x_name}, {picture.x_unit}"
    return dress(figure, title, f"{picture.y_name}, {picture.y_unit}", 380)
