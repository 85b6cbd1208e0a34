"""Runs `jointscope gap --fleet` and says what came of it."""

import typer

from server.errors import RunFailedError
from server.services.fleet import FleetRequest, run_fleet

WORDS = {
    "named": "with missing effects named",
    "none": "with nothing missing",
    "unknown": "with something missing that the catalogue does not hold",
    "error": "without an answer",
    "waiting": "not done",
}


def analyse_fleet(request: FleetRequest) -> None:
    """Analyse every joint of the list.

    Raises:
        RunFailedError: at least one joint has no answer.
    """
    outcome = run_fleet(request, typer.echo)
    for name, count in outcome.counts.items():
        if count:
            typer.echo(f"{count:6d} {WORDS[name]}")
    typer.echo(f"summary: {outcome.folder / 'fleet.html'}")
    failed = outcome.counts["error"] + outcome.counts["waiting"]
    if failed:
        raise RunFailedError(
            f"{failed} of {sum(outcome.counts.values())} joints without an answer; each error stands in "
            f"{outcome.folder / 'fleet.csv'}; the same call tries them again"
        )
