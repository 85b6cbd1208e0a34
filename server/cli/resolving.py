"""`jointscope gap --resolve`: shows the rounds on the terminal."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from server.cli.playing import stop_on_interrupt
from server.cli.progress import make_listener
from server.cli.results import show_gap
from server.services.resolve import RESOLVE_NAME, Resolution, ResolveRequest, resolve


def resolve_gap(request: ResolveRequest, out: Path) -> None:
    """Run the rounds, with progress, and print their table and the last answer."""
    console = Console()
    with make_listener(console) as listener, stop_on_interrupt() as stop:
        analysis, done = resolve(request, out, listener, stop)
    console.print(rounds_table(done))
    console.print(
        f"{done.ended}: {done.message} ({done.spent_s:g} s of rig time)", highlight=False, soft_wrap=True
    )
    show_gap(analysis)
    console.print(f"rounds: {out / RESOLVE_NAME}", highlight=False, soft_wrap=True)


def rounds_table(done: Resolution) -> Table:
    """Return a line for each round."""
    table = Table("round", "rig time s", "verdict", "effects", "equivalents", "worst std", "asks next")
    for number, one in enumerate(done.rounds):
        effects = one["effects"]
        same = [
            name if isinstance(name, str) else "+".join(name) for e in effects for name in e["equivalents"]
        ]
        table.add_row(
            str(number),
            f"{one['rig_time_s']:g}",
            one["verdict"],
            ", ".join(e["id"] for e in effects) or "-",
            ", ".join(same) or "-",
            _worst(effects),
            _asked(one["experiment"]),
        )
    return table


def _worst(effects: list[Mapping[str, Any]]) -> str:
    """Return the largest standard error of the effects' parameters, as a share of its value."""
    found = [
        abs(q["std"] / q["value"])
        for e in effects
        for q in e["parameters"].values()
        if q["std"] is not None and q["value"]
    ]
    return f"{max(found):.1%}" if found else "-"


def _asked(experiment: Mapping[str, Any] | None) -> str:
    if experiment is None:
        return "-"
    excitation = experiment["excitation"]
    size = f" {excitation['amplitude_A']:g} A" if "amplitude_A" in excitation else ""
    return f"{excitation['kind']}{size}, {experiment['duration_s']:g} s"
