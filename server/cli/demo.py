"""`jointscope demo`: the paper's campaign, then a rig that hides something, from the serial line to the reports."""

import shutil
from pathlib import Path
from typing import Annotated

import typer

HELP = """Run two campaigns on the emulated controller: the paper's (two 1001 s experiments, three estimators), then
one whose rig has a hidden effect, which the discrepancy workflow names.

Example: [bold]jointscope demo --out out/demo[/bold]
"""
CONFIG = Path(__file__).resolve().parents[2] / "config"
HIDDEN = "hidden"
IDENTIFICATION_PAGE = "identification.html"


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("demo", help=HELP)(demo)


def demo(
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for recordings and reports.")] = Path(
        "out/demo"
    ),
) -> None:
    """Run the demonstration."""
    from server.cli.playing import play
    from server.services.loading import RunChoices, load_plan
    from server.services.run_folder import remove_previous

    paper, hidden = (
        load_plan(
            RunChoices(
                campaign=CONFIG / "campaigns" / f"{campaign}.yaml",
                emulate=CONFIG / "scenarios" / f"{scenario}.yaml",
                speed="max",
            )
        )
        for campaign, scenario in (("paper", "nominal"), ("hidden", "hidden_friction"))
    )
    remove_previous(out / HIDDEN)
    remove_previous(out)
    typer.echo("1. The paper's campaign: which estimator describes the joint best?")
    first = play(paper, out, IDENTIFICATION_PAGE)
    typer.echo("2. A rig that hides an effect: what does the model of the joint lack?")
    [analysis] = play(hidden, out / HIDDEN).gaps
    # The second run's folder stays whole; its answer stands beside that of the first as well.
    for path in analysis.files:
        shutil.copy2(path, out / path.name)
    first.manifest.write(out)
    typer.echo(f"reports: {out / IDENTIFICATION_PAGE} and {out / 'report.html'}")
