"""Write the report of an identification: the page and the PNG files, from the same charts."""

from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

from server.reports.charts import identification_charts
from server.reports.page import render_page
from server.reports.png import write_png_files
from server.services.identification import Identification

REPORT_NAME = "report.html"


def write_report(identification: Identification, out: Path, page_name: str = REPORT_NAME) -> Path:
    """Write the page and one PNG for each chart; returns the page's path."""
    result, train, test = identification.result, identification.train, identification.test
    charts = list(identification_charts(result, train, test))
    write_png_files(charts, out)
    moment = datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")
    footer = f"Jointscope {version('jointscope')}, {moment}. All numbers: {identification.json_path.name}."
    page = out / page_name
    page.write_text(render_page(result, train, test, charts, footer), encoding="utf-8")
    return page
