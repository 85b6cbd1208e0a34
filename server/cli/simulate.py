"""`jointscope simulate`: a joint model in free run over a recording's input, beside what was measured."""

from pathlib import Path
from typing import Annotated

import typer

HELP = """Simulate a model over the input of a recording; prints the error and writes simulated beside measured.

Example: [bold]jointscope simulate --model config/models/joint1.yaml --input a.parquet --out sim.csv --plot[/bold]
"""


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("simulate", help=HELP)(simulate)


def simulate(
    model: Annotated[Path, typer.Option("--model", "-m", help="Model file; gap's model.yaml is one.")],
    recording: Annotated[Path, typer.Option("--input", "-i", help="Recording whose input drives it.")],
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="File to write; its ending names the format.")
    ] = None,
    plot: Annotated[
        bool, typer.Option("--plot", help="Draw a PNG beside --out, or NAME_simulated.png here without it.")
    ] = False,
) -> None:
    """Simulate one recording."""
    from server.services.simulation import run_simulation, write_simulation

    simulation = run_simulation(model, recording)
    record = simulation.record
    typer.echo(f"{simulation.model_name} over {record.time_s.size:,} samples, {record.time_s[-1]:.6g} s")
    for name, (error, share) in record.rms_errors().items():
        typer.echo(f"  {name}: rms error {error:.4g} {simulation.units[name]}, {share:.2%} of the signal")
    for name in record.simulated.keys() - record.measured.keys():
        typer.echo(f"  {name}: not in the recording, nothing to compare with")
    if out is not None:
        typer.echo(f"written: {write_simulation(simulation, out)}")
    if plot:
        from server.reports.png import write_png_files
        from server.reports.simulation_chart import simulation_chart

        folder, key = (Path(), f"{recording.stem}_simulated") if out is None else (out.parent, out.stem)
        [picture] = write_png_files([simulation_chart(simulation, key)], folder)
        typer.echo(f"plot: {picture}")
