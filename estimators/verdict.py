"""What a table of scores means, said in sentences that are made from its numbers and from nothing else."""

import math
from collections.abc import Mapping, Sequence

from estimators.metrics import Score
from estimators.result import MethodResult, Mode, Phase

# Error variances that differ by less than this share are called level.
_LEVEL = 0.10
# A trivial prediction this good leaves one-step figures with little to say.
_TRIVIAL_IS_GOOD = 0.95
# An estimator follows instead of knowing when using a sample removes this share of its error, although its
# free run misses this many times more than its a-posteriori output.
_FOLLOWED_SHARE = 0.75
_FREE_RUN_RATIO = 10.0
# Below this an R2 only says that a simulation went away.
_LOWEST_R2 = -100.0
_USABLE_FREE_RUN = 0.5


def write_verdict(methods: Mapping[str, MethodResult], trivial: Mapping[Phase, Score]) -> tuple[str, ...]:
    """Return two to five sentences on the test data, the most important ones first."""
    results = list(methods.values())
    sentences = [_rank_free_runs(results), _weigh_one_step(results, trivial[Phase.TEST])]
    sentences += _name_followers(results)
    return tuple(sentence for sentence in sentences if sentence)


def format_r2(value: float) -> str:
    """Write an R2 with as many digits as its distance from one needs."""
    if not math.isfinite(value):
        return "none"
    if value < _LOWEST_R2:
        return f"below {_LOWEST_R2:.0f}"
    missing = abs(1.0 - value)
    digits = 4 if missing == 0 else min(8, max(3, 1 - math.floor(math.log10(missing))))
    return f"{value:.{digits}f}"


def _score(result: MethodResult, mode: Mode) -> float:
    score = result.scores[Phase.TEST].get(mode)
    return score.r2_adjusted if score else math.nan


def _rank_free_runs(results: Sequence[MethodResult]) -> str:
    """Say who simulates best, and who cannot be simulated."""
    able = [r for r in results if r.model.simulable and math.isfinite(_score(r, Mode.FREE_RUN))]
    unable = [r for r in results if r not in able]
    ranked = sorted(able, key=lambda r: -_score(r, Mode.FREE_RUN))
    parts = []
    if ranked:
        best = _score(ranked[0], Mode.FREE_RUN)
        level = [r for r in ranked if 1 - _score(r, Mode.FREE_RUN) <= (1 + _LEVEL) * (1 - best)]
        behind = [r for r in ranked if r not in level]
        order = f"{_join([_name_free_run(r) for r in level])} {'are level' if len(level) > 1 else 'is best'}"
        parts.append(order if len(ranked) > 1 else _name_free_run(ranked[0]))
        if behind:
            parts[0] += f", followed by {_join([_name_free_run(r) for r in behind])}"
        if best < _USABLE_FREE_RUN:
            parts.append("no model explains the record")
    if unable:
        poles = _join([f"{r.title} (largest pole {r.poles[0].magnitude:.4g})" for r in unable])
        parts.append(f"{poles} cannot be simulated")
    return f"In free run on the test record, the one figure here that judges a model: {'; '.join(parts)}."


def _name_free_run(result: MethodResult) -> str:
    return f"{result.title} ({format_r2(_score(result, Mode.FREE_RUN))})"


def _weigh_one_step(results: Sequence[MethodResult], trivial: Score) -> str:
    """Say what one-step figures are worth beside the trivial prediction."""
    frozen = [r for r in results if math.isfinite(_score(r, Mode.ONE_STEP_FROZEN))]
    if not frozen or not math.isfinite(trivial.r2_adjusted):
        return ""
    best = max(frozen, key=lambda r: _score(r, Mode.ONE_STEP_FROZEN))
    own = _score(best, Mode.ONE_STEP_FROZEN)
    yardstick = (
        f"The trivial prediction y(k) = y(k-1) reaches {format_r2(trivial.r2_adjusted)} one step ahead"
    )
    if own <= trivial.r2_adjusted:
        return f"{yardstick}, and no frozen model does better ({best.title} {format_r2(own)})."
    share = (1 - own) / (1 - trivial.r2_adjusted)
    worth = (
        "so a one-step figure near 1 is no evidence of a model"
        if trivial.r2_adjusted >= _TRIVIAL_IS_GOOD
        else "so one-step figures do tell models apart here"
    )
    return (
        f"{yardstick}, {worth}; the best frozen model ({best.title}, {format_r2(own)}) leaves "
        f"{100 * share:.2g} % of the trivial error variance."
    )


def _name_followers(results: Sequence[MethodResult]) -> list[str]:
    """Name estimators whose a-posteriori figure flatters them."""
    followers = [result for result in results if _follows(result)]
    if not followers:
        return []
    named = _join([f"{r.title} ({format_r2(_score(r, Mode.A_POSTERIORI))})" for r in followers])
    many = len(followers) > 1
    return [
        f"The a-posteriori figure{'s' if many else ''} of {named} {'are' if many else 'is'} no achievement: this "
        "output was corrected with the very sample it is compared with, by parameters that follow the samples "
        "instead of describing the joint."
    ]


def _follows(result: MethodResult) -> bool:
    prior, posterior = _score(result, Mode.A_PRIORI), _score(result, Mode.A_POSTERIORI)
    if not (math.isfinite(prior) and math.isfinite(posterior)):
        return False
    free = _score(result, Mode.FREE_RUN)
    misses = not math.isfinite(free) or 1 - free > _FREE_RUN_RATIO * (1 - posterior)
    return misses and 1 - posterior < (1 - _FOLLOWED_SHARE) * (1 - prior)


def _join(items: Sequence[str]) -> str:
    return items[0] if len(items) == 1 else f"{', '.join(items[:-1])} and {items[-1]}"
