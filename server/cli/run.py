"""`jointscope run`: play a campaign on a rig and keep everything in a run folder."""

from pathlib import Path
from typing import Annotated

import typer

HELP = """Play a campaign: check every step, record, identify; everything lands in a run folder.

Example: [bold]jointscope run config/campaigns/paper.yaml --emulate config/scenarios/nominal.yaml[/bold]

Ctrl-C brings the drive to rest and keeps what was recorded.
"""


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("run", help=HELP)(run)


def run(  # noqa: PLR0913  # one parameter for each option of the command
    campaign: Annotated[Path, typer.Argument(help="Campaign file, see config/campaigns/.")],
    rig: Annotated[
        Path | None, typer.Option("--rig", help="Rig file; replaces the one that the campaign names.")
    ] = None,
    emulate: Annotated[
        Path | None,
        typer.Option("--emulate", metavar="SCENARIO", help="Use an emulated controller with this scenario."),
    ] = None,
    speed: Annotated[
        str | None, typer.Option("--speed", help="Of the emulated controller: max, 1, or a factor.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="Run folder; default runs/NAME-DATE.")
    ] = None,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Check and predict every step; move nothing.")
    ] = False,
    clear_fault: Annotated[
        bool,
        typer.Option(
            "--clear-fault", help="Clear a latched fault first. See that the rig is safe before you do."
        ),
    ] = False,
) -> None:
    """Run or plan one campaign."""
    from server.cli.playing import play, show_plan
    from server.services.loading import RunChoices, load_plan
    from server.services.run_folder import default_folder, recover_folder, set_aside_previous

    plan = load_plan(
        RunChoices(campaign=campaign, rig=rig, emulate=emulate, speed=speed, clear_fault=clear_fault)
    )
    if dry_run:
        show_plan(plan)
        return
    folder = out or default_folder(plan.campaign.name)
    recover_folder(folder, typer.echo)
    shelf = set_aside_previous(folder)
    if shelf is not None:
        typer.echo(f"an earlier run in this folder was moved to {shelf}")
    play(plan, folder)
