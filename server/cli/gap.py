"""`jointscope gap`: find what a joint's model lacks, name it, add it, show the gap shrink."""

from pathlib import Path
from typing import Annotated

import typer

HELP = """Find what a joint's model lacks: writes gap.json, the extended model.yaml and report.html.

Example: [bold]jointscope gap --model config/models/joint1.yaml --train a.parquet --train b.parquet --test c.parquet
--out out/gap[/bold]

Two training records with the same input show the noise; the test records only score.
"""


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("gap", help=HELP)(gap)


def gap(
    model: Annotated[Path, typer.Option("--model", "-m", help="Model file with the nameplate values.")],
    train: Annotated[list[Path], typer.Option("--train", help="Recording to learn from; may be repeated.")],
    test: Annotated[list[Path], typer.Option("--test", help="Recording that only scores; may be repeated.")],
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for the answer.")],
    jobs: Annotated[
        int | None, typer.Option("--jobs", "-j", min=1, help="Processes; default one for each core.")
    ] = None,
) -> None:
    """Analyse and report."""
    from server.services.discrepancy import GapRequest, run_gap_analysis

    request = GapRequest(model=model, train=tuple(train), test=tuple(test), jobs=jobs)
    analysis = run_gap_analysis(request, out, typer.echo)
    from server.cli.results import show_gap

    show_gap(analysis)
