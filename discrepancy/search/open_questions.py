"""What the search leaves open, and the experiment that would settle it."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from discrepancy.next_experiment import RigLimits, propose_between, propose_for_parameter
from discrepancy.search.finish import SearchOutcome
from discrepancy.search.judge import robust_covariance

POOR_ERROR = 0.1
"""A parameter whose relative standard error is larger counts as poorly known."""


def next_question(outcome: SearchOutcome, limits: RigLimits) -> Mapping[str, Any] | None:
    """Return the proposal for equivalents first, then for a poorly known parameter; None if nothing is open."""
    template = outcome.problem.series[0]
    sigma = float(np.mean(list(outcome.problem.noise.sigma.values())))
    if outcome.is_torque:
        return None
    rounds = {done.winner.name: done for done in outcome.rounds if done.winner is not None}
    for step in outcome.steps[1:]:
        done = rounds.get(str(step.added))
        if done is None:
            # A law that took the place of a richer one was not judged by itself.
            continue
        rivals = {
            c.name: c.state for c in done.contenders if c.name in step.equivalents or c.name == step.added
        }
        if len(rivals) > 1:
            proposal = propose_between(template, list(rivals.values()), list(rivals), sigma, limits)
            if proposal is not None:
                return proposal
    last = outcome.steps[-1].state
    covariance = robust_covariance(outcome.problem, last.fit)
    for i, parameter in enumerate(last.fit.parameters):
        value = abs(float(last.fit.vector[parameter.slot]))
        if parameter.owner in last.added and covariance[i, i] > (POOR_ERROR * value) ** 2:
            return propose_for_parameter(template, last, parameter.owner, sigma, limits)
    return None
