"""Run one estimator of the table on a pair of records; nothing is judged here."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from estimators.dataset import Dataset, Vector
from estimators.model import DiscreteModel, model_from_theta, shift_by_one
from estimators.recursive import RecursiveEstimator
from estimators.regressors import Regression, build_regression
from estimators.result import Mode, ParameterHistory, Phase
from estimators.settings import IdentifyOptions
from estimators.state import EstimatorState
from estimators.table import BatchSpec, RecursiveSpec


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Case:
    """A pair of records with their regressors.

    Attributes:
        options: what to identify and how.
        records: data sets by phase.
        regressions: their rows, with the structure of the options.
    """

    options: IdentifyOptions
    records: Mapping[Phase, Dataset]
    regressions: Mapping[Phase, Regression]

    def scored_rows(self, phase: Phase) -> NDArray[np.int64]:
        """Return the samples that every method is scored on: one more past sample than the regressors need.

        The literal Algorithm 1 has a regressor one sample older; this way all compare on the same samples.
        """
        regression = self.regressions[phase]
        return np.concatenate([regression.rows[bound][1:] for bound in regression.bounds])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Fit:
    """What an estimator found.

    Attributes:
        parameter_names: in the order of theta.
        theta: parameters at the end of training, shape (n,).
        covariance: of theta, shape (n, n).
        noise_variance: of the equation error.
        model: the frozen model.
        series: a-priori and a-posteriori outputs by phase; empty for batch estimators.
        history: parameters during training; None for batch estimators.
        weights: of the recursion; empty for batch estimators.
        rejected: samples refused in both records.
        notes: sentences for the reader.
    """

    parameter_names: tuple[str, ...]
    theta: Vector
    covariance: NDArray[np.float64]
    noise_variance: float
    model: DiscreteModel
    series: Mapping[Phase, Mapping[Mode, Vector]]
    history: ParameterHistory | None
    weights: Mapping[str, object]
    rejected: int
    notes: tuple[str, ...]

    @property
    def standard_errors(self) -> Vector:
        """Standard error of each parameter, shape (n,)."""
        return np.asarray(np.sqrt(np.diag(self.covariance)), dtype=np.float64)


def build_case(train: Dataset, test: Dataset, options: IdentifyOptions) -> Case:
    """Check that the records fit each other and build their regressors.

    Raises:
        ValueError: If the sample times differ or a record is too short.
    """
    if abs(train.sample_time_s - test.sample_time_s) > 1e-6 * train.sample_time_s:
        raise ValueError(
            f"training data are sampled every {train.sample_time_s} s and test data every "
            f"{test.sample_time_s} s; a discrete model belongs to one sample time: resample one of them"
        )
    records = {Phase.TRAINING: train, Phase.TEST: test}
    regressions = {phase: build_regression(data, options.structure) for phase, data in records.items()}
    return Case(options=options, records=records, regressions=regressions)


def fit_recursive(spec: RecursiveSpec, case: Case) -> Fit:
    """Learn the training record, freeze a model, and run on, adapting, over the test record."""
    regression = case.regressions[Phase.TRAINING]
    estimator = spec.prepare(regression, case.options)
    structure = replace(case.options.structure, nc=estimator.theta0.size - estimator.n_phi)
    state = estimator.init()
    training, history = run_segments(estimator, state, case.records[Phase.TRAINING], regression)
    trained = state.copy()
    test, _ = run_segments(estimator, state, case.records[Phase.TEST], case.regressions[Phase.TEST])
    covariance = trained.covariance()
    sample_time_s = case.records[Phase.TRAINING].sample_time_s
    model = model_from_theta(trained.theta, covariance, structure, sample_time_s)
    weights = estimator.weights
    return Fit(
        parameter_names=structure.parameter_names,
        theta=trained.theta,
        covariance=covariance,
        noise_variance=trained.noise_variance(),
        model=shift_by_one(model) if weights.lagged else model,
        series={Phase.TRAINING: training, Phase.TEST: test},
        history=history,
        weights={
            "lam": weights.lam,
            "rv": weights.rv,
            "rw": weights.rw.tolist(),
            "p0": weights.p0.tolist(),
        },
        rejected=state.rejected,
        notes=_note_rejections(state),
    )


def fit_batch(spec: BatchSpec, case: Case) -> Fit:
    """Estimate from the whole training record at once."""
    train = case.records[Phase.TRAINING]
    estimate = spec.fit(train, case.options)
    structure = case.options.structure
    return Fit(
        parameter_names=structure.parameter_names,
        theta=estimate.theta,
        covariance=estimate.covariance,
        noise_variance=estimate.noise_variance,
        model=model_from_theta(estimate.theta, estimate.covariance, structure, train.sample_time_s),
        series={phase: {} for phase in Phase},
        history=None,
        weights={},
        rejected=0,
        notes=estimate.notes,
    )


def run_segments(
    estimator: RecursiveEstimator, state: EstimatorState, dataset: Dataset, regression: Regression
) -> tuple[dict[Mode, Vector], ParameterHistory]:
    """Advance the state through all segments.

    Returns:
        A-priori and a-posteriori outputs, shape (N,), NaN where there is no regressor; and the parameters.
    """
    series = {Mode.A_PRIORI: np.full(dataset.n, np.nan), Mode.A_POSTERIORI: np.full(dataset.n, np.nan)}
    theta = np.empty((regression.y.size, estimator.theta0.size))
    for bound in regression.bounds:
        state.begin_segment()
        trace = estimator.run(state, regression.phi[bound], regression.y[bound])
        series[Mode.A_PRIORI][regression.rows[bound]] = trace.prior
        series[Mode.A_POSTERIORI][regression.rows[bound]] = trace.posterior
        theta[bound] = trace.theta
    return series, ParameterHistory(rows=regression.rows, theta=theta)


def _note_rejections(state: EstimatorState) -> tuple[str, ...]:
    if not state.rejected:
        return ()
    return (f"{state.rejected} samples were refused because a result was not finite",)
