"""`jointscope token`: make, list and revoke access tokens of a service's data folder."""

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from server.cli.serve import DEFAULT_DATA

if TYPE_CHECKING:
    from server.storage.database import Database

HELP = """Access tokens of the service: make, list, revoke. A running service notices within two seconds.

Example: [bold]jointscope token create --name "bench 2" --scope run --data out/service[/bold]
"""
DataOption = Annotated[Path, typer.Option("--data", metavar="DIR", help="The service's data folder.")]
DatabaseOption = Annotated[
    str | None, typer.Option("--database", metavar="URL", help="PostgreSQL instead of a file in --data.")
]


def register(app: typer.Typer) -> None:
    """Add the commands."""
    group = typer.Typer(help=HELP, no_args_is_help=True, rich_markup_mode="rich")
    group.command("create")(create)
    group.command("list")(list_tokens)
    group.command("revoke")(revoke)
    app.add_typer(group, name="token")


def create(
    name: Annotated[str, typer.Option("--name", help="Who uses it; stands in the audit log.")],
    scope: Annotated[
        list[str] | None, typer.Option("--scope", help="read, run, arm or admin; each contains those before.")
    ] = None,
    days: Annotated[float | None, typer.Option("--days", min=0.001, help="It ends after so long.")] = None,
    data: DataOption = DEFAULT_DATA,
    database: DatabaseOption = None,
) -> None:
    """Make a token and print its secret, once.

    Example: jointscope token create --name "bench 2" --scope run
    """
    from server.errors import InputError, InputLocation
    from server.services.tokens import Scope, TokenService

    wrong = [text for text in scope or () if text not in tuple(Scope)]
    if wrong:
        known = ", ".join(Scope)
        raise InputError(f'"{wrong[0]}" is no scope; allowed: {known}', InputLocation(field="--scope"))
    scopes = tuple(Scope(text) for text in scope or ("read",))
    with _database(data, database) as opened:
        made = TokenService(opened).create(name, scopes, None if days is None else days * 86400.0)
    typer.echo(made.secret)
    typer.echo(f"id {made.info.id}, scopes {', '.join(made.info.scopes)}; shown this once", err=True)


def list_tokens(data: DataOption = DEFAULT_DATA, database: DatabaseOption = None) -> None:
    """List all tokens, revoked ones included.

    Example: jointscope token list
    """
    from server.services.tokens import TokenService

    with _database(data, database) as opened:
        tokens = TokenService(opened).list()
    if not tokens:
        typer.echo("no tokens yet; make one by: jointscope token create --name NAME --scope admin")
    for token in tokens:
        state = "revoked" if token.revoked_at else f"until {token.expires_at or 'revoked'}"
        typer.echo(f"{token.id}  {token.name}  {','.join(token.scopes)}  {state}")


def revoke(
    token_id: Annotated[str, typer.Argument(metavar="ID", help="As `token list` shows it.")],
    data: DataOption = DEFAULT_DATA,
    database: DatabaseOption = None,
) -> None:
    """Make a token useless from now on.

    Example: jointscope token revoke Xb3kQ9aZ
    """
    from server.services.tokens import TokenService

    with _database(data, database) as opened:
        info = TokenService(opened).revoke(token_id)
    typer.echo(f"{info.id} ({info.name}) is revoked")


@contextlib.contextmanager
def _database(data: Path, url: str | None) -> "Iterator[Database]":
    from server.services.container import open_database_of
    from server.services.settings import ServiceSettings

    database = open_database_of(ServiceSettings(data_dir=data, database_url=url))
    try:
        yield database
    finally:
        database.close()
