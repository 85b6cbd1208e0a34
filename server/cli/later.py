"""Commands whose names are fixed and whose work comes with a later version: each refuses clearly."""

from collections.abc import Callable

import typer

from server.errors import InputError

LATER = {
    "serve": "the REST service and its page",
    "token": "access tokens of the service",
}


def register(app: typer.Typer) -> None:
    """Add one refusing command for each entry of `LATER`."""
    for name, what in LATER.items():
        # Whatever options the later version will take, this one answers with the refusal.
        settings = {"ignore_unknown_options": True, "allow_extra_args": True}
        text = f"Comes with a later version: {what}.\n\nExample: [bold]jointscope {name}[/bold]"
        app.command(name, help=text, context_settings=settings)(_refusal(name, what))


def _refusal(name: str, what: str) -> Callable[[], None]:
    def refuse() -> None:
        raise InputError(f"{name}: {what} comes with a later version; see CHANGELOG.md for what this one has")

    return refuse
