"""Plays a planned campaign for the command line: progress, Ctrl-C, results."""

import contextlib
import signal
import threading
from collections.abc import Iterator
from pathlib import Path

from rich.console import Console

from server.cli.progress import make_listener
from server.cli.results import show_gap, show_identification
from server.cli.tables import print_plan
from server.reports.write import REPORT_NAME
from server.services.campaign import CampaignResult, run_campaign
from server.services.plan import CampaignPlan


def show_plan(plan: CampaignPlan) -> None:
    """Print what the campaign would do."""
    print_plan(Console(), plan)


def play(plan: CampaignPlan, folder: Path, page_name: str = REPORT_NAME) -> CampaignResult:
    """Run a campaign in `folder`, with progress on the terminal and every result printed at the end.

    Args:
        plan: what to do.
        folder: run folder, without an earlier run.
        page_name: what the reports of identifications are called.
    """
    console = Console()
    with make_listener(console) as listener, stop_on_interrupt() as stop:
        result = run_campaign(plan, folder, listener, stop)
    for identification, out in result.identifications:
        show_identification(identification, out, page_name)
    for analysis in result.gaps:
        show_gap(analysis)
    # Once more, for the files of the reports.
    manifest = result.manifest.write(folder)
    console.print(f"run folder: {folder} ({manifest.name})", highlight=False, soft_wrap=True)
    return result


@contextlib.contextmanager
def stop_on_interrupt() -> Iterator[threading.Event]:
    """Turn the first Ctrl-C (or SIGTERM) into a stop request, so that the drive comes to rest in order.

    A second Ctrl-C interrupts at once; the controller then stops by itself when its lease runs out.
    """
    stop = threading.Event()

    def request(number: int, frame: object) -> None:
        if stop.is_set():
            raise KeyboardInterrupt
        stop.set()

    previous = {number: signal.signal(number, request) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield stop
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)
