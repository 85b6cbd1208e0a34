"""The code of docs/client.md runs as printed, and names nothing that is not there."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from jointscope_client import errors
from jointscope_client.emulated_service import EmulatedRig
from tests.server.service.measured import MODEL, as_csv, measured_columns

DOCS = Path(__file__).resolve().parents[2] / "docs"
TEXT = (DOCS / "client.md").read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_code_of_the_client_page_runs_as_printed(emulated_rig: EmulatedRig, tmp_path: Path) -> None:
    for seed, name in ((1, "measured"), (2, "other")):
        columns = measured_columns(seed)
        columns["i"] = columns.pop("current_A") * 1000.0
        (tmp_path / f"{name}.csv").write_bytes(as_csv(columns))
    (tmp_path / "model.yaml").write_text(MODEL)
    code = "\n".join(re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL))
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tmp_path,
        env={**os.environ, "JOINTSCOPE_URL": emulated_rig.url, "JOINTSCOPE_TOKEN": emulated_rig.token},
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
    assert "emulated connected idle" in done.stdout
    assert "column torque_Nm -> it has time_s, speed_rad_s, current_A" in done.stdout
    assert (tmp_path / "measured.mat").stat().st_size > 10_000
    assert (tmp_path / "report.html").read_text().startswith("<!doctype html>")


def test_every_error_of_the_table_is_there() -> None:
    named = re.findall(r"`(\w+Error)`", TEXT)
    assert len(set(named)) >= 9
    assert [name for name in named if not hasattr(errors, name)] == []
