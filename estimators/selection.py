"""Order and delay by free run on data that the fit has not seen."""

import math
from dataclasses import dataclass, replace

import numpy as np

from estimators.dataset import Dataset
from estimators.instrumental import solve_instrumental
from estimators.metrics import score_series
from estimators.model import model_from_theta, simulate_free_run
from estimators.settings import IdentifyOptions

# Share of the training data that a candidate is fitted on; the rest validates it.
_FIT_SHARE = 0.7
# Enough to rank candidates; an over-parameterised one would go round its flat valley for longer.
_MAX_ITERATIONS = 6


@dataclass(frozen=True, slots=True, kw_only=True)
class OrderCandidate:
    """One order and delay.

    Attributes:
        order: past outputs and past inputs of the model.
        delay: samples between input and first effect.
        bic: N log(free-run mean square error on validation) + p log N; inf if it cannot be simulated.
        r2: free-run R2 on validation; NaN if it cannot be simulated.
    """

    order: int
    delay: int
    bic: float
    r2: float


@dataclass(frozen=True, slots=True, kw_only=True)
class OrderSelection:
    """Candidates ranked, best first; `best` is None when none could be simulated."""

    candidates: tuple[OrderCandidate, ...]
    best: OrderCandidate | None


def select_order(
    train: Dataset, options: IdentifyOptions, max_order: int = 3, max_delay: int = 3
) -> OrderSelection:
    """Rank orders 1..max_order and delays 1..max_delay by the BIC of their free run.

    Each candidate is fitted by instrumental variables on the first 70 % of the training data and simulated
    over the rest. Free run, not one step: on slow signals every order predicts one step well. The errors of a
    free run are correlated, so N overstates what they know and the BIC leans towards higher orders; a
    difference of a few units means nothing.

    Raises:
        ValueError: If the limits are below one.
    """
    if max_order < 1 or max_delay < 1:
        raise ValueError(f"max_order={max_order} and max_delay={max_delay} must be at least 1")
    split = int(train.n * _FIT_SHARE)
    fit, validation = train.take(0, split), train.take(split, train.n)
    first = max_order + max_delay
    candidates = [
        _judge(fit, validation, replace(options, order=order, delay=delay), first)
        for order in range(1, max_order + 1)
        for delay in range(1, max_delay + 1)
    ]
    ranked = sorted(candidates, key=lambda candidate: candidate.bic)
    return OrderSelection(candidates=tuple(ranked), best=ranked[0] if math.isfinite(ranked[0].bic) else None)


def _judge(fit: Dataset, validation: Dataset, options: IdentifyOptions, first: int) -> OrderCandidate:
    """Fit one candidate and score it on the same samples as all others."""
    estimate = solve_instrumental(fit, options.structure, _MAX_ITERATIONS)
    model = model_from_theta(estimate.theta, estimate.covariance, options.structure, fit.sample_time_s)
    rows = np.concatenate(
        [np.arange(s.start + first, max(s.start + first, s.stop)) for s in validation.segments]
    )
    nothing = OrderCandidate(order=options.order, delay=options.delay, bic=math.inf, r2=math.nan)
    if not model.simulable or rows.size <= options.structure.n_parameters:
        return nothing
    p = options.structure.n_parameters
    score = score_series(validation.y, simulate_free_run(model, validation), p, rows)
    if not math.isfinite(score.r2):
        return nothing
    error = max(score.rmse, np.finfo(float).tiny)
    bic = score.n * 2.0 * math.log(error) + p * math.log(score.n)
    return OrderCandidate(order=options.order, delay=options.delay, bic=bic, r2=score.r2)
