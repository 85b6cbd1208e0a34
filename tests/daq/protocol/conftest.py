"""Settings of the random tests here: no time limit per example, since no test asserts on wall-clock time."""

from hypothesis import settings

settings.register_profile("no_deadline", deadline=None, print_blob=True)
settings.load_profile("no_deadline")
