"""docs/api.md: its commands run as they stand, in one shell, and answer what the page shows."""

import json
import os
import re
import subprocess
from pathlib import Path
from typing import Any

from tests.server.service.conftest import Service

PAGE = Path(__file__).resolve().parents[3] / "docs" / "api.md"
BLOCK = re.compile(r"^```(sh|json)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
MARK = "=== end of a command ==="


def is_shown(shown: Any, answer: Any) -> bool:  # JSON values
    """Tell whether the answer has all that the page shows; it may have more."""
    if isinstance(shown, dict):
        return isinstance(answer, dict) and all(
            key in answer and is_shown(value, answer[key]) for key, value in shown.items()
        )
    if isinstance(shown, list):
        return isinstance(answer, list) and all(map(is_shown, shown, answer)) and len(shown) <= len(answer)
    return bool(shown == answer)


def test_every_command_answers_what_the_page_shows(service: Service) -> None:
    blocks = BLOCK.findall(PAGE.read_text())
    script = "set -euo pipefail\n"
    for kind, text in blocks:
        script += text if kind == "sh" else f"echo\necho '{MARK}'\n"
    script = re.sub(r"^export JOINTSCOPE=.*$", "", script, flags=re.MULTILINE)
    environment = {**os.environ, "JOINTSCOPE": service.url, "TOKEN": service.admin_token}
    done = subprocess.run(
        ["bash", "-c", script], capture_output=True, text=True, check=False, env=environment, timeout=120
    )
    assert done.returncode == 0, done.stderr
    expected = [json.loads(text) for kind, text in blocks if kind == "json"]
    answers = [json.loads(part) for part in done.stdout.split(MARK)[:-1]]
    for shown, answer in zip(expected, answers, strict=True):
        assert is_shown(shown, answer), (shown, answer)
