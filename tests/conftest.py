"""Fixtures shared by all tests: leftover threads fail the test that left them."""

import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

# A plain `pytest` does not put the project's root on the path; `tests.*`, `benchmarks` and `examples` are found there.
sys.path.insert(0, str(Path(__file__).parents[1]))

pytest_plugins = [
    "pytester"
]  # for the tests of our own plugin; pytest takes this line only in the topmost conftest


@pytest.fixture(autouse=True)
def fail_on_leftover_threads() -> Iterator[None]:
    """Fail a test that ends with more threads than it started with."""
    before = set(threading.enumerate())
    yield
    leftover = [thread for thread in threading.enumerate() if thread not in before and thread.is_alive()]
    for thread in leftover:
        thread.join(timeout=2.0)
    still_there = [thread.name for thread in leftover if thread.is_alive()]
    if still_there:
        pytest.fail(f"threads left running: {still_there}")
