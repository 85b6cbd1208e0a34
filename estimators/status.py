"""Outcome of one estimator step. A step reports; it never raises."""

from enum import Enum


class Status(Enum):
    """What `step` did with a sample; the value is the sentence for a reader."""

    UPDATED = "the sample was used"
    NOT_FINITE = "the sample, or a number that would follow from it, is not finite; the state is as it was"
    WRONG_SHAPE = "phi does not have the estimator's number of regressors; the state is as it was"
