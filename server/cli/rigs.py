"""`jointscope devices` and `jointscope emulate`: what can be connected to, and the emulated controller."""

import os
from pathlib import Path
from typing import Annotated

import typer

from server.errors import InputError, InputLocation

DEVICES_HELP = """List the ports that could lead to a controller.

Example: [bold]jointscope devices --links out/rigs[/bold]
"""
EMULATE_HELP = """Run the emulated controller until Ctrl-C; prints the port to connect to.

Example: [bold]jointscope emulate --scenario config/scenarios/nominal.yaml --link out/rigs/joint1[/bold]

Then set link.url of a rig file to that link. Hidden effects to find: --sealed 7 --answer out/answer.json
"""


def register(app: typer.Typer) -> None:
    """Add both commands."""
    app.command("devices", help=DEVICES_HELP)(devices)
    app.command("emulate", help=EMULATE_HELP)(emulate)


def devices(
    links: Annotated[
        list[Path] | None,
        typer.Option("--links", metavar="FOLDER", help="Also list links made by `emulate --link` in here."),
    ] = None,
) -> None:
    """List ports."""
    from daq.driver.discovery import list_devices

    found = list_devices(tuple(links or ()))
    if not found:
        typer.echo("no serial port found; check the cable, or start `jointscope emulate`")
    for device in found:
        serial = f"  serial number {device.serial_number}" if device.serial_number else ""
        warning = f"  warning: {device.warning}" if device.warning else ""
        typer.echo(f"{device.url}  {device.description}{serial}{warning}")


def emulate(
    scenario: Annotated[
        Path | None, typer.Option("--scenario", "-s", help="Scenario file, see config/scenarios/.")
    ] = None,
    link: Annotated[
        Path | None, typer.Option("--link", help="Make this link to the pseudo-terminal.")
    ] = None,
    speed: Annotated[
        str,
        typer.Option("--speed", help="1: as hardware would; max: as fast as the host reads; or a factor."),
    ] = "1",
    sealed: Annotated[
        int | None, typer.Option("--sealed", metavar="SEED", help="Draw hidden effects from this seed.")
    ] = None,
    answer: Annotated[Path | None, typer.Option("--answer", help="With --sealed: what was drawn.")] = None,
) -> None:
    """Become the emulated controller's process."""
    if scenario is None and sealed is None:
        raise InputError("emulate: give --scenario FILE, or --sealed SEED with --answer FILE")
    if (sealed is None) != (answer is None):
        raise InputError("emulate: --sealed SEED and --answer FILE belong together")
    if scenario is not None and not scenario.is_file():
        raise InputError("no such scenario file; see config/scenarios/", InputLocation(source=scenario))
    from server.services.emulator import emulator_command
    from server.services.loading import parse_speed

    parse_speed(speed)
    given = {"--scenario": scenario, "--speed": speed, "--link": link, "--sealed": sealed, "--answer": answer}
    extra = [text for name, value in given.items() if value is not None for text in (name, str(value))]
    command = emulator_command(extra)
    # The same process goes on, so signals and the terminal reach the emulator itself.
    os.execv(command[0], command)
