"""`jointscope demo`: the paper's campaign on the emulated rig, from the serial line to the report."""

from pathlib import Path
from typing import Annotated

import typer

HELP = """Run the paper's campaign on the emulated controller: two 1001 s experiments, then three estimators.

Example: [bold]jointscope demo --out out/demo[/bold]
"""
CONFIG = Path(__file__).resolve().parents[2] / "config"


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("demo", help=HELP)(demo)


def demo(
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for recordings and report.")] = Path(
        "out/demo"
    ),
) -> None:
    """Run the demonstration."""
    from server.cli.playing import play
    from server.services.loading import RunChoices, load_plan
    from server.services.run_folder import remove_previous

    choices = RunChoices(
        campaign=CONFIG / "campaigns" / "paper.yaml",
        emulate=CONFIG / "scenarios" / "nominal.yaml",
        speed="max",
    )
    plan = load_plan(choices)
    remove_previous(out)
    play(plan, out)
