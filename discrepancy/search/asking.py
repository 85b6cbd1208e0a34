"""Which experiment tells fitted models apart that these records do not, within the rig's limits."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from discrepancy.design.limits import RigLimits
from discrepancy.design.prediction import Stage
from discrepancy.design.proposal import Proposal, propose
from discrepancy.design.question import Question, Rival, Wanted, wanted_of
from discrepancy.search.choice import Contender
from discrepancy.search.entries import Entry, proposed
from discrepancy.search.greedy import Round
from discrepancy.search.known import GOOD_ERROR, POOR_ERROR, poorly_known
from discrepancy.search.options import SearchOptions
from discrepancy.search.outcome import SearchOutcome, Step
from discrepancy.search.outputs import output_counts

LEAST = 0.05
"""Below this share of what is needed by every pair, a proposal does not tell rivals apart."""
SAFETY = 2.0
"""A predicted distance scatters by twice its root when it is measured: ask for more than the search does."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Asker:
    """The finished search, the rig's limits, and how well each parameter of the last model is known."""

    outcome: SearchOutcome
    limits: RigLimits
    errors: Mapping[str, Mapping[str, float]]

    def stage(self, done: Round | None) -> Stage:
        """Return where predictions are made, in the noise that a round (the whole search) was judged in."""
        problem = self.outcome.problem if done is None else done.problem
        return Stage(
            template=problem.series[0], noise=problem.noise, limits=self.limits, known=problem.series
        )

    def before(self, step: Step) -> tuple[Step, ...]:
        """Return the steps that were accepted before this one."""
        names = [one.added for one in self.outcome.steps]
        return self.outcome.steps[: names.index(step.added)]

    def wanted(self, rival: Rival, owner: str) -> tuple[Wanted, ...]:
        """Return which parameters of an effect are known too poorly."""
        told, _ = poorly_known(self.outcome, rival.state, owner, self.errors.get(owner, {}))
        return wanted_of(rival.state, owner, told, (POOR_ERROR, GOOD_ERROR))


def rival_of(contender: Contender) -> Rival:
    """Return a contender as what a question is about."""
    return Rival(name=contender.name, state=contender.state)


def _needed(
    outcome: SearchOutcome,
    before: Sequence[Step],
    pair: tuple[Contender, Contender],
    duration_s: float,
) -> float:
    """Return the distance, in noise variances, that is wanting until the search tells two rivals apart.

    Args:
        outcome: the finished search.
        before: steps accepted before the round in question; what they closed decides what is visible.
        pair: the rivals as they stand; what already tells them apart counts.
        duration_s: of the record that is to do it.
    """
    options, problem = SearchOptions(), outcome.problem
    closed = np.sqrt(sum((step.closed**2 for step in before), np.zeros(1)))
    visible = 0.5 * replace(outcome.context, closed=closed).material(options, ())
    counts = output_counts(problem)
    first, other = pair
    fall = SAFETY * options.doubt - max(0.0, first.fall - other.fall)
    apart = SAFETY * visible**2 * (counts + duration_s / problem.series[0].step)
    apart = apart - np.maximum(0.0, first.closed**2 - other.closed**2) * counts
    # The output that tells them apart first suffices.
    return max(1.0, fall, float(np.min(apart * outcome.context.bin_size)))


def between(
    asker: Asker,
    done: Round | None,
    rest: tuple[Sequence[Contender], Sequence[Step]],
    wanted: tuple[Wanted, ...] = (),
) -> Entry | None:
    """Return the experiment that tells the first of several contenders from the others; None if none does.

    Args:
        asker: the finished search.
        done: the round that judged the contenders, None for the whole search.
        rest: the contenders, and the steps that were accepted before them.
        wanted: parameters of the first to be measured by the same record.
    """
    contenders, before = rest
    if len(contenders) < 2:
        return None

    def needed(duration_s: float, i: int) -> float:
        return _needed(asker.outcome, before, (contenders[0], contenders[i + 1]), duration_s)

    rivals = tuple(rival_of(one) for one in contenders)
    stage = asker.stage(done)
    proposal = propose(stage, Question(rivals=rivals, needed=needed, wanted=wanted))
    if (
        proposal is None
        or max(d / needed(proposal.duration_s, i) for i, d in enumerate(proposal.distances)) < LEAST
    ):
        return None
    return proposed(_apart(stage, rivals, proposal), [one.name for one in rivals], proposal)


def _apart(stage: Stage, rivals: Sequence[Rival], proposal: Proposal) -> str:
    """Return what the prediction says, in the output's own unit."""
    channel = stage.template.channels[0].name
    samples = proposal.duration_s / stage.template.step
    told = [
        f"{other.name} stays {math.sqrt(far / samples) * stage.noise.sigma[channel]:.2g} (rms of {channel}) off"
        for other, far in zip(rivals[1:], proposal.distances, strict=True)
    ]
    return f"refitted to what {rivals[0].name} predicts here, {', '.join(told)}"
