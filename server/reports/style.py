"""Colours shared by page and PNG: one for what was measured, one for each estimator.

Okabe and Ito's palette (2008), which stays distinct for colour-blind readers.
"""

MEASURED_COLOUR = "#9a9a9a"
MODEL_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000", "#8c6d00")


def model_colour(number: int) -> str:
    """Return the colour of the estimator with this number; they repeat after eight."""
    return MODEL_COLOURS[number % len(MODEL_COLOURS)]
