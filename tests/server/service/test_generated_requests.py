"""A short run of benchmarks/service_schemathesis.py; the long one has thousands of cases."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]


@pytest.mark.slow
def test_generated_requests_get_documented_answers_only() -> None:
    command = [sys.executable, "-m", "benchmarks.service_schemathesis", "--cases", "100", "--quick"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=ROOT)
    assert done.returncode == 0, done.stdout
    found = re.search(r"(\d+) generated, (\d+) passed", done.stdout)
    assert found is not None, done.stdout
    assert int(found[2]) >= 100
