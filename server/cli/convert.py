"""`jointscope import` and `jointscope export`: other people's files in, other people's files out."""

from pathlib import Path
from typing import Annotated

import typer

from server.errors import InputError, InputLocation

IMPORT_HELP = """Import measured data (CSV, CSV.gz, Parquet, MAT v5 and v7.3, HDF5) as a recording.

Example: [bold]jointscope import log.csv --map current_A=iq --map "speed_rad_s=n[rpm]" -o log.parquet[/bold]
"""
EXPORT_HELP = """Export a recording as CSV, MAT, Parquet, HDF5, MDF4 or MCAP; the ending names the format.

Example: [bold]jointscope export out/run/records/train.parquet --out train.mat[/bold]
"""


def register(app: typer.Typer) -> None:
    """Add both commands."""
    app.command("import", help=IMPORT_HELP)(import_)
    app.command("export", help=EXPORT_HELP)(export)


def import_(
    source: Annotated[Path, typer.Argument(help="File to import.")],
    out: Annotated[Path, typer.Option("--out", "-o", help="Recording to write (.parquet).")],
    mappings: Annotated[
        list[str] | None,
        typer.Option(
            "--map", "-m", metavar="NEW=OLD", help="Rename; NEW=OLD*FACTOR or NEW=OLD\\[UNIT] also converts."
        ),
    ] = None,
    leave_out: Annotated[
        list[str] | None, typer.Option("--leave-out", metavar="COLUMN", help="Do not take this column.")
    ] = None,
    span: Annotated[
        str | None,
        typer.Option("--span", metavar="FROM:TO", help="Take these seconds only, for example 0:30."),
    ] = None,
) -> None:
    """Import one file."""
    from daq.recording.timebase import analyse_time_base
    from server.services.exchange import ImportRequest, import_recording

    request = ImportRequest(
        source=source, mappings=mappings or (), leave_out=leave_out or (), span_s=_parse_span(span)
    )
    recording = import_recording(request, out)
    typer.echo(f"{out}: {recording.n} samples, {recording.duration_s:.6g} s")
    typer.echo(f"  time base: {analyse_time_base(recording.time_s).describe()}")
    typer.echo(f"  columns: {', '.join(recording.columns)}")
    left_out = recording.metadata["source"]["left_out"]
    if left_out:
        typer.echo(f"  left out: {', '.join(left_out)} (rename with --map to take them)")


def export(
    recording: Annotated[Path, typer.Argument(help="Recording to export (.parquet).")],
    out: Annotated[Path, typer.Option("--out", "-o", help="File to write; its ending names the format.")],
) -> None:
    """Export one recording."""
    from server.services.exchange import export_file

    typer.echo(f"written: {export_file(recording, out)}")


def _parse_span(text: str | None) -> tuple[float, float] | None:
    if text is None:
        return None
    first, _, last = text.partition(":")
    try:
        span = float(first or 0.0), float(last or "inf")
    except ValueError:
        span = (0.0, 0.0)
    if not 0.0 <= span[0] < span[1]:
        message = f'"{text}" must read FROM:TO in seconds with FROM below TO, for example 0:30'
        raise InputError(message, InputLocation(field="--span"))
    return span
