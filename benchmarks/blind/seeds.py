"""Seeds of the blind benchmark, written down before anything was scored.

Development seeds may be looked at while the workflow changes; scoring seeds are run when it is finished, and nothing is
changed because of what they show. The second truth (tests/discrepancy/truth) has its own two ranges: nothing is
tuned on it.
"""

DEVELOPMENT = range(1000, 1100)
SCORING = range(500_000, 500_100)
NULL_SCORING = range(600_000, 601_000)
SECOND_TRUTH_DEVELOPMENT = range(1, 400)
SECOND_TRUTH_SCORING = range(700_000, 700_400)
