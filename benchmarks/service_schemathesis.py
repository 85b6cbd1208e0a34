"""Thousands of generated requests against the running service, by its own OpenAPI document, with all checks.

    python -m benchmarks.service_schemathesis [--cases 2000] [--seed 1] [--database URL] [--quick]

No answer may be a 5xx (but for a rig that does not answer), undocumented, of another shape than documented, or accept
what the document forbids. Sessions, recordings and whatever else operations work on exist, in the state in which they
can succeed (`service_living`). The endless event stream is left out, and disconnecting. Rigs are emulated at full
speed, so that their controllers answer as well. Ends with 1 when something was found.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Set
from pathlib import Path

from benchmarks.service_living import ANSWERS, FINISHED, FRESH, OPERATED, TOKEN, URL, WORKING, World
from benchmarks.service_process import ROOT, BenchService, running_service

# A rig that was disconnected would answer nothing but 409 from then on.
_LEFT_OUT = ("/api/v1/events/stream", "/api/v1/rigs/{rig_id}/disconnect")
# Valid by the document, yet refused for what it means: there the check "a valid request is accepted" takes 422 as well.
# Every other check stays on for these operations, as this one does for all others.
_MAY_BE_REFUSED = {
    "GET /api/v1/campaigns": "`before` must be the id of a campaign that exists",
    "GET /api/v1/sessions": "`before` must be the id of a session that exists",
    "GET /api/v1/recordings": "`cursor` must be one that the service made, `since` within the calendar in UTC",
    "POST /api/v1/campaigns": "the document is YAML text or JSON whose steps are checked against the rig",
    "GET /api/v1/recordings/{recording_id}/samples": "`column` must be one that this recording has",
    "POST /api/v1/discrepancies": "`train` and `test` must be recordings that exist, each named once",
    "POST /api/v1/models": "the document is a model file, whose parameters depend on the model",
    "POST /api/v1/recordings": "the body is a file, which must be what its name says",
    "POST /api/v1/sessions": "each value may be right and the combination not, as divisor with sample_time_s",
    "PUT /api/v1/rigs/{rig_id}/queue": "`order` must name each campaign that waits",
}
# Wrong tokens are among the cases; each must be answered by 401.
_OPTIONS = ("--wrong-tokens", "1000000")
# What generated requests work on: `service_living` replaces ids of sessions, recordings and the like as well.
CONFIG = """[parameters]
"path.rig_id" = "{rig}"
"path.name" = "current_limit_A"
"header.Jointscope-Lease" = "none yet"

[auth.openapi.HTTPBearer]
bearer = "{token}"
"""
_REFUSED = """
[[operations]]
include-name = "{name}"
[operations.checks]
positive_data_acceptance.expected-statuses = ["2xx", "3xx", 401, 403, 404, 409, 422, 429, "5xx"]
"""
_ANALYSIS_S = 600.0


def operations(service: BenchService) -> Set[str]:
    """Return the operations that are tested, as method and path."""
    with service.client() as client:
        paths = client.get("/openapi.json").json()["paths"]
    return {f"{method.upper()} {path}" for path in paths.keys() - set(_LEFT_OUT) for method in paths[path]}


def run(service: BenchService, cases: int, seed: int, *, quick: bool) -> tuple[int, str]:
    """Run at least so many cases; return the exit code and what was printed."""
    tested = operations(service)
    per_operation = max(1, -(-cases // len(tested)))
    with tempfile.TemporaryDirectory(prefix="jointscope-bench-") as folder:
        config, answers = Path(folder) / "schemathesis.toml", Path(folder) / "answers.json"
        config.write_text(
            CONFIG.format(rig=OPERATED, token=service.token)
            + "".join(_REFUSED.format(name=name) for name in _MAY_BE_REFUSED)
        )
        environment = {
            **os.environ,
            "SCHEMATHESIS_HOOKS": "benchmarks.service_living",
            "PYTHONPATH": str(ROOT),
            URL: service.url,
            TOKEN: service.token,
            FINISHED: "none" if quick else finish_analysis(service),
            FRESH: "1" if quick else "3",
            ANSWERS: str(answers),
        }
        command = command_line(service, config, seed, per_operation, quick=quick)
        done = subprocess.run(
            command, capture_output=True, text=True, check=False, cwd=folder, env=environment
        )
        return done.returncode, done.stdout + done.stderr + describe(answers, tested)


def command_line(
    service: BenchService, config: Path, seed: int, per_operation: int, *, quick: bool
) -> list[str]:
    """Return the call of schemathesis."""
    program = str(Path(sys.executable).with_name("schemathesis"))
    command = [program, "--config-file", str(config), "run", f"{service.url}/openapi.json"]
    command += ["--checks", "all", "--seed", str(seed), "--max-examples", str(per_operation)]
    command += ["--request-timeout", "30", "--no-color", "--continue-on-failure"]
    # The boundary cases of every field are by far the most.
    command += ["--phases", "examples,fuzzing" if quick else "examples,coverage,fuzzing"]
    for path in _LEFT_OUT:
        command += ["--exclude-path", path]
    return command


def finish_analysis(service: BenchService) -> str:
    """Run one analysis to its end and return its id, so that its answer and report can be asked for."""
    with service.client() as client:
        made = World(client).analysis()
        deadline_s = time.monotonic() + _ANALYSIS_S
        while time.monotonic() < deadline_s:
            view = client.get(f"/api/v1/discrepancies/{made}").json()
            if view["state"] == "done":
                return made
            if view["state"] == "failed":
                raise RuntimeError(f"the analysis failed: {view['reason']}")
            time.sleep(0.5)
    raise TimeoutError(f"the analysis {made} was not done within {_ANALYSIS_S:g} s")


def describe(answers: Path, tested: Set[str]) -> str:
    """Say how many operations were answered by a success, and list those that were not."""
    counted: dict[str, dict[str, int]] = json.loads(answers.read_text(encoding="utf-8"))
    counted = {
        name: found for name, found in counted.items() if name in tested
    }  # not: methods that there are not
    without = {name: found for name, found in counted.items() if not any(key[0] == "2" for key in found)}
    lines = [f"{name}: {dict(sorted(found.items()))}" for name, found in sorted(without.items())]
    total = sum(sum(found.values()) for found in counted.values())
    head = (
        f"{len(counted) - len(without)} of {len(counted)} operations were answered by a 2xx; {total} answers"
    )
    return "\n".join((head, *(f"  never: {line}" for line in lines)))


def main() -> int:
    """Run once and print what was found."""
    parser = argparse.ArgumentParser(description="Generated requests against the service")
    parser.add_argument("--cases", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--database", help="URL of an empty database of PostgreSQL; SQLite without it.")
    parser.add_argument(
        "--quick",
        action="store_true",
        help="Fewer new sessions, and no whole analysis, which takes a minute.",
    )
    given = parser.parse_args()
    options = (*_OPTIONS, *(("--database", given.database) if given.database else ()))
    with running_service([OPERATED, WORKING], speed="max", options=options) as service:
        code, printed = run(service, given.cases, given.seed, quick=given.quick)
    print(printed)
    return code


if __name__ == "__main__":
    sys.exit(main())
