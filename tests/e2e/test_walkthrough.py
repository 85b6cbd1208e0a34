"""The walkthrough's code runs as it is printed."""

import doctest
from pathlib import Path

WALKTHROUGH = Path(__file__).parents[2] / "docs" / "walkthrough.md"


def test_the_walkthrough_runs_as_printed() -> None:
    failed, attempted = doctest.testfile(str(WALKTHROUGH), module_relative=False)
    assert attempted > 20
    assert failed == 0
