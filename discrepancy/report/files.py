"""Write what one analysis found: `gap.json`, the extended `model.yaml`, `report.html`."""

import json
from pathlib import Path

from discrepancy.model.reader import write_model
from discrepancy.report.page import render_report
from discrepancy.result import GapResult


def write_result(result: GapResult, folder: Path) -> None:
    """Write the three files into `folder`, which is created."""
    folder.mkdir(parents=True, exist_ok=True)
    text = json.dumps(result.to_dict(), indent=2, allow_nan=False)
    (folder / "gap.json").write_text(text + "\n", encoding="utf-8")
    write_model(result.model, folder / "model.yaml")
    (folder / "report.html").write_text(render_report(result), encoding="utf-8")
