"""`jointscope identify`: compare estimators on two recordings."""

from pathlib import Path
from typing import Annotated

import typer

HELP = """Identify a joint from a training and a test recording; writes identification.json and a report.

Example: [bold]jointscope identify --train train.parquet --test test.parquet --out out/id[/bold]

Other columns: [bold]--input motor_force_N --output speed_m_s[/bold]; a missing speed is derived.
"""


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("identify", help=HELP)(identify)


def identify(  # noqa: PLR0913  # one parameter for each option of the command
    train: Annotated[Path, typer.Option("--train", help="Recording to learn from.")],
    test: Annotated[Path, typer.Option("--test", help="Recording that only scores.")],
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for identification.json and the report.")],
    sample_time: Annotated[
        float, typer.Option("--sample-time", metavar="S", help="Sample time of the models in s.")
    ] = 0.2,
    order: Annotated[int, typer.Option("--order", help="Past outputs and inputs of the models.")] = 2,
    delay: Annotated[int, typer.Option("--delay", help="Samples from the input to its first effect.")] = 1,
    methods: Annotated[
        str, typer.Option("--methods", help="Estimators, separated by commas.")
    ] = "rls,erls,rls_kf",
    option: Annotated[
        list[str] | None,
        typer.Option(
            "--option", metavar="NAME=VALUE", help="Of the estimators, for example forgetting=0.99."
        ),
    ] = None,
    input_column: Annotated[
        str | None,
        typer.Option("--input", metavar="COLUMN", help="Input; default current_ref_A, else current_A."),
    ] = None,
    output_column: Annotated[str, typer.Option("--output", metavar="COLUMN", help="Output.")] = "speed_rad_s",
) -> None:
    """Identify and report."""
    from server.services.dataset import Signals
    from server.services.identification import IdentifyRequest, run_identification

    request = IdentifyRequest(
        train=train,
        test=test,
        sample_time_s=sample_time,
        order=order,
        delay=delay,
        methods=tuple(name.strip() for name in methods.split(",") if name.strip()),
        options=_read_options(option or []),
        signals=Signals(input=input_column, output=output_column),
    )
    identification = run_identification(request, out, typer.echo)
    # Everything below is needed only after the numbers are there.
    from server.cli.results import show_identification

    show_identification(identification, out)


def _read_options(texts: list[str]) -> dict[str, float]:
    from server.errors import InputError, InputLocation

    options = {}
    for text in texts:
        name, _, value = text.partition("=")
        try:
            options[name] = float(value)
        except ValueError:
            where = InputLocation(field="--option")
            raise InputError(f"{text!r} is not NAME=NUMBER, for example forgetting=0.99", where) from None
    return options
