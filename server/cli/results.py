"""Shows finished analyses on the terminal and writes the report of an identification."""

from pathlib import Path

from rich.console import Console

from server.cli.tables import print_comparison
from server.reports.gap_words import describe_gap
from server.reports.write import REPORT_NAME, write_report
from server.services.discrepancy import GapAnalysis
from server.services.identification import Identification


def show_identification(identification: Identification, out: Path, page_name: str = REPORT_NAME) -> None:
    """Print the table, write the report and say where it is."""
    console = Console()
    print_comparison(console, identification.result, identification.train.output[1])
    page = write_report(identification, out, page_name)
    console.print(f"report: {page}", highlight=False, soft_wrap=True)


def show_gap(analysis: GapAnalysis) -> None:
    """Print what the model lacked and where the report is."""
    console = Console()
    for line in describe_gap(analysis):
        console.print(line, highlight=False, markup=False, soft_wrap=True)
    console.print(f"report: {analysis.folder / REPORT_NAME}", highlight=False, soft_wrap=True)
