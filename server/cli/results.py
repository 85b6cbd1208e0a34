"""Shows a finished identification on the terminal and writes its report."""

from pathlib import Path

from rich.console import Console

from server.cli.tables import print_comparison
from server.reports.write import write_report
from server.services.identification import Identification


def show_identification(identification: Identification, out: Path) -> None:
    """Print the table, write the report and say where it is."""
    console = Console()
    print_comparison(console, identification.result, identification.train.output[1])
    page = write_report(identification, out)
    console.print(f"report: {page}", highlight=False, soft_wrap=True)
