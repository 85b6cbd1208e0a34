"""What an identification found: frozen records, and their JSON form "jointscope.identification/1"."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from estimators.continuous import ContinuousModel, ContinuousRefusal
from estimators.dataset import Dataset, Vector
from estimators.excitation import ExcitationReport
from estimators.metrics import Score
from estimators.model import DiscreteModel
from estimators.residuals import ResidualReport
from estimators.selection import OrderSelection
from estimators.settings import IdentifyOptions
from estimators.transfer_function import Pole, StaticGain, TransferFunction

SCHEMA = "jointscope.identification/1"


class Phase(Enum):
    """Which record."""

    TRAINING = "training"
    TEST = "test"


class Mode(Enum):
    """How an output series was computed; the value is its key in JSON."""

    A_PRIORI = "a_priori"
    A_POSTERIORI = "a_posteriori"
    ONE_STEP_FROZEN = "one_step_frozen"
    FREE_RUN = "free_run"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ParameterHistory:
    """Parameters during training.

    Attributes:
        rows: index of each sample in the training data, shape (M,).
        theta: parameters after it, shape (M, n).
    """

    rows: NDArray[np.int64]
    theta: NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MethodResult:
    """One estimator's result.

    Attributes:
        name: its key in the table of estimators.
        title: its name for a reader.
        parameter_names: a1, a2, b0, ...
        theta: parameters at the end of training, shape (n,).
        standard_errors: of theta, shape (n,).
        noise_variance: of the equation error, in units of Rv (of y squared where Rv is 1).
        weights: the recursion's weights (lam, rv, rw, p0); empty for batch estimators.
        model: the frozen model.
        transfer_function: discrete.
        poles: of the frozen model, largest first.
        static_gain: of the frozen model.
        continuous: the continuous model or why there is none.
        scores: by phase and mode; batch estimators have no a-priori and a-posteriori output.
        series: the predicted series, as scores; NaN where there is none.
        residuals: of the frozen one-step prediction on test data.
        history: parameters during training; None for batch estimators.
        rejected: training and test samples that the estimator refused.
        warnings: sentences for the reader.
        computing_time_s: training and test, predictions included; None if no clock was given.
    """

    name: str
    title: str
    parameter_names: tuple[str, ...]
    theta: Vector
    standard_errors: Vector
    noise_variance: float
    weights: Mapping[str, object]
    model: DiscreteModel
    transfer_function: TransferFunction
    poles: tuple[Pole, ...]
    static_gain: StaticGain
    continuous: ContinuousModel | ContinuousRefusal
    scores: Mapping[Phase, Mapping[Mode, Score]]
    series: Mapping[Phase, Mapping[Mode, Vector]]
    residuals: ResidualReport
    history: ParameterHistory | None
    rejected: int
    warnings: tuple[str, ...]
    computing_time_s: float | None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class IdentificationResult:
    """The comparison of all estimators on one pair of records.

    Attributes:
        options: what was asked for.
        train: training data. test: test data.
        methods: results by name, in the order asked for.
        trivial: the yardstick y(k-1), by phase.
        verdict: what the table means, in sentences made from its numbers.
        excitation: what the training data can determine.
        selection: ranking of orders and delays; None if not asked for.
    """

    options: IdentifyOptions
    train: Dataset
    test: Dataset
    methods: Mapping[str, MethodResult]
    trivial: Mapping[Phase, Score]
    verdict: tuple[str, ...]
    excitation: ExcitationReport
    selection: OrderSelection | None

    def to_dict(self) -> dict[str, object]:
        """Return the JSON form with all series (schema: docs/estimators.md); NaN and inf become null."""
        from estimators.export import export_result  # here: the JSON form knows the records, not the reverse

        return export_result(self)
