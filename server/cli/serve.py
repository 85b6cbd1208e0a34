"""`jointscope serve`: the REST service and its page, until Ctrl-C."""

from pathlib import Path
from typing import Annotated

import typer

HELP = """Run the service: REST, live data and pages, until Ctrl-C, which brings every drive to rest first.

Example: [bold]jointscope serve --data out/service --emulate config/scenarios/nominal.yaml[/bold]

The first start with a data folder prints a token for you, once. Further tokens: jointscope token create
"""
DEFAULT_DATA = Path("jointscope-data")
DEFAULT_RIGS = Path("config/rigs")


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("serve", help=HELP)(serve)


def serve(  # noqa: PLR0913  # one parameter for each option of the command
    host: Annotated[
        str,
        typer.Option("--host", help="Address to bind to; beyond this machine only once there are tokens."),
    ] = "127.0.0.1",
    port: Annotated[int, typer.Option("--port", min=0, max=65535, help="0 takes a free one.")] = 8000,
    data: Annotated[
        Path, typer.Option("--data", metavar="DIR", help="Database, recordings, reports.")
    ] = DEFAULT_DATA,
    rigs: Annotated[
        Path | None, typer.Option("--rigs", metavar="DIR", help="Folder of rig files; default config/rigs.")
    ] = None,
    emulate: Annotated[
        Path | None,
        typer.Option("--emulate", metavar="SCENARIO", help="Emulate the rigs whose link.url is `emulate`."),
    ] = None,
    speed: Annotated[
        str,
        typer.Option("--speed", help="Of the emulated controllers: 1 as hardware would, max, or a factor."),
    ] = "1",
    database: Annotated[
        str | None, typer.Option("--database", metavar="URL", help="PostgreSQL instead of a file in --data.")
    ] = None,
    origin: Annotated[
        list[str] | None,
        typer.Option("--origin", help="Web origin that may open live data, besides our own."),
    ] = None,
    wrong_tokens: Annotated[
        int,
        typer.Option("--wrong-tokens", min=1, help="Per minute and address, before it is told to wait."),
    ] = 20,
    max_upload_mib: Annotated[
        int,
        typer.Option(
            "--max-upload-mib", min=1, max=1 << 20, help="Largest measured file that is taken, MiB."
        ),
    ] = 512,
    grace_days: Annotated[
        float,
        typer.Option(
            "--grace-days", min=0.0, max=36500.0, help="Deleted recordings can be taken back for so long."
        ),
    ] = 30.0,
) -> None:
    """Run the service in this process."""
    from server.api.running import Binding, run_service
    from server.errors import InputError, InputLocation
    from server.services.loading import parse_speed
    from server.services.settings import ServiceSettings

    parse_speed(speed)
    if emulate is not None and not emulate.is_file():
        raise InputError("no such scenario file; see config/scenarios/", InputLocation(source=emulate))
    folder = rigs or (DEFAULT_RIGS if DEFAULT_RIGS.is_dir() else None)
    settings = ServiceSettings(
        data_dir=data,
        rigs_dir=folder,
        emulate=emulate,
        speed=speed,
        database_url=database,
        allowed_origins=tuple(origin or ()),
        wrong_tokens_per_minute=wrong_tokens,
        max_upload_octets=max_upload_mib << 20,
        deletion_grace_days=grace_days,
    )
    run_service(settings, Binding(host=host, port=port), typer.echo)
