"""When a recorded input acts on the joint, as far as the making of a recording leaves that open."""

from discrepancy.data.series import Series
from discrepancy.model.schema import InputHold, JointModel

LATENCY_S = 1.2e-3


def timing_bounds(model: JointModel, one: Series) -> tuple[float, float] | None:
    """Return how early and how late the input may act, s; None where the model file says what it does."""
    step = one.original_step
    return (-0.5 * step, latest_timing(step)) if model.input_hold is InputHold.AUTO else None


def latest_timing(step: float) -> float:
    """Return the longest delay of the input that the recording's making explains, s.

    A held input acts half a sample late; a digital loop at a fast rate adds a few samples that nobody would call a
    transport delay.
    """
    return max(0.5 * step, min(3.0 * step, LATENCY_S))
