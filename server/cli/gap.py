"""`jointscope gap`: find what a joint's model lacks, name it, add it, show the gap shrink; for one joint or a fleet."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from server.services.discrepancy import GapRequest

HELP = """Find what a joint's model lacks: writes gap.json, the extended model.yaml and report.html.

Example: [bold]jointscope gap --model config/models/joint1.yaml --train a.parquet --train b.parquet --test c.parquet
--out out/gap[/bold]

Two training records with the same input show the noise; the test records only score.

A fleet: [bold]jointscope gap --fleet joints.csv --out out/fleet[/bold] with the columns joint,model,train,test (several
recordings separated by semicolons, paths relative to the list). Each joint gets a folder of its own; fleet.html,
fleet.csv and fleet.json sum up. A second call skips what is finished. Exit code 0: every joint has an answer; 1: at
least one has none, its error stands in the summary; 2: the list is wrong.

An open question is settled on the rig: [bold]jointscope gap ... --resolve --rig RIG.yaml[/bold] plays the experiment
that the answer proposes, adds its record to the training, and asks again until nothing is open or --budget-s of rig
time or --rounds are spent. With --rig alone the proposal keeps to that rig's limits. Ctrl-C brings the drive to rest.

Work is spread over the cores of this machine (--jobs), or over a Dask cluster (--cluster, extra `cluster`).
"""


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("gap", help=HELP)(gap)


def gap(  # noqa: PLR0913  # one parameter is one option of the command line
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for the answer.")],
    model: Annotated[
        Path | None, typer.Option("--model", "-m", help="Model file with the nameplate values.")
    ] = None,
    train: Annotated[
        list[Path] | None, typer.Option("--train", help="Recording to learn from; may be repeated.")
    ] = None,
    test: Annotated[
        list[Path] | None, typer.Option("--test", help="Recording that only scores; may be repeated.")
    ] = None,
    fleet: Annotated[
        Path | None, typer.Option("--fleet", help="CSV list of joints, instead of --model, --train, --test.")
    ] = None,
    again: Annotated[bool, typer.Option("--again", help="With --fleet: do finished joints again.")] = False,
    jobs: Annotated[
        int | None, typer.Option("--jobs", "-j", min=1, help="Processes; default one for each core.")
    ] = None,
    cluster: Annotated[
        str | None, typer.Option("--cluster", help="Dask scheduler that does the work: tcp://HOST:PORT.")
    ] = None,
    resolve: Annotated[
        bool, typer.Option("--resolve", help="Play the proposed experiments on --rig until nothing is open.")
    ] = False,
    rig: Annotated[Path | None, typer.Option("--rig", help="Rig file: its limits bound proposals.")] = None,
    emulate: Annotated[
        Path | None,
        typer.Option("--emulate", metavar="SCENARIO", help="Use an emulated controller with this scenario."),
    ] = None,
    speed: Annotated[
        str | None, typer.Option("--speed", help="Of the emulated controller: max, 1, or a factor.")
    ] = None,
    budget_s: Annotated[
        float, typer.Option("--budget-s", min=5.0, help="Rig time that --resolve may spend, s.")
    ] = 300.0,
    rounds: Annotated[int, typer.Option("--rounds", min=1, help="Most experiments of --resolve.")] = 4,
) -> None:
    """Analyse and report."""
    if fleet is not None:
        if model is not None or train or test or resolve or rig is not None:
            raise typer.BadParameter("--fleet names models and recordings itself; leave out the others")
        from server.cli.fleet import analyse_fleet
        from server.services.fleet import FleetRequest

        analyse_fleet(FleetRequest(list_file=fleet, out=out, jobs=jobs, cluster=cluster, again=again))
        return
    if model is None or not train or not test:
        raise typer.BadParameter("--model, --train and --test are needed (or --fleet)")
    if again:
        raise typer.BadParameter("--again belongs to --fleet; one joint is always analysed again")
    if rig is None and (resolve or emulate is not None or speed is not None):
        raise typer.BadParameter("--resolve, --emulate and --speed need --rig")
    from server.services.discrepancy import GapRequest

    request = GapRequest(model=model, train=tuple(train), test=tuple(test), jobs=jobs, cluster=cluster)
    if resolve and rig is not None:
        from server.cli.resolving import resolve_gap
        from server.services.resolve import ResolveRequest

        question = ResolveRequest(
            gap=request, rig=rig, emulate=emulate, speed=speed, budget_s=budget_s, rounds=rounds
        )
        resolve_gap(question, out)
        return
    _ask_once(request, (rig, emulate, speed), out)


def _ask_once(
    request: "GapRequest", rig_choices: tuple[Path | None, Path | None, str | None], out: Path
) -> None:
    from dataclasses import replace

    from server.cli.results import show_gap
    from server.services.discrepancy import run_gap_analysis
    from server.services.loading import load_rig

    rig, emulate, speed = rig_choices
    if rig is not None:
        request = replace(request, rig=load_rig(rig, emulate=emulate, speed=speed))
    show_gap(run_gap_analysis(request, out, typer.echo))
