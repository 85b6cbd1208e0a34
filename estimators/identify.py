"""Identification of one joint from a training and a test record: every estimator, every figure of merit."""

import math
from collections.abc import Callable, Mapping, Sequence

from estimators.continuous import convert_to_continuous
from estimators.dataset import Dataset, Vector
from estimators.excitation import report_excitation
from estimators.fit import Case, Fit, build_case, fit_batch, fit_recursive
from estimators.metrics import Score, score_series
from estimators.model import predict_one_step, simulate_free_run
from estimators.residuals import ResidualReport, analyse_residuals
from estimators.result import IdentificationResult, MethodResult, Mode, Phase
from estimators.selection import select_order
from estimators.settings import IdentifyOptions
from estimators.table import BatchSpec, RecursiveSpec, find_estimator
from estimators.transfer_function import (
    Pole,
    StaticGain,
    describe_poles,
    find_static_gain,
    form_transfer_function,
)
from estimators.verdict import write_verdict

Clock = Callable[[], float]
SeriesByPhase = Mapping[Phase, Mapping[Mode, Vector]]
ScoresByPhase = Mapping[Phase, Mapping[Mode, Score]]


def identify(
    train: Dataset, test: Dataset, options: IdentifyOptions, clock: Clock | None = None
) -> IdentificationResult:
    """Estimate on the training record, freeze, and judge on both records.

    Args:
        train: data to learn from.
        test: data that only score. Recursive estimators also run on, adapting, over the test record for the
            a-priori and a-posteriori figures; one-step and free-run figures use the frozen parameters.
        options: what to identify and how.
        clock: seconds, such as time.perf_counter, to have the computing times; None leaves them out. Each
            method then runs twice, since its first run may have to load or compile its kernels.

    Raises:
        ValueError: If the records do not fit each other or are too short, or an estimator is unknown.
    """
    specs = {name: find_estimator(name) for name in options.methods}
    case = build_case(train, test, options)
    methods = {name: _run_method(name, spec, case, clock) for name, spec in specs.items()}
    trivial = {phase: score_trivial(case, phase) for phase in Phase}
    return IdentificationResult(
        options=options,
        train=train,
        test=test,
        methods=methods,
        trivial=trivial,
        verdict=write_verdict(methods, trivial),
        excitation=report_excitation(train, case.regressions[Phase.TRAINING]),
        selection=select_order(train, options) if options.select_order else None,
    )


def score_trivial(case: Case, phase: Phase) -> Score:
    """Score the prediction y(k) = y(k-1), which knows nothing of the joint and has no parameters."""
    y = case.records[phase].y
    rows = case.scored_rows(phase)
    previous = y.copy()
    previous[rows] = y[rows - 1]
    return score_series(y, previous, 0, rows)


def _run_method(name: str, spec: RecursiveSpec | BatchSpec, case: Case, clock: Clock | None) -> MethodResult:
    """Estimate, predict and score with one estimator, then describe what it found."""
    if clock:
        _compute(spec, case)  # loading or compiling the kernels is not part of a method's computing time
    begin = clock() if clock else 0.0
    fit, series, scores = _compute(spec, case)
    elapsed = clock() - begin if clock else None
    poles, gain = describe_poles(fit.model), find_static_gain(fit.model)
    return MethodResult(
        name=name,
        title=spec.title,
        parameter_names=fit.parameter_names,
        theta=fit.theta,
        standard_errors=fit.standard_errors,
        noise_variance=fit.noise_variance,
        weights=fit.weights,
        model=fit.model,
        transfer_function=form_transfer_function(fit.model),
        poles=poles,
        static_gain=gain,
        continuous=convert_to_continuous(fit.model),
        scores=scores,
        series=series,
        residuals=_analyse(series, case),
        history=fit.history,
        rejected=fit.rejected,
        warnings=(*fit.notes, *_write_warnings(fit, poles, gain)),
        computing_time_s=elapsed,
    )


def _compute(spec: RecursiveSpec | BatchSpec, case: Case) -> tuple[Fit, SeriesByPhase, ScoresByPhase]:
    """Do what the paper's computing times stand for: estimate, predict both records and score them."""
    fit = fit_recursive(spec, case) if isinstance(spec, RecursiveSpec) else fit_batch(spec, case)
    series = {phase: _complete_series(fit, case, phase) for phase in Phase}
    scores = {phase: _score_all(series[phase], fit, case, phase) for phase in Phase}
    return fit, series, scores


def _complete_series(fit: Fit, case: Case, phase: Phase) -> dict[Mode, Vector]:
    """Return all output series of one phase, in the order of the modes."""
    dataset = case.records[phase]
    return {
        **fit.series[phase],
        Mode.ONE_STEP_FROZEN: predict_one_step(fit.model, dataset),
        Mode.FREE_RUN: simulate_free_run(fit.model, dataset),
    }


def _score_all(series: Mapping[Mode, Vector], fit: Fit, case: Case, phase: Phase) -> dict[Mode, Score]:
    y, rows, p = case.records[phase].y, case.scored_rows(phase), fit.theta.size
    return {mode: score_series(y, values, p, rows) for mode, values in series.items()}


def _analyse(series: SeriesByPhase, case: Case) -> ResidualReport:
    """Test the frozen one-step errors on the test record."""
    dataset, regression = case.records[Phase.TEST], case.regressions[Phase.TEST]
    # Start one row late in each segment, as the scores do, and renumber the segments without gaps.
    bounds, first = [], 0
    for bound in regression.bounds:
        length = bound.stop - bound.start - 1
        bounds.append(slice(first, first + length))
        first += length
    rows = case.scored_rows(Phase.TEST)
    residual = dataset.y[rows] - series[Phase.TEST][Mode.ONE_STEP_FROZEN][rows]
    return analyse_residuals(residual, dataset.u[rows], tuple(bounds), case.options.max_lag)


def _write_warnings(fit: Fit, poles: Sequence[Pole], gain: StaticGain) -> tuple[str, ...]:
    """Say what the model must not be used for."""
    warnings = []
    if not fit.model.simulable:
        warnings.append(
            f"the largest pole has magnitude {poles[0].magnitude:.5g}, on or outside the unit circle: "
            "the model cannot be simulated; its free-run figures describe a divergence"
        )
    elif poles[0].magnitude + 2 * poles[0].std_magnitude >= 1.0:
        warnings.append(
            f"the largest pole, {poles[0].magnitude:.5g} with standard error {poles[0].std_magnitude:.2g}, "
            "cannot be told from the unit circle: a free run may drift"
        )
    if not gain.determined:
        distance = 1.0 + float(fit.model.a.sum())
        warnings.append(
            f"1 + a1 + a2 + ... = {distance:.3g} is zero within its error: the model (almost) integrates, "
            "its static gain is not determined"
        )
    if not all(math.isfinite(error) for error in fit.standard_errors):
        warnings.append("the data do not determine every parameter: some standard errors are infinite")
    return tuple(warnings)
