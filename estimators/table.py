"""The table of estimators: the one place to add a variant to. Contract tests run over it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from estimators.batch_ls import BatchEstimate, fit_least_squares
from estimators.dataset import Dataset
from estimators.erls import prepare_erls
from estimators.instrumental import fit_instrumental
from estimators.recursive import RecursiveEstimator
from estimators.regressors import Regression
from estimators.rls import prepare_rls
from estimators.rls_directional import prepare_rls_directional
from estimators.rls_kf import prepare_rls_kf
from estimators.rls_kf_literal import prepare_rls_kf_literal
from estimators.rls_kf_ml import prepare_rls_kf_ml
from estimators.settings import IdentifyOptions


@dataclass(frozen=True, slots=True, kw_only=True)
class RecursiveSpec:
    """An estimator that learns sample by sample.

    Attributes:
        title: name for a reader.
        summary: what it is for, in one sentence.
        takes: fields of `IdentifyOptions` that change what it does, beside the model's structure.
        prepare: makes the estimator for a data set, which only sets scales (`rls_kf_ml`: and the noise).
    """

    title: str
    summary: str
    prepare: Callable[[Regression, IdentifyOptions], RecursiveEstimator]
    takes: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class BatchSpec:
    """An estimator that takes all samples at once.

    Attributes:
        title: name for a reader.
        summary: what it is for, in one sentence.
        takes: fields of `IdentifyOptions` that change what it does, beside the model's structure.
        fit: estimates from a data set.
    """

    title: str
    summary: str
    fit: Callable[[Dataset, IdentifyOptions], BatchEstimate]
    takes: tuple[str, ...] = ()


ESTIMATORS: Mapping[str, RecursiveSpec | BatchSpec] = MappingProxyType(
    {
        "rls": RecursiveSpec(
            title="RLS",
            summary="recursive least squares, eq. 2-4 of the paper; optional forgetting and covariance reset",
            prepare=prepare_rls,
            takes=("forgetting", "reset_interval", "start_near_zero"),
        ),
        "erls": RecursiveSpec(
            title="ERLS",
            summary="extended recursive least squares, eq. 5-9: models coloured noise as well",
            prepare=prepare_erls,
            takes=("residual_terms", "forgetting", "reset_interval", "start_near_zero"),
        ),
        "rls_kf": RecursiveSpec(
            title="RLS-KF",
            summary="Kalman filter for drifting parameters with the paper's Rw = Rv = 0.99",
            prepare=prepare_rls_kf,
            takes=("rw", "rv", "start_near_zero"),
        ),
        "rls_kf_ml": RecursiveSpec(
            title="RLS-KF (ML)",
            summary="the same with Rw and Rv estimated by maximum likelihood of the innovations",
            prepare=prepare_rls_kf_ml,
        ),
        "rls_kf_literal": RecursiveSpec(
            title="RLS-KF (literal)",
            summary="Algorithm 1 as printed, with a regressor one sample old; for comparison with the paper",
            prepare=prepare_rls_kf_literal,
            takes=("rw", "rv", "start_near_zero"),
        ),
        "rls_directional": RecursiveSpec(
            title="RLS (directional)",
            summary="recursive least squares that forgets only where new information comes in",
            prepare=prepare_rls_directional,
            takes=("directional_forgetting", "start_near_zero"),
        ),
        "ls": BatchSpec(
            title="LS",
            summary="batch least squares, the reference for the recursive estimators",
            fit=fit_least_squares,
        ),
        "iv": BatchSpec(
            title="IV",
            summary="refined instrumental variables: no bias from noise on the output",
            fit=fit_instrumental,
        ),
    }
)


def find_estimator(name: str) -> RecursiveSpec | BatchSpec:
    """Return the entry of the table.

    Raises:
        ValueError: If there is no such estimator; the message lists those that exist.
    """
    spec = ESTIMATORS.get(name)
    if spec is None:
        raise ValueError(f"methods: {name!r} is not an estimator; choose from {', '.join(ESTIMATORS)}")
    return spec
