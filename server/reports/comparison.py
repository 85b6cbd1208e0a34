"""The comparison table as plain rows, the same for terminal, page and tests."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

from estimators.metrics import Score
from estimators.result import IdentificationResult, Mode, Phase

MODE_TITLES = {
    Mode.A_PRIORI: "a priori",
    Mode.A_POSTERIORI: "a posteriori",
    Mode.ONE_STEP_FROZEN: "frozen one-step",
    Mode.FREE_RUN: "free run",
}
TRIVIAL_TITLE = "y(k) = y(k-1)"
NONE = "-"


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One line of the table.

    Attributes:
        phase: training or test.
        title: the estimator, or the trivial prediction.
        figures: adjusted R2 by mode, as text; `NONE` where there is no such figure.
        free_run_rmse: root mean square error of the free run, in the output's unit, as text.
        time_ms: computing time of training and test together, as text; on the training rows only.
    """

    phase: Phase
    title: str
    figures: dict[Mode, str]
    free_run_rmse: str
    time_ms: str = ""


def comparison_rows(result: IdentificationResult) -> Iterator[Row]:
    """Yield the rows: for each phase every estimator, then the trivial prediction."""
    for phase in Phase:
        for method in result.methods.values():
            scores = method.scores[phase]
            elapsed = method.computing_time_s
            yield Row(
                phase=phase,
                title=method.title,
                figures={mode: format_score(scores.get(mode)) for mode in Mode},
                free_run_rmse=_format_rmse(scores.get(Mode.FREE_RUN)),
                time_ms=f"{elapsed * 1e3:.1f}" if elapsed is not None and phase is Phase.TRAINING else "",
            )
        trivial = result.trivial[phase]
        figures = dict.fromkeys(Mode, NONE) | {Mode.A_PRIORI: format_score(trivial)}
        yield Row(phase=phase, title=TRIVIAL_TITLE, figures=figures, free_run_rmse=NONE)


def format_score(score: Score | None) -> str:
    """Write an adjusted R2 with six decimals, a very bad one shorter, none as a dash."""
    if score is None:
        return NONE
    value = score.r2_adjusted
    if not math.isfinite(value):
        return "diverges"
    return f"{value:.6f}" if value > -10.0 else f"{value:.1e}"


def _format_rmse(score: Score | None) -> str:
    if score is None:
        return NONE
    return f"{score.rmse:.4g}" if math.isfinite(score.rmse) else "diverges"


def format_measure(value: float, std: float) -> str:
    """Write a value with its standard error; an unknown error is left out."""
    if not math.isfinite(value):
        return "none"
    return f"{value:.5g} ± {std:.2g}" if math.isfinite(std) else f"{value:.5g}"


def describe_models(result: IdentificationResult) -> Iterator[tuple[str, list[str]]]:
    """Yield each estimator's title and lines on its transfer functions, poles and static gain."""
    for method in result.methods.values():
        gain = method.static_gain
        poles = ", ".join(_format_pole(pole.re, pole.im, pole.std_magnitude) for pole in method.poles)
        static = format_measure(gain.value, gain.std)
        if not gain.determined:
            static += " (not determined by these data)"
        continuous = getattr(method.continuous, "text", None)
        reason = getattr(method.continuous, "reason", "")
        lines = [
            f"G(z) = {method.transfer_function.text}",
            f"G(s) = {continuous}" if continuous else f"G(s): none, {reason}",
            f"poles {poles};  static gain {static}",
        ]
        yield method.title, lines + [f"warning: {warning}" for warning in method.warnings]


def describe_order(result: IdentificationResult) -> str:
    """Return which order the data ask for, in a sentence; empty when nobody asked or none fits."""
    best = result.selection.best if result.selection else None
    if best is None:
        return ""
    return (
        f"By free run on training data that the fit has not seen, order {best.order} with delay {best.delay} "
        f"is best (R² {best.r2:.6f}); identified here: order {result.options.order}, "
        f"delay {result.options.delay}."
    )


def _format_pole(re: float, im: float, std: float) -> str:
    place = f"{re:.5g}" if im == 0.0 else f"{re:.4g}{im:+.4g}j"
    return f"{place} ± {std:.2g}" if math.isfinite(std) else place
