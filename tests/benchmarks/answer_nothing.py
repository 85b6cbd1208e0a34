"""A solver that answers `none` to everything, for tests of the runner."""

import json
from pathlib import Path

from benchmarks.blind.serve import Request, serve


def handle(request: Request) -> None:
    if sorted(request) != ["question", "verdict"]:
        raise ValueError(f"a solver is told where question and verdict lie, not {sorted(request)}")
    path = Path(request["verdict"]).with_suffix(".json")
    path.parent.mkdir(parents=True, exist_ok=True)
    content = {"verdict": "none", "steps": [], "effects": [], "wall_seconds": 0.1, "cpu_seconds": 0.1}
    path.write_text(json.dumps(content))


if __name__ == "__main__":
    serve(handle)
