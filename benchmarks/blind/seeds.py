"""Seeds of the blind benchmark, written down before anything was scored.

Development seeds may be looked at while the workflow changes; scoring seeds are run when it is finished, and nothing is
changed because of what they show. Every condition (`conditions.py`) owns a block of each: BLOCK seeds from
`base + BLOCK * number`, where number is the condition's own and never changes. Within a block the seed of the k-th case
of the j-th id is `start + PER_ID * j + k`.
"""

from collections.abc import Mapping

DEVELOPMENT_BASE = 1_000_000
SCORING_BASE = 20_000_000
BLOCK = 10_000
PER_ID = 100

SPENT_SCORING = (range(500_000, 500_100), range(600_000, 601_000), range(700_000, 700_400))
"""Scoring seeds of the first workflow; three of them were looked at, so none is used again."""

OPENED: Mapping[str, int] = {
    "full": 45,
    "third": 29,
    "tenth": 26,
    "sine": 13,
    "single": 16,
    "held": 13,
    "two": 25,
    "three": 24,
    "null_emulator": 780,
    "null_white": 740,
    "null_coloured": 520,
    "null_quantised": 120,
    "outside": 63,
    "second_full": 19,
    "second_third": 11,
    "second_tenth": 14,
    "second_sine": 11,
    "second_null": 30,
    "second_outside": 38,
}
"""Scoring cases an id, by condition, whose answers have been opened or whose run was given up; the next scoring begins
behind them."""


def development_seeds(number: int) -> range:
    """Return the development seeds of the condition with this number."""
    start = DEVELOPMENT_BASE + BLOCK * number
    return range(start, start + BLOCK)


def scoring_seeds(number: int) -> range:
    """Return the scoring seeds of the condition with this number."""
    start = SCORING_BASE + BLOCK * number
    return range(start, start + BLOCK)
