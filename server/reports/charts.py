"""What the plots of an identification show, as data; page and PNG files draw the same charts from it."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from estimators.result import IdentificationResult, MethodResult, Mode, Phase
from server.reports.comparison import MODE_TITLES
from server.services.dataset import PreparedData

Floats = NDArray[np.floating]
# A free run that diverges must not press the measured curve flat: axes reach so far beyond its span.
HEADROOM = 0.35
# A longer record is shown in part at first: a thousand seconds on one page are a grey band.
SHOWN_S = 200.0
# Beyond this nothing is drawn: drawing libraries compute in single precision.
DRAWABLE = 1e12


class Role(Enum):
    """What a trace is, which decides its colour."""

    MEASURED = "measured"
    MODEL = "model"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Trace:
    """One curve. `number` counts the estimators, so that each keeps its colour in all charts."""

    name: str
    x: Floats
    y: Floats
    role: Role = Role.MODEL
    number: int = 0
    stems: bool = False


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Panel:
    """One set of axes.

    Attributes:
        title: what it shows.
        y_label: quantity and unit.
        traces: curves.
        y_range: limits of the axis; None fits them to the curves.
        band: half width of a confidence band about zero; None for none.
    """

    title: str
    y_label: str
    traces: tuple[Trace, ...]
    y_range: tuple[float, float] | None = None
    band: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Chart:
    """Panels above each other on one x axis.

    Attributes:
        key: names the PNG file.
        title: what it shows.
        x_label: quantity and unit.
        panels: from top to bottom.
        x_range: part of the x axis that is shown at first; None shows all.
    """

    key: str
    title: str
    x_label: str
    panels: tuple[Panel, ...]
    x_range: tuple[float, float] | None = None


def identification_charts(
    result: IdentificationResult, train: PreparedData, test: PreparedData
) -> Iterator[Chart]:
    """Yield every chart of an identification."""
    yield _output_chart(result, test, Phase.TEST)
    yield _output_chart(result, train, Phase.TRAINING)
    histories = [method for method in result.methods.values() if method.history is not None]
    if histories:
        yield _parameter_chart(histories, train)
    yield _residual_chart(list(result.methods.values()), result.test.sample_time_s)


def _output_chart(result: IdentificationResult, data: PreparedData, phase: Phase) -> Chart:
    label = f"{data.output[0]} [{data.output[1]}]"
    y_range = _range_of(data.dataset.y)
    panels = [_input_panel(data)]
    for mode in (Mode.FREE_RUN, Mode.ONE_STEP_FROZEN):
        traces = (
            _measured(data, data.dataset.y),
            *_by_method(result, data, lambda method, mode=mode: method.series[phase][mode]),  # type: ignore[misc]  # the default binds the loop's value
        )
        panels.append(
            Panel(title=f"measured and {MODE_TITLES[mode]}", y_label=label, traces=traces, y_range=y_range)
        )
    errors = tuple(
        _by_method(result, data, lambda method: method.series[phase][Mode.FREE_RUN] - data.dataset.y)
    )
    span = max((y_range[1] - y_range[0]) / 2.0, 1e-12)
    panels.append(
        Panel(title="free run minus measured", y_label=label, traces=errors, y_range=_limited(errors, span))
    )
    start_s, duration_s = float(data.time_s[0]), float(data.time_s[-1] - data.time_s[0])
    whole = duration_s <= SHOWN_S
    return Chart(
        key=f"outputs_{phase.value}",
        title=f"Outputs on the {phase.value} record"
        + ("" if whole else f", {SHOWN_S:g} of {duration_s:.0f} s"),
        x_label="time [s]",
        panels=tuple(panels),
        x_range=None if whole else (start_s, start_s + SHOWN_S),
    )


def _input_panel(data: PreparedData) -> Panel:
    label = f"{data.input[0]} [{data.input[1]}]"
    return Panel(title="input", y_label=label, traces=(_measured(data, data.dataset.u),))


def _measured(data: PreparedData, values: Floats) -> Trace:
    x, y = break_at_holes(data.time_s, values, data.dataset.starts)
    return Trace(name="measured", x=x, y=y, role=Role.MEASURED)


def _by_method(
    result: IdentificationResult, data: PreparedData, pick: Callable[[MethodResult], Floats]
) -> Iterator[Trace]:
    for number, method in enumerate(result.methods.values()):
        x, y = break_at_holes(data.time_s, pick(method), data.dataset.starts)
        yield Trace(name=method.title, x=x, y=y, number=number)


def break_at_holes(time_s: Floats, values: Floats, starts: tuple[int, ...]) -> tuple[Floats, Floats]:
    """Put a NaN before each segment but the first and for what has diverged: no line is drawn there."""
    places = np.asarray(starts[1:], dtype=np.intp)
    with np.errstate(all="ignore"):
        finite = np.where(np.abs(values) < DRAWABLE, values, np.nan)
    return np.insert(time_s, places, time_s[places]), np.insert(finite, places, np.nan)


def _range_of(values: Floats) -> tuple[float, float]:
    low, high = float(values.min()), float(values.max())
    margin = HEADROOM * (high - low) or 1.0
    return low - margin, high + margin


def _limited(traces: tuple[Trace, ...], span: float) -> tuple[float, float] | None:
    """Return symmetric limits when a curve leaves +-span, else None: the curves then set the axis."""
    peaks = [float(np.nanmax(np.abs(trace.y))) for trace in traces if np.isfinite(trace.y).any()]
    return (-span, span) if any(peak > span for peak in peaks) else None


def _parameter_chart(methods: list[MethodResult], train: PreparedData) -> Chart:
    names = list(dict.fromkeys(name for method in methods for name in method.parameter_names))
    panels = []
    for name in names:
        traces = []
        for number, method in enumerate(methods):
            if method.history is None or name not in method.parameter_names:
                continue
            column = method.parameter_names.index(name)
            time_s = train.time_s[method.history.rows]
            traces.append(
                Trace(name=method.title, x=time_s, y=method.history.theta[:, column], number=number)
            )
        finals = [trace.y[-1] for trace in traces]
        panels.append(
            Panel(title=name, y_label=name, traces=tuple(traces), y_range=_range_of(np.array([*finals, 0.0])))
        )
    return Chart(
        key="parameters",
        title="Parameters during training",
        x_label="time [s]",
        panels=tuple(panels),
    )


def _residual_chart(methods: list[MethodResult], sample_time_s: float) -> Chart:
    auto, cross = [], []
    for number, method in enumerate(methods):
        values = np.asarray(method.residuals.autocorrelation)
        lags = np.arange(1, values.size + 1) * sample_time_s
        auto.append(Trace(name=method.title, x=lags, y=values, number=number, stems=True))
        values = np.asarray(method.residuals.cross_correlation)
        lags = (np.arange(values.size) - values.size // 2) * sample_time_s
        trace = Trace(name=method.title, x=lags, y=values, number=number, stems=True)
        cross.append(
            Panel(
                title=f"{method.title}: correlation of input and later residual (negative lags: feedback)",
                y_label="correlation",
                traces=(trace,),
                band=method.residuals.cross_correlation_band,
            )
        )
    first = Panel(
        title="autocorrelation of the frozen one-step residual, test record (band: 99 % of white noise)",
        y_label="correlation",
        traces=tuple(auto),
        band=methods[0].residuals.autocorrelation_band,
    )
    return Chart(
        key="residuals", title="What the residuals still hold", x_label="lag [s]", panels=(first, *cross)
    )
