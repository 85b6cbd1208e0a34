"""docs/operator.md as a new operator follows it: every shell block, in order, against a running service."""

import json
import os
import re
import subprocess
from pathlib import Path

import pytest

from tests.server.service.conftest import Service

PAGE = Path(__file__).resolve().parents[3] / "docs" / "operator.md"


@pytest.mark.slow
def test_the_operators_page_leads_to_an_identified_joint(service: Service, tmp_path: Path) -> None:
    blocks = re.findall(r"```sh\n(.*?)```", PAGE.read_text(encoding="utf-8"), flags=re.DOTALL)
    script = "set -eu\n" + "\n".join(blocks)
    environment = {**os.environ, "URL": service.url, "TOKEN": service.admin_token}
    done = subprocess.run(
        ["sh", "-c", script],
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
        env=environment,
        timeout=120,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "the session is done" in done.stdout
    methods = json.loads((tmp_path / "identification.json").read_text(encoding="utf-8"))["methods"]
    assert list(methods) == ["rls", "erls", "rls_kf"]
    assert "free run on the test record, adjusted R2: 0.99" in done.stdout
